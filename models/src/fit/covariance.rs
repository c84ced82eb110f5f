//! How well the data determine the coordinates.
//!
//! Residuals of a rollout are correlated in time wherever the model is not perfect, and the textbook covariance
//! `s^2 (J^T J)^-1` is then too small. The covariance here is the larger, coordinate by coordinate, of that one and of the
//! heteroskedasticity- and autocorrelation-consistent one, `(J^T J)^-1 S (J^T J)^-1` with Bartlett's kernel for `S`
//! (Newey and West 1987) and the bandwidth of Andrews (1991) for first-order autoregressions.

use nalgebra::{DMatrix, DVector, DVectorView, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{Minimum, Objective};

/// Eigenvalues of the scaled normal matrix below this share of the largest are taken as zero.
const SINGULAR: f64 = 1e-13;

/// Precision of the coordinates at a minimum. Coordinates on a bound are taken as known.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// Covariance of the coordinates, with the robust variances on its diagonal; infinite where undetermined.
    pub matrix: DMatrix<f64>,
    /// Standard error of each coordinate; zero on a bound, infinite where undetermined.
    pub standard_errors: Vec<f64>,
    /// By how much correlation in time widens each variance, at least 1.
    pub inflation: Vec<f64>,
    /// Variance of a residual.
    pub residual_variance: f64,
    /// Width of the kernel in residuals' instants.
    pub bandwidth: usize,
    /// Degrees of freedom of the intervals.
    pub degrees_of_freedom: f64,
    /// Square root of the ratio of the largest to the smallest eigenvalue of the normal matrix scaled to unit diagonal: the
    /// condition number of the scaled Jacobian.
    pub condition: f64,
    /// Correlation of the coordinates after the textbook covariance.
    pub correlation: DMatrix<f64>,
}

impl Covariance {
    /// Half width of the two-sided interval at a confidence level, in standard errors.
    #[must_use]
    pub fn quantile(&self, level: f64) -> f64 {
        StudentsT::new(0.0, 1.0, self.degrees_of_freedom)
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
    let scores = Scores::collect(objective, &minimum.coordinates, &moving);
    let bandwidth = scores.bandwidth(&inverse.matrix);
    let robust = &inverse.matrix * scores.long_run(bandwidth) * &inverse.matrix * (samples / freedom);
    #[allow(clippy::cast_precision_loss)]
    let degrees_of_freedom = (1.5 * scores.instants() as f64 / bandwidth as f64).clamp(1.0, freedom);

    let mut matrix = DMatrix::zeros(count, count);
    let mut correlation = DMatrix::identity(count, count);
    let mut standard_errors = vec![0.0; count];
    let mut inflation = vec![1.0; count];
    let factor: Vec<f64> = (0..moving.len()).map(|a| (robust[(a, a)] / naive[(a, a)]).max(1.0)).collect();
    for (a, &i) in moving.iter().enumerate() {
        inflation[i] = factor[a];
        for (b, &j) in moving.iter().enumerate() {
            matrix[(i, j)] = naive[(a, b)] * (factor[a] * factor[b]).sqrt();
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
        residual_variance,
        bandwidth,
        degrees_of_freedom,
        condition: inverse.condition,
        correlation,
    }
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

/// The products of Jacobian and residual, instant by instant, in separate stretches.
struct Scores {
    /// Row by row, `width` values each.
    stretches: Vec<Vec<f64>>,
    width: usize,
}

impl Scores {
    fn collect(objective: &(impl Objective + ?Sized), coordinates: &[f64], moving: &[usize]) -> Self {
        let mut stretches: Vec<Vec<f64>> = vec![];
        objective.scores(coordinates, &mut |stretch, score, _| {
            stretches.resize_with(stretches.len().max(stretch + 1), Vec::new);
            stretches[stretch].extend(moving.iter().map(|&i| score[i]));
        });
        Self { stretches, width: moving.len() }
    }

    fn instants(&self) -> usize {
        self.stretches.iter().map(|stretch| stretch.len() / self.width.max(1)).sum()
    }

    /// Andrews' bandwidth for Bartlett's kernel, with each parameter's influence as one series.
    fn bandwidth(&self, inverse: &DMatrix<f64>) -> usize {
        let mut square = vec![0.0; self.width];
        let mut product = vec![0.0; self.width];
        let mut influence = DVector::zeros(self.width);
        for stretch in &self.stretches {
            let mut previous = DVector::zeros(self.width);
            for score in stretch.chunks_exact(self.width.max(1)) {
                influence.gemv(1.0, inverse, &DVectorView::from_slice(score, self.width), 0.0);
                for a in 0..self.width {
                    square[a] += influence[a] * influence[a];
                    product[a] += influence[a] * previous[a];
                }
                previous.copy_from(&influence);
            }
        }
        let (mut above, mut below) = (0.0, 0.0);
        for (square, product) in square.iter().zip(&product).filter(|(square, _)| **square > 0.0) {
            let rho = (product / square).clamp(-0.97, 0.97);
            // Every parameter weighs the same, whatever its unit.
            above += 4.0 * rho * rho / ((1.0 - rho).powi(6) * (1.0 + rho).powi(2));
            below += 1.0 / (1.0 - rho).powi(4);
        }
        if below <= 0.0 {
            return 1;
        }
        #[allow(clippy::cast_precision_loss)]
        let instants = self.instants() as f64;
        let width = (1.1447 * (above / below * instants).cbrt()).ceil();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // positive and clamped
        let width = width.clamp(1.0, (instants / 8.0).max(1.0)) as usize;
        width
    }

    /// Long-run sum of the scores' products under Bartlett's kernel: the mean over all windows of `bandwidth` instants of the
    /// squared window sums, windows over the edge included. By running sums, so its cost does not grow with the bandwidth.
    fn long_run(&self, bandwidth: usize) -> DMatrix<f64> {
        let width = self.width.max(1);
        let mut sum = DMatrix::zeros(self.width, self.width);
        for stretch in &self.stretches {
            let mut window = DVector::<f64>::zeros(self.width);
            let at = |instant: usize| stretch.get(instant * width..(instant + 1) * width);
            for end in 0..stretch.len() / width + bandwidth - 1 {
                for (window, score) in window.iter_mut().zip(at(end).unwrap_or_default()) {
                    *window += score;
                }
                let left = end.checked_sub(bandwidth).and_then(at);
                for (window, score) in window.iter_mut().zip(left.unwrap_or_default()) {
                    *window -= score;
                }
                sum.ger(1.0, &window, &window, 1.0);
            }
        }
        #[allow(clippy::cast_precision_loss)]
        let width = bandwidth as f64;
        sum / width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_long_run_sum_is_bartletts() {
        let series = [1.0, -2.0, 3.0, 0.5, 1.5];
        let scores = Scores {
            stretches: vec![series.iter().map(|&x| DVector::from_element(1, x)).collect()],
            width: 1,
        };
        let lagged = |lag: usize| series.iter().zip(&series[lag..]).map(|(a, b)| a * b).sum::<f64>();
        let expected = lagged(0) + 2.0 * (2.0 / 3.0 * lagged(1) + 1.0 / 3.0 * lagged(2));
        assert!((scores.long_run(3)[(0, 0)] - expected).abs() < 1e-12);
    }
}
