//! Rows of a long recording, evenly.

use std::ops::Range;

use crate::diagnosis::channel::{ChannelData, OPEN};

/// Rows of a channel that are looked at, at most, evenly over the open blocks.
const MOST_ROWS: usize = 20_000;

/// A whitened series on rows of the open blocks that are as far apart as [`MOST_ROWS`] asks.
pub fn thinned(data: &ChannelData, series: &[f64]) -> Vec<f32> {
    let rows = open_spans(data).flat_map(|span| &series[span.clone()]);
    #[allow(clippy::cast_possible_truncation)] // products of residuals need no more
    rows.step_by(stride(data)).map(|&value| value as f32).collect()
}

/// One in so many rows of the open blocks is looked at.
pub fn stride(data: &ChannelData) -> usize {
    open_spans(data).map(Range::len).sum::<usize>().div_ceil(MOST_ROWS).max(1)
}

/// Rows of the open blocks.
fn open_spans(data: &ChannelData) -> impl Iterator<Item = &Range<usize>> {
    data.blocks.iter().zip(&data.spans).filter(|(block, _)| OPEN.contains(&block.role)).map(|(_, span)| span)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel_of;

    #[test]
    fn long_recordings_are_thinned_evenly() {
        let looked_at = |rows: usize| {
            let (data, _) = channel_of(rows, false);
            let series: Vec<f64> = (0..data.rows.len()).map(|k| k as f64).collect();
            (thinned(&data, &series), stride(&data))
        };
        let (short, each) = looked_at(2_000);
        assert!(each == 1 && short.windows(2).all(|pair| pair[1] > pair[0]));
        let (long, each) = looked_at(60_000);
        assert!(each > 1 && long.len() <= MOST_ROWS && long.len() > MOST_ROWS / 2, "{each}: {}", long.len());
        // Within a block as far apart as that.
        let steps = long.windows(2).filter(|pair| pair[1] - pair[0] == each as f32);
        assert!(steps.count() > long.len() / 2);
    }
}
