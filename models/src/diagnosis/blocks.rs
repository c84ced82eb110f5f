//! Splitting a recording in time before looking at it.
//!
//! Blocks of a few seconds alternate between fitting, selecting and testing, so that what changes slowly (drift, wear, ripple) is
//! in all three, with a gap before each.

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

/// Half of the blocks fit, a quarter each select and test; the order is not periodic in fewer than eight blocks.
const PATTERN: [Role; 8] =
    [Role::Fit, Role::Select, Role::Fit, Role::Test, Role::Fit, Role::Test, Role::Fit, Role::Select];

/// Longest block, s: the start pressure and a slow wander of the supply are free in each.
const LONGEST_S: f64 = 5.0;
/// Shortest block, s.
const SHORTEST_S: f64 = 1.0;
/// Blocks that are wanted in a short recording.
const WANTED: f64 = 24.0;
/// Part of a block that is simulated but not compared.
const GAP: f64 = 0.06;

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
    (duration_s / WANTED).clamp(SHORTEST_S, LONGEST_S)
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
                // The simulation starts from one measured pressure at the very beginning: more to forget.
                let gap = if from == start { 0.25 } else { GAP };
                let role = PATTERN[blocks.len() % PATTERN.len()];
                blocks.push(Block { start: from, compared: row_at(begin_s + gap * length), end: to, role });
            }
            from = to;
        }
    }
    blocks
}
