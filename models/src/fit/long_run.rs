//! The variance of a sum of correlated terms.
//!
//! The variance of `sum z_t` is the spectral density of `z` at frequency zero times the number of terms. It is estimated by the mean
//! of the squared coefficients of `z` on the first `K` cosines, and intervals take the t distribution with `K` degrees of
//! freedom: the equal-weighted cosine estimator of Lazarus, Lewis, Stock and Watson (2018), who recommend
//! `K = 0.4 n^(2/3)` for `n` moderately correlated terms. Here `n` is the number of *effectively independent* terms, from
//! the autocorrelation of `z` (Geyer's initial positive sequence, 1992), because rollouts at a high sampling rate are
//! anything but moderately correlated. A kernel estimator with Andrews' automatic bandwidth in its place held the truth in
//! 75 % of the 95 % intervals of 30 s under a wandering supply, this one in 90 % (`tests/engine/coverage.rs`).

use std::f64::consts::PI;

/// Most cosines: the t distribution with more degrees of freedom differs from the normal one by less than 2 %.
const MOST_TERMS: usize = 64;

/// Fewest cosines.
const FEWEST_TERMS: usize = 5;

/// Terms are summed up in this many bins at most: the cosines and the correlations that matter are slow.
const BINS: usize = 4096;

/// Long-run variance of a series whose sum is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LongRun {
    /// Variance of the sum.
    pub variance: f64,
    /// Number of cosines, the degrees of freedom of `variance`.
    pub terms: f64,
    /// Number of effectively independent terms in the series.
    pub effective_samples: f64,
}

impl LongRun {
    /// Estimates the variance of the sum of `series`.
    #[must_use]
    #[allow(clippy::cast_precision_loss)] // far below 2^52
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // positive and clamped
    pub fn of(series: &[f64]) -> Self {
        let per_bin = series.len().div_ceil(BINS).max(1);
        let bins: Vec<f64> = series.chunks(per_bin).map(|chunk| chunk.iter().sum()).collect();
        let count = bins.len() as f64;
        let effective_bins = count / correlation_time(&bins);
        let most = MOST_TERMS.min(bins.len() / 4).max(1);
        let terms = ((0.4 * effective_bins.powf(2.0 / 3.0)) as usize).max(FEWEST_TERMS).min(most);
        let coefficient = |j: usize| {
            let angle = PI * j as f64 / count;
            let cosine = |(t, z): (usize, &f64)| z * (angle * (t as f64 + 0.5)).cos();
            // The cosines' mean square is one half.
            2.0_f64.sqrt() * bins.iter().enumerate().map(cosine).sum::<f64>()
        };
        let variance = (1..=terms).map(|j| coefficient(j).powi(2)).sum::<f64>() / terms as f64;
        // Correlation within a bin shows in how much larger its square is than that of its samples.
        let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        let within = if square(&bins) > 0.0 { square(series) / square(&bins) } else { 1.0 };
        let effective_samples = effective_bins * within.min(1.0) * series.len() as f64 / count;
        Self { variance, terms: terms as f64, effective_samples }
    }
}

/// Sum of the autocorrelations over all lags, at least 1: pairs of neighbouring lags are added while they are positive.
fn correlation_time(series: &[f64]) -> f64 {
    let lagged = |lag: usize| series.iter().zip(&series[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let square = lagged(0);
    if square <= 0.0 {
        return 1.0;
    }
    let mut sum = -1.0;
    let mut lag = 0;
    while lag + 1 < series.len() / 2 {
        let pair = (lagged(lag) + lagged(lag + 1)) / square;
        if pair <= 0.0 {
            break;
        }
        sum += 2.0 * pair;
        lag += 2;
    }
    sum.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// A first-order process with the given correlation between neighbours and unit innovations.
    fn process(rho: f64, count: usize, seed: u64) -> Vec<f64> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut state = 0.0;
        let next = || {
            state = rho * state + 12.0_f64.sqrt() * (random.random::<f64>() - 0.5);
            state
        };
        std::iter::repeat_with(next).take(count).collect()
    }

    /// The long-run variance of `count` terms is `count / (1 - rho)^2`.
    #[test]
    fn first_order_processes_have_the_known_variance() {
        for (rho, tolerance) in [(0.0, 0.1), (0.9, 0.15), (-0.3, 0.1)] {
            let (count, seeds) = (20_000, 20);
            let mean =
                (0..seeds).map(|seed| LongRun::of(&process(rho, count, seed)).variance).sum::<f64>() / 20.0;
            let expected = 20_000.0 / (1.0_f64 - rho).powi(2);
            assert!((mean / expected - 1.0).abs() < tolerance, "rho {rho}: {mean}, expected {expected}");
        }
    }

    #[test]
    fn correlated_samples_count_less() {
        // (1 - rho) / (1 + rho) of them are independent.
        let long = LongRun::of(&process(0.9, 20_000, 7));
        assert!((700.0..1_500.0).contains(&long.effective_samples), "{long:?}");
        assert!(LongRun::of(&process(0.0, 20_000, 7)).effective_samples > 15_000.0);
    }
}
