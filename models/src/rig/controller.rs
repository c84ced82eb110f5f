//! `[controller]`: the pressure loop that runs on the board, in 10-bit counts.

use serde::{Deserialize, Serialize};

/// drive = kp (command - pressure) - kd (pressure - previous pressure), clipped to the saturation and scaled by it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Controller {
    /// Rate of the loop, Hz.
    pub rate_hz: f64,
    /// Drive counts per pressure count of error.
    pub kp: f64,
    /// Drive counts per count of change between two samples.
    #[serde(default)]
    pub kd: f64,
    /// Drive counts at full drive.
    pub saturation: f64,
    /// Weight of the previous sample in the low-pass filter, 0 (none) to below 1.
    #[serde(default)]
    pub filter: f64,
}
