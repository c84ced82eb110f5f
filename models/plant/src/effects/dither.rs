//! A stand-in for the sensor's noise in the board's loop, the same in every simulation.

use std::sync::OnceLock;

use statrs::distribution::{ContinuousCDF, Normal};

/// Values that the noise takes.
pub(super) const QUANTILES: usize = 2048;

/// Quantiles of the standard normal distribution in the middle of equally probable parts. Sampling
/// from them gives its tails, up to 3.5 standard deviations: what friction answers to are the
/// extremes of many loops.
pub(super) fn quantiles() -> &'static [f64; QUANTILES] {
    static TABLE: OnceLock<[f64; QUANTILES]> = OnceLock::new();
    TABLE.get_or_init(|| {
        let normal = Normal::standard();
        std::array::from_fn(|k| normal.inverse_cdf((k as f64 + 0.5) / QUANTILES as f64))
    })
}

/// Numbers of the noise between one row and the next.
const ROW: u64 = 1 << 20;
/// Numbers between one draw and the next, modulo 2^64.
const DRAW: u64 = 0x9e37_79b9_7f4a_7c15;
/// `DRAW * DRAW_INVERSE` is 1 modulo 2^64.
const DRAW_INVERSE: u64 = 0xf1de_83e1_9937_733d;

/// The draw whose noise in row 0 and after is that of `draw` in row `row` and after: for a
/// simulation whose rows are numbered from somewhere else, as one that keeps only the last few. A
/// negative `row` counts from before row 0.
#[must_use]
pub fn course_from(draw: u64, row: i64) -> u64 {
    draw.wrapping_add(row.cast_unsigned().wrapping_mul(ROW).wrapping_mul(DRAW_INVERSE))
}

/// A reproducible stand-in for the sensor's noise at a loop of the board, with unit variance: one
/// of the quantiles, by the SplitMix64 hash. Each `draw` is another course of it.
#[inline(always)]
#[allow(clippy::cast_possible_truncation)] // a few bits are wanted
pub(super) fn dither(quantiles: &[f64; QUANTILES], draw: u64, row: usize, tick: usize) -> f64 {
    let mut z = (row as u64).wrapping_mul(ROW).wrapping_add(tick as u64);
    z = z.wrapping_add(draw.wrapping_add(1).wrapping_mul(DRAW));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    quantiles[z as usize % QUANTILES]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_normal_and_differs_from_loop_to_loop_and_from_draw_to_draw() {
        let course = |draw: u64| -> Vec<f64> {
            (0..4000).flat_map(|row| (0..10).map(move |tick| dither(quantiles(), draw, row, tick))).collect()
        };
        let drawn = course(0);
        let n = drawn.len() as f64;
        let moment = |power: i32| drawn.iter().map(|v| v.powi(power)).sum::<f64>() / n;
        assert!(moment(1).abs() < 0.02 && (moment(2) - 1.0).abs() < 0.03, "{} {}", moment(1), moment(2));
        assert!((moment(4) - 3.0).abs() < 0.2, "{}", moment(4));
        let neighbours = drawn.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
        assert!(neighbours.abs() < 0.02, "{neighbours}");
        let draws = drawn.iter().zip(course(1)).map(|(a, b)| a * b).sum::<f64>() / n;
        assert!(draws.abs() < 0.02, "{draws}");
    }

    #[test]
    fn a_course_can_be_followed_from_any_row() {
        for (draw, row, tick) in [(0, 0, 3), (0, 17, 0), (5, 1_000_000, 9), (u64::MAX, 3, 1)] {
            let whole = dither(quantiles(), draw, row + 2, tick);
            assert_eq!(dither(quantiles(), course_from(draw, row as i64), 2, tick), whole);
            assert_eq!(dither(quantiles(), course_from(draw, row as i64 - 1), 3, tick), whole);
        }
    }
}
