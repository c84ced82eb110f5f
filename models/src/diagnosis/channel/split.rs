//! Splitting a recording in time before looking at it.
//!
//! Blocks of a few seconds alternate between fitting, selecting and testing, so that what changes
//! slowly (drift, wear, ripple) is in all three, with a gap before each.

use crate::diagnosis::settings::SETTINGS;
use crate::effects::ChannelInputs;

/// What a block is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Parameters are fitted here.
    Fit,
    /// Causes are chosen here.
    Select,
    /// The gain is measured here, and nothing else.
    Test,
}

/// Blocks that may be looked at before the end.
pub const OPEN: [Role; 2] = [Role::Fit, Role::Select];

/// Half of the blocks fit, a quarter each select and test; the order is not periodic in fewer than
/// eight blocks.
const PATTERN: [Role; 8] =
    [Role::Fit, Role::Select, Role::Fit, Role::Test, Role::Fit, Role::Test, Role::Fit, Role::Select];

/// A stretch of rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// First simulated row.
    pub start: usize,
    /// First compared row.
    pub compared: usize,
    /// Row behind the last.
    pub end: usize,
    /// What it is used for.
    pub role: Role,
}

/// Length of the blocks of a recording of this length, s.
#[must_use]
pub fn block_length_s(duration_s: f64) -> f64 {
    (duration_s / SETTINGS.blocks_wanted).clamp(SETTINGS.shortest_block_s, SETTINGS.longest_block_s)
}

/// Cuts the rows into blocks, none of which crosses a start.
#[must_use]
pub fn split(inputs: &ChannelInputs) -> Vec<Block> {
    let length = block_length_s(inputs.duration_s);
    let mut blocks = Vec::new();
    for (k, &start) in inputs.starts.iter().enumerate() {
        let end = inputs.starts.get(k + 1).copied().unwrap_or(inputs.rows());
        let mut from = start;
        while from < end {
            let begin_s = inputs.time_s[from];
            let row_at = |t: f64| from + inputs.time_s[from..end].partition_point(|&x| x < t - 1e-9);
            let to = row_at(begin_s + length);
            if inputs.time_s[to - 1] - begin_s > 0.6 * length {
                // The simulation starts from one measured pressure at the very beginning: more to
                // forget.
                let gap = if from == start { 0.25 } else { SETTINGS.block_gap };
                let role = PATTERN[blocks.len() % PATTERN.len()];
                blocks.push(Block { start: from, compared: row_at(begin_s + gap * length), end: to, role });
            }
            from = to;
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;
    use std::sync::Arc;

    /// Rows at 100 Hz, with starts at some of them.
    fn inputs(rows: usize, starts: &[usize]) -> ChannelInputs {
        let (data, _) = channel(false);
        ChannelInputs {
            time_s: (0..rows).map(|k| 0.01 * k as f64).collect(),
            duration_s: 0.01 * (rows - 1) as f64,
            starts: Arc::from(starts),
            ..data.inputs
        }
    }

    fn count(blocks: &[Block], role: Role) -> usize {
        blocks.iter().filter(|b| b.role == role).count()
    }

    #[test]
    fn half_of_the_blocks_fit_and_a_quarter_each_select_and_test() {
        let blocks = split(&inputs(24_000, &[0]));
        assert_eq!(blocks.len(), 48);
        assert_eq!([Role::Fit, Role::Select, Role::Test].map(|role| count(&blocks, role)), [24, 12, 12]);
        // All three in every third of the recording: what changes slowly is in all of them.
        for third in blocks.chunks(16) {
            assert_eq!([Role::Fit, Role::Select, Role::Test].map(|role| count(third, role)), [8, 4, 4]);
        }
    }

    #[test]
    fn blocks_cover_all_rows_without_overlap_and_compare_all_but_a_gap() {
        let blocks = split(&inputs(24_000, &[0]));
        assert_eq!((blocks[0].start, blocks[blocks.len() - 1].end), (0, 24_000));
        assert!(blocks.windows(2).all(|pair| pair[0].end == pair[1].start));
        // Five seconds each; the first forgets its start longer.
        assert!(blocks.iter().all(|b| b.end - b.start == 500));
        assert_eq!((blocks[0].compared - blocks[0].start, blocks[1].compared - blocks[1].start), (125, 30));
    }

    #[test]
    fn no_block_crosses_a_start_and_a_short_rest_is_left_out() {
        // Stretches of 10.5 s and 109.5 s in blocks of 5 s: half a second is too little, 4.5 s are
        // not.
        let blocks = split(&inputs(12_000, &[0, 1050]));
        assert_eq!(blocks.iter().filter(|b| b.start < 1050).map(|b| b.end).collect::<Vec<_>>(), [500, 1000]);
        let second: Vec<&Block> = blocks.iter().filter(|b| b.start >= 1050).collect();
        assert_eq!((second[0].start, second[0].compared), (1050, 1175));
        assert_eq!((second[second.len() - 1].start, second[second.len() - 1].end), (11_550, 12_000));
    }

    #[test]
    fn short_recordings_have_short_blocks() {
        assert_eq!([10.0, 60.0, 1000.0].map(block_length_s), [1.0, 2.5, 5.0]);
    }
}
