//! What people call things, and the unit in which they see pressures.

use pneudrive_protocol::CHANNELS;
use serde::Serialize;

/// Names, scales and the unit. Without them boards and channels have numbers, and pressures kPa.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Labels {
    /// The unit on the page; what is sent and received stays in kPa.
    pub unit: UnitLabel,
    /// In the order of the options' board numbers; may be empty.
    pub boards: Vec<BoardLabel>,
}

/// A unit of pressure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnitLabel {
    /// As people write it.
    pub name: &'static str,
    /// One of it in kPa.
    pub kpa: f64,
    /// Decimals that are shown.
    pub decimals: usize,
}

/// A board.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct BoardLabel {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Names of its channels.
    pub channels: [Option<String>; CHANNELS],
    /// Where its charts end, kPa: its highest limit. `None`: a little above what has been.
    pub scale_kpa: Option<f64>,
}

impl Default for UnitLabel {
    fn default() -> Self {
        Self { name: "kPa", kpa: 1.0, decimals: 1 }
    }
}
