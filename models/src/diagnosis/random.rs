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

/// Indices drawn with replacement in runs of neighbours (circular moving blocks, Politis and Romano 1992).
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
