//! Scores: what a direction and the residual have in common, quarter of a block by quarter.

use crate::diagnosis::channel::{ChannelData, Role};

/// Parts of a block with a score of their own.
const PARTS: usize = 4;
/// Draws of random signs.
pub const DRAWS: usize = 999;
/// Largest score, in upper quartiles of their sizes.
pub const CLIP: f64 = 5.0;

/// Scores of the quarters of all blocks, zero where a block does not count.
pub fn scores(data: &ChannelData, residuals: &[f64], direction: &[f64], roles: &[Role]) -> Vec<f64> {
    let mut scores = vec![0.0; data.spans.len() * PARTS];
    for ((block, span), parts) in data.blocks.iter().zip(&data.spans).zip(scores.chunks_exact_mut(PARTS)) {
        if !roles.contains(&block.role) {
            continue;
        }
        let length = span.len();
        for part in 0..PARTS {
            for row in span.start + part * length / PARTS..span.start + (part + 1) * length / PARTS {
                parts[part] += residuals[row] * direction[row];
            }
        }
    }
    scores
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;

    #[test]
    fn the_scores_of_a_blocks_quarters_add_up_to_its_product_and_closed_blocks_have_none() {
        let (data, _) = channel(false);
        let series = |hz: f64| (0..data.rows.len()).map(|k| (hz * k as f64).sin()).collect::<Vec<_>>();
        let (a, b) = (series(0.11), series(0.13));
        let scores = scores(&data, &a, &b, &[Role::Select]);
        assert_eq!(scores.len(), PARTS * data.blocks.len());
        for (block, (span, parts)) in data.blocks.iter().zip(data.spans.iter().zip(scores.chunks(PARTS))) {
            let product: f64 = span.clone().map(|row| a[row] * b[row]).sum();
            let expected = if block.role == Role::Select { product } else { 0.0 };
            assert!((parts.iter().sum::<f64>() - expected).abs() < 1e-9, "{parts:?} {expected}");
        }
    }
}
