//! Reproducible resampling.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The same draws every time: a diagnosis of the same data is the same.
#[must_use]
pub fn generator(purpose: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(0x5eed_0000 + purpose)
}

/// Random signs.
pub fn signs(rng: &mut Pcg64Mcg, count: usize) -> Vec<f64> {
    (0..count).map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect()
}

/// Indices drawn with replacement in runs of neighbours (circular moving blocks, Politis and Romano
/// 1992).
pub fn runs(rng: &mut Pcg64Mcg, count: usize, length: usize) -> Vec<usize> {
    let mut drawn = Vec::with_capacity(count + length);
    while drawn.len() < count {
        let start = rng.random_range(0..count);
        drawn.extend((0..length).map(|k| (start + k) % count));
    }
    drawn.truncate(count);
    drawn
}

/// The value below which a share of the sorted values lies, interpolated.
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // share is 0 to 1
    let low = at.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (at - low as f64) * (sorted[high] - sorted[low])
}

/// Resamples of blocks.
const RESAMPLES: usize = 999;

/// Quantiles (2.5 %, 5 %, 50 %, 95 %, 97.5 %) of a statistic of paired block sums under a bootstrap
/// of blocks.
#[must_use]
pub fn bootstrap(a: &[f64], b: &[f64], statistic: impl Fn(f64, f64) -> f64) -> [f64; 5] {
    let mut rng = generator(2);
    let mut values: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn = runs(&mut rng, a.len(), 1);
            let sum = |x: &[f64]| drawn.iter().map(|&k| x[k]).sum::<f64>();
            statistic(sum(a), sum(b))
        })
        .collect();
    values.sort_by(f64::total_cmp);
    [0.025, 0.05, 0.5, 0.95, 0.975].map(|q| quantile(&values, q))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bootstrap_of_equal_blocks_is_certain_and_one_of_different_blocks_is_not() {
        assert_eq!(bootstrap(&[2.0; 12], &[1.0; 12], |a, b| 1.0 - b / a), [0.5; 5]);
        let a: Vec<f64> = (0..40).map(|k| 1.0 + 0.5 * f64::from(k % 4)).collect();
        let quantiles = bootstrap(&a, &[1.0; 40], |a, b| (a - b) / 40.0);
        assert!(quantiles.windows(2).all(|pair| pair[0] < pair[1]), "{quantiles:?}");
        // The mean is 0.75; the standard deviation of the blocks 0.56, that of the mean 0.088.
        let half = 0.5 * (quantiles[4] - quantiles[0]);
        assert!(
            (quantiles[2] - 0.75).abs() < 0.03 && (half / (1.96 * 0.088) - 1.0).abs() < 0.15,
            "{quantiles:?}"
        );
    }
}
