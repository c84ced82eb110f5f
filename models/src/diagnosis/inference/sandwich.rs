//! Standard errors that hold however the residual is correlated within a block, and from one block
//! to the next.
//!
//! The block sandwich `H^-1 (sum s_b s_b^T) H^-1` of the scores `s_b` of whole blocks is too small
//! where a block has much of what there is to be known of a parameter: the fit has followed its
//! errors. Each block's part is therefore what the estimate changes by, to first order, when the
//! block is left out (cluster jackknife, CV3: MacKinnon, Nielsen and Webb, Journal of Applied
//! Econometrics 38, 2023). A supply that wanders over 20 s reaches beyond a block of 5 s: the
//! variance of the parts' sum is their [`LongRun`] variance.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::channel::{ChannelData, Role};
use crate::diagnosis::estimation::ChannelStage;
use crate::fit::LongRun;

/// How well a channel's free parameters are determined.
pub struct Sandwich {
    /// What each block for fitting adds to the parameters' errors.
    parts: Vec<DVector<f64>>,
    /// Covariance of independent residuals of the noise's variance.
    naive: DMatrix<f64>,
    /// What each block would add to the diagonal of that.
    shares: Vec<DVector<f64>>,
}

impl Sandwich {
    /// `None` where the parameters' derivatives cannot be told apart at all.
    #[must_use]
    pub fn new(data: &ChannelData, stage: &ChannelStage) -> Option<Self> {
        let n = stage.free.len();
        let blocks: Vec<(DMatrix<f64>, DVector<f64>)> = data
            .blocks
            .iter()
            .zip(&data.spans)
            .filter(|(block, _)| block.role == Role::Fit)
            .map(|(_, span)| {
                let rows = &stage.sensitivities[span.start * n..span.end * n];
                let slopes = DMatrix::from_row_slice(span.len(), n, rows);
                let score = slopes.tr_mul(&DVector::from_column_slice(&stage.residuals[span.clone()]));
                (slopes.tr_mul(&slopes), score)
            })
            .collect();
        let mut bread =
            blocks.iter().fold(DMatrix::<f64>::zeros(n, n), |sum, (information, _)| sum + information);
        // A parameter without influence has no slope: leave it out by giving it its own.
        for k in 0..n {
            if bread[(k, k)] <= 0.0 {
                bread[(k, k)] = 1e-30;
            }
        }
        let scale = DVector::from_fn(n, |k, _| bread[(k, k)].sqrt().recip());
        let scaled = DMatrix::from_fn(n, n, |a, b| bread[(a, b)] * scale[a] * scale[b]);
        let inverse = (scaled + DMatrix::identity(n, n) * 1e-10).try_inverse()?;
        let naive = DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] * scale[a] * scale[b]);
        let count = blocks.len() as f64;
        let jackknife = ((count - 1.0) / count).sqrt();
        let without = |(information, score): &(DMatrix<f64>, DVector<f64>)| {
            // In the scaled parameters, in which the matrix is as well conditioned as it can be.
            let own = DMatrix::from_fn(n, n, |a, b| information[(a, b)] * scale[a] * scale[b]);
            let score = score.component_mul(&scale);
            let left = DMatrix::identity(n, n) - own * &inverse;
            let score = left.lu().solve(&score).unwrap_or(score);
            (&inverse * score).component_mul(&scale) * jackknife
        };
        let parts = blocks.iter().map(without).collect();
        let shares =
            blocks.iter().map(|(information, _)| (&naive * information * &naive).diagonal()).collect();
        Some(Self { parts, naive, shares })
    }

    /// The error of one parameter.
    #[must_use]
    pub fn error(&self, k: usize) -> BlockError {
        let by_block = self.parts.iter().map(|part| part[k]).collect();
        BlockError::new(by_block, self.freedom(k))
    }

    /// Degrees of freedom of blocks: one less than the number of blocks, counted by what they say
    /// about the parameter (Carter, Schnepel and Steigerwald, Review of Economics and Statistics
    /// 99, 2017).
    fn freedom(&self, k: usize) -> f64 {
        let (sum, squares) =
            self.shares.iter().fold((0.0, 0.0), |(sum, squares), v| (sum + v[k], squares + v[k] * v[k]));
        let effective = if squares > 0.0 { sum * sum / squares } else { self.shares.len() as f64 };
        (effective - 1.0).max(1.0)
    }

    /// Variance over that of independent residuals of the noise's variance.
    #[must_use]
    pub fn ratio(&self, k: usize, error: &BlockError) -> f64 {
        error.variance / self.naive[(k, k)]
    }

    /// The mean of the [ratios](Self::ratio) of all parameters with influence, and the fewest
    /// degrees of freedom.
    #[must_use]
    pub fn on_average(&self) -> (f64, f64) {
        let errors = (0..self.naive.nrows()).map(|k| (k, self.error(k)));
        let known: Vec<(f64, f64)> = errors
            .map(|(k, error)| (self.ratio(k, &error), error.freedom))
            .filter(|(ratio, _)| ratio.is_finite() && *ratio > 1e-3)
            .collect();
        let ratio = known.iter().map(|known| known.0).sum::<f64>() / (known.len() as f64).max(1.0);
        let most = (self.parts.len() as f64 - 1.0).max(1.0);
        (ratio, known.iter().map(|known| known.1).fold(most, f64::min))
    }
}

/// The error of an estimate to which every block adds a part.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockError {
    /// The parts, in the order of time.
    pub by_block: Vec<f64>,
    /// Variance of their sum.
    pub variance: f64,
    /// Degrees of freedom of that.
    pub freedom: f64,
}

impl BlockError {
    /// From the parts, of which so many are free.
    #[must_use]
    pub fn new(by_block: Vec<f64>, free: f64) -> Self {
        let (variance, terms) = LongRun::of_each(std::slice::from_ref(&by_block))
            .first()
            .map_or((0.0, 1.0), |run| (run.variance, run.terms));
        Self { by_block, variance, freedom: terms.min(free) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;

    /// A stage whose residuals are anything, at the optimum of its linear model.
    fn fitted() -> (ChannelData, ChannelStage) {
        let (mut data, model) = channel(false);
        let wave = |row: usize| 0.3 * (0.37 * row as f64).sin() + 0.4 * (0.011 * row as f64).cos();
        data.measured_kpa = data.measured_kpa.iter().enumerate().map(|(k, y)| y + wave(k)).collect();
        let mut stage = ChannelStage::new(&data, model, vec![0, 2, 3]);
        let every: Vec<usize> = fit_rows(&data, usize::MAX);
        let step = least_squares(&stage, &every);
        for row in 0..stage.residuals.len() {
            let along: f64 = (0..3).map(|k| stage.sensitivities[3 * row + k] * step[k]).sum();
            stage.residuals[row] -= along;
        }
        (data, stage)
    }

    /// Rows of the blocks for fitting but one.
    fn fit_rows(data: &ChannelData, but: usize) -> Vec<usize> {
        let fit = data.blocks.iter().zip(&data.spans).filter(|(b, _)| b.role == Role::Fit);
        fit.enumerate().filter(|(k, _)| *k != but).flat_map(|(_, (_, span))| span.clone()).collect()
    }

    fn least_squares(stage: &ChannelStage, rows: &[usize]) -> DVector<f64> {
        let slopes = DMatrix::from_fn(rows.len(), 3, |r, k| stage.sensitivities[3 * rows[r] + k]);
        let residuals = DVector::from_fn(rows.len(), |r, _| stage.residuals[rows[r]]);
        slopes.svd(true, true).solve(&residuals, 1e-12).expect("factors were asked for")
    }

    #[test]
    fn a_blocks_part_is_what_the_estimate_changes_by_without_it() {
        let (data, stage) = fitted();
        let sandwich = Sandwich::new(&data, &stage).expect("three parameters with influence");
        let blocks = sandwich.parts.len();
        let jackknife = ((blocks as f64 - 1.0) / blocks as f64).sqrt();
        for left_out in 0..blocks {
            let moved = least_squares(&stage, &fit_rows(&data, left_out)) * -jackknife;
            for k in 0..3 {
                let part = sandwich.parts[left_out][k];
                assert!(
                    (part / moved[k] - 1.0).abs() < 1e-5,
                    "block {left_out}, {k}: {part} and {}",
                    moved[k]
                );
            }
        }
    }

    #[test]
    fn blocks_without_anything_to_say_are_no_degrees_of_freedom() {
        let (data, mut stage) = fitted();
        let even = Sandwich::new(&data, &stage).expect("three parameters with influence");
        assert!(
            even.freedom(1) > 1.0 && even.freedom(1) <= even.parts.len() as f64 - 1.0,
            "{}",
            even.freedom(1)
        );
        let last = data.blocks.iter().zip(&data.spans).rfind(|(b, _)| b.role == Role::Fit);
        let span = last.expect("blocks for fitting").1.clone();
        for row in (0..stage.residuals.len()).filter(|row| !span.contains(row)) {
            stage.sensitivities[3 * row + 1] *= 1e-3;
        }
        let uneven = Sandwich::new(&data, &stage).expect("three parameters with influence");
        assert!(uneven.freedom(1) < 1.1, "{}", uneven.freedom(1));
    }
}
