//! How well the data determine the coordinates.
//!
//! Residuals of a rollout are correlated in time wherever the model is not perfect, and the
//! textbook covariance `s^2 (J^T J)^-1` is then too small. The variance of each coordinate is the
//! larger of the textbook's and a robust one, the long-run variance of its influence series
//! ([`LongRun`]).

use nalgebra::{DMatrix, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::long_run::LongRun;
use super::{Minimum, Objective};

/// Eigenvalues of the scaled normal matrix below this share of the largest are taken as zero.
const SINGULAR: f64 = 1e-13;

/// Precision of the coordinates at a minimum. Coordinates on a bound are taken as known.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// Covariance of the coordinates, with the robust variances on its diagonal; infinite where
    /// undetermined.
    pub matrix: DMatrix<f64>,
    /// Standard error of each coordinate; zero on a bound, infinite where undetermined.
    pub standard_errors: Vec<f64>,
    /// By how much correlation in time widens each variance, at least 1.
    pub inflation: Vec<f64>,
    /// Degrees of freedom of each standard error.
    pub degrees_of_freedom: Vec<f64>,
    /// How many independent samples the recording is worth to the coordinate that suffers most from
    /// correlation.
    pub effective_samples: f64,
    /// Variance of a residual.
    pub residual_variance: f64,
    /// Square root of the ratio of the largest to the smallest eigenvalue of the normal matrix
    /// scaled to unit diagonal: the condition number of the scaled Jacobian.
    pub condition: f64,
    /// Correlation of the coordinates after the textbook covariance.
    pub correlation: DMatrix<f64>,
}

impl Covariance {
    /// Half width of a coordinate's two-sided interval at a confidence level, in standard errors.
    #[must_use]
    pub fn quantile(&self, coordinate: usize, level: f64) -> f64 {
        StudentsT::new(0.0, 1.0, self.degrees_of_freedom[coordinate])
            .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * level))
    }
}

/// The precision of a minimum of an objective.
pub fn covariance(objective: &(impl Objective + ?Sized), minimum: &Minimum) -> Covariance {
    let normal = &minimum.normal;
    let count = objective.dimension();
    let moving: Vec<usize> =
        (0..count).filter(|&i| !minimum.active[i] && normal.matrix[(i, i)] > 0.0).collect();
    let inverse = Inverse::new(&normal.matrix, &moving);

    #[allow(clippy::cast_precision_loss)] // far below 2^52
    let (samples, freedom) =
        (objective.residuals() as f64, (objective.residuals().max(moving.len() + 1) - moving.len()) as f64);
    let residual_variance = normal.cost / freedom;
    let naive = &inverse.matrix * residual_variance;
    let influence = influence(objective, &minimum.coordinates, &moving, &inverse.matrix);

    let mut matrix = DMatrix::zeros(count, count);
    let mut correlation = DMatrix::identity(count, count);
    let mut standard_errors = vec![0.0; count];
    let mut inflation = vec![1.0; count];
    let mut degrees_of_freedom = vec![freedom; count];
    let robust = LongRun::of_each(&influence);
    let effective_samples = robust.iter().map(|robust| robust.effective_samples).fold(samples, f64::min);
    // Every fitted coordinate takes one effectively independent sample out of the residuals, at
    // most half of them.
    #[allow(clippy::cast_precision_loss)]
    let left = (1.0 - moving.len() as f64 / effective_samples).max(0.5);
    for (a, (&i, robust)) in moving.iter().zip(&robust).enumerate() {
        let factor = robust.variance / left / naive[(a, a)];
        if factor > 1.0 {
            inflation[i] = factor;
        }
        degrees_of_freedom[i] = robust.terms.min(freedom);
    }
    for (a, &i) in moving.iter().enumerate() {
        for (b, &j) in moving.iter().enumerate() {
            matrix[(i, j)] = naive[(a, b)] * (inflation[i] * inflation[j]).sqrt();
            correlation[(i, j)] = naive[(a, b)] / (naive[(a, a)] * naive[(b, b)]).sqrt();
        }
        standard_errors[i] = matrix[(i, i)].sqrt();
    }
    let lost = inverse.undetermined.iter().map(|&a| moving[a]);
    let without_effect = (0..count).filter(|&i| !minimum.active[i] && normal.matrix[(i, i)] <= 0.0);
    for i in lost.chain(without_effect) {
        matrix[(i, i)] = f64::INFINITY;
        standard_errors[i] = f64::INFINITY;
    }
    Covariance {
        matrix,
        standard_errors,
        inflation,
        degrees_of_freedom,
        effective_samples,
        residual_variance,
        condition: inverse.condition,
        correlation,
    }
}

/// What each instant's residuals contribute to the error of each moving coordinate:
/// `(J^T J)^-1 J_k^T r_k`, in the order of time.
fn influence(
    objective: &(impl Objective + ?Sized),
    coordinates: &[f64],
    moving: &[usize],
    inverse: &DMatrix<f64>,
) -> Vec<Vec<f64>> {
    let mut series = vec![Vec::with_capacity(objective.residuals()); moving.len()];
    let mut picked = vec![0.0; moving.len()];
    objective.scores(coordinates, &mut |_, score, _| {
        let count = moving.len();
        for k in 0..count {
            picked[k] = score[moving[k]];
        }
        // The inverse is symmetric: its columns are its rows.
        for k in 0..count {
            let row = &inverse.as_slice()[k * count..][..count];
            let mut sum = 0.0;
            for i in 0..count {
                sum += row[i] * picked[i];
            }
            series[k].push(sum);
        }
    });
    series
}

/// Pseudo-inverse of a normal matrix, by the eigenvalues of the matrix scaled to unit diagonal.
struct Inverse {
    matrix: DMatrix<f64>,
    condition: f64,
    /// Rows that take part in directions the data say nothing about.
    undetermined: Vec<usize>,
}

impl Inverse {
    fn new(full: &DMatrix<f64>, moving: &[usize]) -> Self {
        let count = moving.len();
        if count == 0 {
            return Self { matrix: DMatrix::zeros(0, 0), condition: 1.0, undetermined: vec![] };
        }
        let scale: Vec<f64> = moving.iter().map(|&i| full[(i, i)].sqrt()).collect();
        let scaled =
            DMatrix::from_fn(count, count, |a, b| full[(moving[a], moving[b])] / (scale[a] * scale[b]));
        let eigen = SymmetricEigen::new(scaled);
        let largest = eigen.eigenvalues.max();
        let mut matrix = DMatrix::zeros(count, count);
        let mut undetermined = vec![];
        let mut smallest = largest;
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            smallest = smallest.min(*value);
            if *value > SINGULAR * largest {
                matrix += vector * vector.transpose() / *value;
            } else {
                undetermined.extend((0..count).filter(|&a| vector[a].powi(2) > 0.01));
            }
        }
        undetermined.sort_unstable();
        undetermined.dedup();
        let matrix = DMatrix::from_fn(count, count, |a, b| matrix[(a, b)] / (scale[a] * scale[b]));
        let condition = if smallest > 0.0 { (largest / smallest).sqrt() } else { f64::INFINITY };
        Self { matrix, condition, undetermined }
    }
}
