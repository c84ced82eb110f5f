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

    /// Number of residuals that count.
    fn residuals(&self) -> usize;

    /// Calls `sink` in the order of time with the index of the independent stretch, the residuals' `J_k^T r_k` of one
    /// instant and the sum of their squares.
    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64));
}

/// Widest Jacobian row there is a specialised rollout for.
pub const MOST_DIRECTIONS: usize = 32;

/// Runs `$body` with the constant `$width` set to the smallest compiled number of directions that holds `$count`. Few, because
/// every simulation is compiled for each of them; widths beyond what `$most` (a constant of the system's type) can ask for are
/// not compiled at all.
macro_rules! with_width {
    ($most:expr, $count:expr, $width:ident => $body:expr) => {
        match $count {
            0..=8 => {
                const $width: usize = 8;
                $body
            }
            9..=12 if const { $most > 8 } => {
                const $width: usize = 12;
                $body
            }
            13..=20 if const { $most > 12 } => {
                const $width: usize = 20;
                $body
            }
            _ if const { $most > 20 } => {
                const $width: usize = $crate::fit::MOST_DIRECTIONS;
                $body
            }
            count => unreachable!("{count} directions, but the system promises {} at most", $most),
        }
    };
}
pub(crate) use with_width;
