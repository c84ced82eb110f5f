//! The pressure loop that runs on a board, in 10-bit counts.

use serde::{Deserialize, Serialize};

/// drive = kp (command - pressure) - kd (pressure - previous pressure), clipped to the saturation
/// and scaled by it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Controller {
    /// Rate of the loop, Hz.
    pub rate_hz: f64,
    /// Drive counts per pressure count of error.
    pub kp: f64,
    /// Drive counts per count of change between two samples.
    #[serde(default)]
    pub kd: f64,
    /// Drive counts at full drive, positive.
    pub saturation: f64,
    /// Weight of the previous sample in the low-pass filter, 0 (none) to below 1.
    #[serde(default)]
    pub filter: f64,
}

/// With which resolution a board calculates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Arithmetic {
    /// In 1/256 count; the filter settles at its input. This project's boards.
    #[default]
    Fine,
    /// In whole counts, the filter rounding down: it settles up to five counts low. The original's
    /// boards.
    Whole,
}

impl Controller {
    /// Loops in an interval of this length (s), at least one.
    #[must_use]
    pub fn ticks(&self, interval_s: f64) -> usize {
        ticks(self.rate_hz, interval_s)
    }
}

/// Loops at a rate (Hz) in an interval of this length (s), at least one.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // rounded and at least one
pub fn ticks(rate_hz: f64, interval_s: f64) -> usize {
    (interval_s * rate_hz).round().max(1.0) as usize
}
