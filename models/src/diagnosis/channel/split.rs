//! Splitting a recording in time before looking at it.
//!
//! Blocks of a few seconds alternate between fitting, selecting and testing, so that what changes
//! slowly (drift, wear, ripple) is in all three, with a gap before each.

use crate::diagnosis::settings::SETTINGS;
use crate::effects::ChannelInputs;
use std::sync::Arc;

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

/// Part of a block's length after which what a simulation remembers of the time before its start
/// has settled.
const SETTLING: f64 = 0.25;

/// Rows at which a simulation's pressure is [moved to the measured one](ChannelInputs::anchors):
/// one after each start, where the drive of a spool is recorded. A loop that is simulated makes up
/// for a wrong beginning by itself. Two valves are closed without current, and what is behind them
/// begins at rest: moved along with the pressure in front of it, what a tube separates would be
/// wrong.
#[must_use]
pub fn anchors(inputs: &ChannelInputs) -> Arc<[usize]> {
    if !inputs.spool_is_recorded() {
        return Arc::default();
    }
    let after_s = SETTLING * block_length_s(inputs.duration_s);
    let rows = stretches(inputs).filter_map(|stretch| {
        let from_s = inputs.time_s[stretch.start] + after_s;
        let mut rows = stretch.filter(|&row| inputs.time_s[row] >= from_s - 1e-9);
        rows.find(|&row| inputs.usable[row])
    });
    rows.collect()
}

/// Rows from each start to the next.
fn stretches(inputs: &ChannelInputs) -> impl Iterator<Item = std::ops::Range<usize>> {
    let ends = inputs.starts.iter().skip(1).copied().chain([inputs.rows()]);
    inputs.starts.iter().copied().zip(ends).map(|(start, end)| start..end)
}

/// Cuts the rows into blocks, none of which crosses a start.
#[must_use]
pub fn split(inputs: &ChannelInputs) -> Vec<Block> {
    let length = block_length_s(inputs.duration_s);
    let mut blocks = Vec::new();
    for stretch in stretches(inputs) {
        let (mut from, end) = (stretch.start, stretch.end);
        while from < end {
            let row_at = |t: f64| from + inputs.time_s[from..end].partition_point(|&x| x < t - 1e-9);
            let to = row_at(inputs.time_s[from] + length);
            if inputs.time_s[to - 1] - inputs.time_s[from] > 0.6 * length {
                // What was before a start is to be forgotten first.
                let anchor = inputs.anchors.iter().copied().find(|row| (from..to).contains(row));
                let (start, gap) = match anchor {
                    Some(row) => (row, SETTINGS.block_gap),
                    None if from == stretch.start => (from, SETTLING),
                    None => (from, SETTINGS.block_gap),
                };
                let compared = row_at(inputs.time_s[start] + gap * length);
                let role = PATTERN[blocks.len() % PATTERN.len()];
                blocks.push(Block { start, compared, end: to, role });
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
    use crate::effects::DriveInput;

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
    #[test]
    fn what_is_simulated_from_drives_is_anchored_once_its_beginning_is_forgotten() {
        let mut inputs = inputs(12_000, &[0, 1050, 11_900]);
        // Blocks of 5 s; the row at the end of the second stretch's settling has no reading.
        let mut usable = inputs.usable.iter().copied().cycle().take(12_000).collect::<Vec<_>>();
        (1175..1180).for_each(|row| usable[row] = false);
        inputs.usable = usable.into();
        inputs.anchors = anchors(&inputs);
        assert_eq!(*inputs.anchors, [125, 1180]);
        let blocks = split(&inputs);
        let of = |end: usize| blocks.iter().find(|block| block.end == end).unwrap();
        // What is compared begins as long after the anchor as in any block after its start.
        assert_eq!((of(500).start, of(500).compared), (125, 155));
        assert_eq!((of(1550).start, of(1550).compared), (1180, 1210));
        assert_eq!((of(1000).start, of(1000).compared), (500, 530));
        let looped = channel(true).0.inputs;
        assert!(anchors(&looped).is_empty(), "a simulated loop makes up for its beginning");
        let valves = inputs.command_pa.clone();
        inputs.drive = DriveInput::Separate { fill: valves.clone(), vent: valves };
        assert!(anchors(&inputs).is_empty(), "two valves are closed without current");
    }

    #[test]
    fn a_simulation_is_anchored_at_the_measured_pressure_and_goes_on_from_there() {
        let (mut data, base) = channel(false);
        let free = data.trace(&base);
        let (anchor, off_pa) = (125, 7e3);
        let mut measured = vec![data.inputs.measured_pa[0]; data.inputs.rows()];
        measured[anchor] = free[anchor][0] * 1e3 + data.inputs.ambient_pa + off_pa;
        data.inputs.measured_pa = measured.into();
        data.inputs.anchors = [anchor].into();
        let anchored = data.trace(&base);
        let apart = |row: usize| (anchored[row][0] - free[row][0]) * 1e3;
        assert!(apart(anchor - 1).abs() < 1e-6 && (apart(anchor) - off_pa).abs() < 1e-6);
        // The chamber forgets it by what flows.
        assert!(apart(anchor + 1) > 0.9 * off_pa && apart(anchor + 1500).abs() < 0.5 * off_pa);
    }
}
