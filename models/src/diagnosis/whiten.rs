//! Generalised least squares for what is allowed to wander.
//!
//! In every block the start pressure is uncertain (what happened before it) and the supply wanders by about 1 %. Both are low-rank
//! contributions to the residual's covariance, `sigma^2 I + D T D^T` with `D` the derivatives of the readings, so that a block is
//! whitened by shrinking its part within the span of `D`: `v - U (1 - sqrt(sigma^2 / (sigma^2 + s_i))) U^T v`.

use nalgebra::{DMatrix, SymmetricEigen};

use super::channel::ChannelData;

/// Standard deviation of a block's start pressure, kPa, at most: what earlier wander leaves behind ...
const START_KPA: f64 = 10.0;
/// ... and as a part of the range over which the pressure moves.
const START_SHARE: f64 = 0.05;
/// Standard deviation of the supply's level in a block, as a part of its gauge pressure.
const LEVEL: f64 = 0.012;
/// Standard deviation of the supply's change over half a block.
const SLOPE: f64 = 0.008;

/// What one standard deviation of the supply's level and of its change in a block does to a reading, kPa, from its derivatives.
#[must_use]
pub fn wander(derivatives: &[f64; 3]) -> [f64; 2] {
    [derivatives[1] * LEVEL, derivatives[2] * SLOPE]
}

/// Weights of one channel.
#[derive(Debug, Clone)]
pub struct Whitening {
    /// Orthonormal directions at each compared row.
    directions: Vec<[f64; 3]>,
    /// How much of each direction is taken out, block by block.
    shrink: Vec<[f64; 3]>,
    spans: Vec<std::ops::Range<usize>>,
}

impl Whitening {
    /// From the derivatives by a block's disturbances.
    #[must_use]
    pub fn new(data: &ChannelData, derivatives: &[[f64; 3]]) -> Self {
        Self::scaled(data, derivatives, [start_kpa(data), LEVEL, SLOPE])
    }

    /// Takes out the start pressure only, entirely: what is left is the error of a rollout that starts right.
    #[must_use]
    pub fn start_only(data: &ChannelData, derivatives: &[[f64; 3]]) -> Self {
        Self::scaled(data, derivatives, [1e3, 0.0, 0.0])
    }

    fn scaled(data: &ChannelData, derivatives: &[[f64; 3]], deviations: [f64; 3]) -> Self {
        let variance = data.noise_kpa * data.noise_kpa;
        let mut directions = vec![[0.0; 3]; derivatives.len()];
        let mut shrink = Vec::with_capacity(data.spans.len());
        for span in &data.spans {
            let rows = &derivatives[span.clone()];
            let gram = DMatrix::from_fn(3, 3, |i, j| {
                rows.iter().map(|d| d[i] * d[j]).sum::<f64>() * deviations[i] * deviations[j]
            });
            let eigen = SymmetricEigen::new(gram);
            let mut factors = [0.0; 3];
            for k in 0..3 {
                let strength = eigen.eigenvalues[k];
                if !(strength > 1e-9 * variance) {
                    continue;
                }
                factors[k] = 1.0 - (variance / (variance + strength)).sqrt();
                let column = eigen.eigenvectors.column(k);
                for (direction, d) in directions[span.clone()].iter_mut().zip(rows) {
                    let value: f64 = (0..3).map(|i| d[i] * deviations[i] * column[i]).sum();
                    direction[k] = value / strength.sqrt();
                }
            }
            shrink.push(factors);
        }
        Self { directions, shrink, spans: data.spans.clone() }
    }

    /// Whitens a series over the compared rows.
    pub fn apply(&self, series: &mut [f64]) {
        self.apply_columns(series, 1);
    }

    /// Whitens every column of a matrix stored row by row.
    pub fn apply_columns(&self, matrix: &mut [f64], columns: usize) {
        let mut sums = vec![[0.0; 3]; columns];
        for (span, shrink) in self.spans.iter().zip(&self.shrink) {
            sums.fill([0.0; 3]);
            for row in span.clone() {
                let u = &self.directions[row];
                for (sum, value) in sums.iter_mut().zip(&matrix[row * columns..(row + 1) * columns]) {
                    for k in 0..3 {
                        sum[k] += u[k] * value;
                    }
                }
            }
            for row in span.clone() {
                let u = &self.directions[row];
                let scaled = [u[0] * shrink[0], u[1] * shrink[1], u[2] * shrink[2]];
                for (sum, value) in sums.iter().zip(&mut matrix[row * columns..(row + 1) * columns]) {
                    *value -= scaled[0] * sum[0] + scaled[1] * sum[1] + scaled[2] * sum[2];
                }
            }
        }
    }
}

/// Standard deviation of a block's start pressure, kPa.
fn start_kpa(data: &ChannelData) -> f64 {
    let (low, high) =
        data.measured_kpa.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), p| (l.min(*p), h.max(*p)));
    // A channel without a compared row has no range.
    if low < high { (START_SHARE * (high - low)).min(START_KPA) } else { START_KPA }
}
