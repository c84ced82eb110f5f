//! What a least-squares solver sees of a problem.

use nalgebra::DVector;

use super::Normal;

/// A sum of squared residuals over coordinates.
pub trait Objective: Sync {
    /// Number of coordinates.
    fn dimension(&self) -> usize;

    /// Bounds of each coordinate.
    fn bounds(&self) -> Vec<(f64, f64)>;

    /// Coordinates of the first start.
    fn nominal(&self) -> Vec<f64>;

    /// The normal equations at the given coordinates; not finite where the simulation runs away.
    fn normal(&self, coordinates: &[f64]) -> Normal;

    /// As [`normal`](Self::normal) where a search that may evaluate no further looks for the last
    /// time: whoever needs nothing but the coordinates may leave gradient and matrix at zero.
    fn last(&self, coordinates: &[f64]) -> Normal {
        self.normal(coordinates)
    }

    /// Number of residuals that count.
    fn residuals(&self) -> usize;

    /// Calls `sink` in the order of time with the index of the independent stretch, the residuals'
    /// `J_k^T r_k` of one instant and the sum of their squares.
    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64));
}
