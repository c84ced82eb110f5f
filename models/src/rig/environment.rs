//! `[supply]` and `[ambient]`: what the valves connect the chambers to.

use serde::{Deserialize, Serialize};

use super::RigError;
use super::check::Checker;

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

impl Supply {
    pub(super) fn check(&self, checker: &Checker<'_>) -> Result<(), RigError> {
        checker.within(
            "supply.pressure_kpa",
            self.pressure_kpa,
            (0.1, 2000.0),
            "kPa",
            "it is the gauge pressure before the fill valves (1 bar = 100 kPa, 1 psi = 6.895 kPa)",
        )
    }
}

impl Ambient {
    pub(super) fn check(&self, checker: &Checker<'_>) -> Result<(), RigError> {
        checker.within(
            "ambient.pressure_kpa_abs",
            self.pressure_kpa_abs,
            (30.0, 120.0),
            "kPa",
            "it is the absolute air pressure, near 101.325 at sea level",
        )?;
        checker.within(
            "ambient.temperature_k",
            self.temperature_k,
            (200.0, 400.0),
            "K",
            "it is in kelvin: add 273.15 to degrees Celsius",
        )
    }
}
