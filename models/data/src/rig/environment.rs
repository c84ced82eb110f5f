//! `[supply]` and `[ambient]`: what the valves connect the chambers to.

use serde::{Deserialize, Serialize};

/// Compressed air before the fill valves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Supply {
    /// Nominal pressure, kPa gauge.
    pub pressure_kpa: f64,
}

/// The room the chambers vent into.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Ambient {
    /// Air pressure, kPa absolute.
    pub pressure_kpa_abs: f64,
    /// Temperature of air and gas, K.
    pub temperature_k: f64,
}

impl Default for Ambient {
    /// The standard atmosphere (101.325 kPa) at 20 degrees Celsius.
    fn default() -> Self {
        Self { pressure_kpa_abs: 101.325, temperature_k: 293.15 }
    }
}
