//! A Kalman filter's covariance from row to row: most of what the filter computes beside
//! simulations.
//!
//! Of `N` numbers in the state the first `n` are in use, the others 0. Loops over indices, whose
//! inner ones are as long as the arrays, become vectors.

use multiversion::multiversion;

/// Carries a covariance on by the derivatives of the state by the state before; the covariances of
/// the state with a reading that has these slopes by the state before, and what of the reading's
/// variance is the state's.
#[multiversion(targets("x86_64+avx2"))]
pub fn propagate<const N: usize>(
    covariance: &mut [[f64; N]; N],
    transition: &[[f64; N]; N],
    slopes: &[f64; N],
    n: usize,
) -> ([f64; N], f64) {
    let n = n.min(N);
    let (mut carried, mut across) = ([[0.0; N]; N], [[0.0; N]; N]);
    let (mut of_reading, mut with_state) = ([0.0; N], [0.0; N]);
    for i in 0..n {
        let mut row = [0.0; N];
        for k in 0..n {
            for j in 0..N {
                row[j] += transition[i][k] * covariance[k][j];
            }
        }
        carried[i] = row;
        for j in 0..N {
            across[j][i] = transition[i][j];
            of_reading[j] += slopes[i] * covariance[i][j];
        }
    }
    for i in 0..n {
        let mut row = [0.0; N];
        for k in 0..n {
            for j in 0..N {
                row[j] += carried[i][k] * across[k][j];
            }
            with_state[i] += carried[i][k] * slopes[k];
        }
        covariance[i] = row;
    }
    let mut of_state = 0.0;
    for k in 0..n {
        of_state += of_reading[k] * slopes[k];
    }
    (with_state, of_state)
}

/// The covariance after a measurement with which the state has these covariances, and which has
/// this variance.
#[multiversion(targets("x86_64+avx2"))]
pub fn learn<const N: usize>(covariance: &mut [[f64; N]; N], with_state: &[f64; N], variance: f64, n: usize) {
    for i in 0..n.min(N) {
        let mut row = covariance[i];
        for j in 0..N {
            row[j] -= with_state[i] * with_state[j] / variance;
        }
        covariance[i] = row;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{SMatrix, SVector};

    use super::*;

    type Square = SMatrix<f64, 4, 4>;

    fn square(of: impl Fn(usize, usize) -> f64) -> ([[f64; 4]; 4], Square) {
        let in_use = |i: usize, j: usize| if i < 3 && j < 3 { of(i, j) } else { 0.0 };
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| in_use(i, j)));
        (rows, Square::from_fn(in_use))
    }

    fn near(found: &[[f64; 4]; 4], expected: &Square) {
        for (i, row) in found.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - expected[(i, j)]).abs() < 1e-12, "{found:?} {expected}");
            }
        }
    }

    #[test]
    fn a_covariance_is_carried_on_and_learns_as_the_matrices_of_the_textbook() {
        let (mut covariance, p) = square(|i, j| if i == j { 2.0 + i as f64 } else { 0.3 * (i + j) as f64 });
        let (transition, f) = square(|i, j| 0.9 / (1.0 + (2 * i + j) as f64));
        let slopes = [0.5, -1.0, 0.25, 0.0];
        let h = SVector::from(slopes);
        let (with_state, of_state) = propagate(&mut covariance, &transition, &slopes, 3);
        let (after, cross) = (f * p * f.transpose(), f * p * h);
        near(&covariance, &after);
        assert!((of_state - (h.transpose() * p * h)[0]).abs() < 1e-12);
        assert!((SVector::from(with_state) - cross).norm() < 1e-12, "{with_state:?} {cross}");
        let variance = of_state + 0.1;
        learn(&mut covariance, &with_state, variance, 3);
        near(&covariance, &(after - cross * cross.transpose() / variance));
    }
}
