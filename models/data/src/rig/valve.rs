//! `[valve]`: the constants of the flow law that a recording cannot tell.

use serde::{Deserialize, Serialize};

/// What is fixed of the flow through a valve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Valve {
    /// Discharge coefficient C_d. Only its product with an area can be identified, so it is fixed.
    pub discharge_coefficient: f64,
    /// Critical pressure ratio b of ISO 6358.
    pub critical_ratio: f64,
}

impl Default for Valve {
    /// C_d = 1, and b = 0.30, usual for small spool valves (an ideal nozzle has 0.528).
    fn default() -> Self {
        Self { discharge_coefficient: 1.0, critical_ratio: 0.30 }
    }
}
