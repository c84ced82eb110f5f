//! Generalised least squares for what is allowed to wander.
//!
//! In every block the start pressure is uncertain (what happened before it), the supply wanders by
//! about 1 %, and flows are not known to better than a percent. All are low-rank contributions to
//! the residual's covariance, `sigma^2 I + D T D^T` with `D` the derivatives of the readings, so
//! that a block is whitened by shrinking its part within the span of `D`:
//! `v - U (1 - sqrt(sigma^2 / (sigma^2 + s_i))) U^T v`. It is the model's discrepancy in the sense
//! of Kennedy and O'Hagan (J. R. Stat. Soc. B 63, 2001), where physics puts it: without it
//! parameters move to imitate what the model lacks.

use crate::diagnosis::settings::SETTINGS;
use multiversion::multiversion;
use nalgebra::{DMatrix, SymmetricEigen};

use super::random_effects::DISTURBANCES;
use crate::diagnosis::channel::ChannelData;

/// Number of disturbances beside a block's start pressure.
pub const WANDERS: usize = DISTURBANCES - 1;

/// What one standard deviation of each disturbance beside the start pressure does to a reading,
/// kPa, from its derivatives.
#[must_use]
pub fn wander(derivatives: &[f64; DISTURBANCES]) -> [f64; WANDERS] {
    let deviations = deviations(0.0);
    std::array::from_fn(|k| derivatives[k + 1] * deviations[k + 1])
}

fn deviations(start_kpa: f64) -> [f64; DISTURBANCES] {
    let mut all = [SETTINGS.flow; DISTURBANCES];
    (all[0], all[1], all[2]) = (start_kpa, SETTINGS.supply_level, SETTINGS.supply_slope);
    all
}

/// Weights of one channel.
#[derive(Debug, Clone)]
pub struct Whitening {
    /// Orthonormal directions at each compared row.
    directions: Vec<[f64; DISTURBANCES]>,
    /// The same, each by how much of it is taken out.
    taken: Vec<[f64; DISTURBANCES]>,
    spans: Vec<std::ops::Range<usize>>,
}

impl Whitening {
    /// From the derivatives by a block's disturbances.
    #[must_use]
    pub fn new(data: &ChannelData, derivatives: &[[f64; DISTURBANCES]]) -> Self {
        Self::scaled(data, derivatives, deviations(start_kpa(data)), data.noise_kpa)
    }

    /// The same beside an error of this standard deviation, kPa, in the place of the noise: where a
    /// model is far off, what wanders is small beside that, and its directions are not free to hide
    /// the error.
    #[must_use]
    pub fn beside_error(data: &ChannelData, derivatives: &[[f64; DISTURBANCES]], error_kpa: f64) -> Self {
        Self::scaled(data, derivatives, deviations(start_kpa(data)), error_kpa)
    }

    /// Takes out the start pressure only, entirely: what is left is the error of a rollout that
    /// starts right.
    #[must_use]
    pub fn start_only(data: &ChannelData, derivatives: &[[f64; DISTURBANCES]]) -> Self {
        let mut deviations = [0.0; DISTURBANCES];
        deviations[0] = 1e3;
        Self::scaled(data, derivatives, deviations, data.noise_kpa)
    }

    fn scaled(
        data: &ChannelData,
        derivatives: &[[f64; DISTURBANCES]],
        deviations: [f64; DISTURBANCES],
        noise_kpa: f64,
    ) -> Self {
        let variance = noise_kpa * noise_kpa;
        let mut directions = vec![[0.0; DISTURBANCES]; derivatives.len()];
        let mut taken = directions.clone();
        for span in &data.spans {
            let rows = &derivatives[span.clone()];
            let gram = DMatrix::from_fn(DISTURBANCES, DISTURBANCES, |i, j| {
                rows.iter().map(|d| d[i] * d[j]).sum::<f64>() * deviations[i] * deviations[j]
            });
            let eigen = SymmetricEigen::new(gram);
            let mut factors = [0.0; DISTURBANCES];
            for k in 0..DISTURBANCES {
                let strength = eigen.eigenvalues[k];
                if !(strength > 1e-9 * variance) {
                    continue;
                }
                factors[k] = 1.0 - (variance / (variance + strength)).sqrt();
                let column = eigen.eigenvectors.column(k);
                for (direction, d) in directions[span.clone()].iter_mut().zip(rows) {
                    let value: f64 = (0..DISTURBANCES).map(|i| d[i] * deviations[i] * column[i]).sum();
                    direction[k] = value / strength.sqrt();
                }
            }
            for row in span.clone() {
                taken[row] = std::array::from_fn(|k| directions[row][k] * factors[k]);
            }
        }
        Self { directions, taken, spans: data.spans.clone() }
    }

    /// Whitens a series over the compared rows.
    pub fn apply(&self, series: &mut [f64]) {
        self.apply_columns(series, 1);
    }

    /// Whitens every column of a matrix stored row by row.
    pub fn apply_columns(&self, matrix: &mut [f64], columns: usize) {
        for span in &self.spans {
            let block = &mut matrix[span.start * columns..span.end * columns];
            whiten(block, columns, &self.directions[span.clone()], &self.taken[span.clone()]);
        }
    }
}

/// Whitens a block's columns, four at a time, then the rest: most of what the search
/// computes beside simulations.
#[multiversion(targets("x86_64+avx2"))]
fn whiten(
    block: &mut [f64],
    columns: usize,
    directions: &[[f64; DISTURBANCES]],
    taken: &[[f64; DISTURBANCES]],
) {
    let fours = columns / 4;
    for four in 0..fours {
        whiten_some::<4>(block, columns, 4 * four, directions, taken);
    }
    let mut column = 4 * fours;
    if column + 1 < columns {
        whiten_some::<2>(block, columns, column, directions, taken);
        column += 2;
    }
    if column < columns {
        whiten_some::<1>(block, columns, column, directions, taken);
    }
}

/// Takes out of `N` columns from `first` on what lies along the directions. Loops over indices:
/// iterators here stay calls, one an element.
#[inline(always)]
fn whiten_some<const N: usize>(
    block: &mut [f64],
    columns: usize,
    first: usize,
    directions: &[[f64; DISTURBANCES]],
    taken: &[[f64; DISTURBANCES]],
) {
    let mut sums = [[0.0; N]; DISTURBANCES];
    for row in 0..directions.len() {
        let (u, values) = (directions[row], &block[row * columns + first..][..N]);
        for k in 0..DISTURBANCES {
            for i in 0..N {
                sums[k][i] += u[k] * values[i];
            }
        }
    }
    for row in 0..taken.len() {
        let (u, values) = (taken[row], &mut block[row * columns + first..][..N]);
        let mut along = [0.0; N];
        for k in 0..DISTURBANCES {
            for i in 0..N {
                along[i] += u[k] * sums[k][i];
            }
        }
        for i in 0..N {
            values[i] -= along[i];
        }
    }
}

/// Standard deviation of a block's start pressure, kPa.
fn start_kpa(data: &ChannelData) -> f64 {
    let (low, high) =
        data.measured_kpa.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), p| (l.min(*p), h.max(*p)));
    // A channel without a compared row has no range.
    if low < high {
        (SETTINGS.start_share * (high - low)).min(SETTINGS.start_kpa)
    } else {
        SETTINGS.start_kpa
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, DVector};

    use super::*;
    use crate::diagnosis::testing::{channel, normals};

    /// Two blocks with derivatives of no particular kind.
    const SPANS: [std::ops::Range<usize>; 2] = [0..9, 9..21];
    const ROWS: usize = 21;

    fn blocks() -> (ChannelData, Vec<[f64; DISTURBANCES]>) {
        let (mut data, _) = channel(false);
        data.spans = SPANS.to_vec();
        let numbers = normals(1, DISTURBANCES * ROWS);
        let mut sizes = [80.0; DISTURBANCES];
        (sizes[0], sizes[1], sizes[2]) = (0.3, 40.0, 60.0);
        let row = |k: usize| std::array::from_fn(|i| sizes[i] * numbers[DISTURBANCES * k + i]);
        (data, (0..ROWS).map(row).collect())
    }

    /// The covariance of a block's residuals, kPa^2.
    fn covariance(data: &ChannelData, derivatives: &[[f64; DISTURBANCES]]) -> DMatrix<f64> {
        let deviations = deviations(start_kpa(data));
        DMatrix::from_fn(derivatives.len(), derivatives.len(), |i, j| {
            let product = |k: usize| derivatives[i][k] * derivatives[j][k] * deviations[k].powi(2);
            let wander: f64 = (0..DISTURBANCES).map(product).sum();
            wander + if i == j { data.noise_kpa * data.noise_kpa } else { 0.0 }
        })
    }

    /// The whitening of one block as a matrix.
    fn matrix(whitening: &Whitening, span: &std::ops::Range<usize>) -> DMatrix<f64> {
        let column = |k: usize| {
            let mut unit = vec![0.0; ROWS];
            unit[k] = 1.0;
            whitening.apply(&mut unit);
            assert!(unit.iter().enumerate().all(|(row, v)| span.contains(&row) || *v == 0.0), "other blocks");
            DVector::from_column_slice(&unit[span.clone()])
        };
        DMatrix::from_columns(&span.clone().map(column).collect::<Vec<_>>())
    }

    #[test]
    fn whitening_turns_the_covariance_into_that_of_white_noise() {
        let (data, derivatives) = blocks();
        let whitening = Whitening::new(&data, &derivatives);
        for span in SPANS {
            let w = matrix(&whitening, &span);
            let white = &w * covariance(&data, &derivatives[span.clone()]) * w.transpose();
            let variance = data.noise_kpa * data.noise_kpa;
            let error = (white / variance - DMatrix::identity(span.len(), span.len())).abs().max();
            assert!(error < 1e-10, "{error:e}");
            // It does something.
            assert!((w - DMatrix::identity(span.len(), span.len())).abs().max() > 0.1);
        }
    }

    #[test]
    fn whitened_draws_have_the_identity_for_their_covariance() {
        const DRAWS: usize = 20_000;
        let (data, derivatives) = blocks();
        let whitening = Whitening::new(&data, &derivatives);
        let factors: Vec<DMatrix<f64>> = SPANS
            .iter()
            .map(|span| Cholesky::new(covariance(&data, &derivatives[span.clone()])).unwrap().l())
            .collect();
        let numbers = normals(2, DRAWS * ROWS);
        let mut sum = DMatrix::<f64>::zeros(ROWS, ROWS);
        for draw in numbers.chunks(ROWS) {
            let mut series = Vec::with_capacity(ROWS);
            for (span, factor) in SPANS.iter().zip(&factors) {
                series
                    .extend_from_slice((factor * DVector::from_column_slice(&draw[span.clone()])).as_slice());
            }
            whitening.apply(&mut series);
            let series = DVector::from_vec(series) / data.noise_kpa;
            sum += &series * series.transpose();
        }
        let error = (sum / DRAWS as f64 - DMatrix::identity(ROWS, ROWS)).abs().max();
        // Standard error of a variance: the root of two over the draws.
        assert!(error < 5.0 * (2.0 / DRAWS as f64).sqrt(), "{error}");
    }

    #[test]
    fn the_logarithm_of_the_determinant_is_that_of_a_dense_cholesky_factor() {
        let (data, derivatives) = blocks();
        let whitening = Whitening::new(&data, &derivatives);
        for span in SPANS {
            let factor = Cholesky::new(covariance(&data, &derivatives[span.clone()])).unwrap();
            let dense = 2.0 * factor.l().diagonal().iter().map(|v| (v / data.noise_kpa).ln()).sum::<f64>();
            // Directions are of unit length.
            let taken_out = |k: usize| -> f64 {
                span.clone().map(|row| whitening.directions[row][k] * whitening.taken[row][k]).sum()
            };
            let own: f64 = -2.0 * (0..DISTURBANCES).map(|k| (1.0 - taken_out(k)).ln()).sum::<f64>();
            assert!((own - dense).abs() < 1e-9 * dense, "{own} {dense}");
        }
    }

    #[test]
    fn columns_are_whitened_as_series_are() {
        let (data, derivatives) = blocks();
        let whitening = Whitening::new(&data, &derivatives);
        for count in 1..=7 {
            let columns: Vec<Vec<f64>> = (0..count).map(|k| normals(3 + k as u64, ROWS)).collect();
            let mut together: Vec<f64> =
                (0..ROWS).flat_map(|row| columns.iter().map(move |c| c[row])).collect();
            whitening.apply_columns(&mut together, count);
            for (k, mut column) in columns.into_iter().enumerate() {
                whitening.apply(&mut column);
                let apart = together.iter().skip(k).step_by(count).zip(&column).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-12, "column {k} of {count}");
            }
        }
    }

    #[test]
    fn what_a_wrong_start_does_is_taken_out_entirely_and_nothing_else() {
        let (data, derivatives) = blocks();
        let whitening = Whitening::start_only(&data, &derivatives);
        let mut start: Vec<f64> = derivatives.iter().map(|d| 3.0 * d[0]).collect();
        let mut level: Vec<f64> = derivatives.iter().map(|d| d[1]).collect();
        for span in SPANS {
            // The part of the level that no start explains.
            let rows = || span.clone().map(|row| (derivatives[row][0], derivatives[row][1]));
            let along = rows().map(|(s, l)| s * l).sum::<f64>() / rows().map(|(s, _)| s * s).sum::<f64>();
            span.for_each(|row| level[row] -= along * derivatives[row][0]);
        }
        let before = level.clone();
        whitening.apply(&mut start);
        whitening.apply(&mut level);
        assert!(start.iter().all(|v| v.abs() < 5e-3), "{start:?}");
        assert!(level.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-9 * 60.0), "{level:?}");
    }
}
