//! A board's pressure sensor: from pressure to counts and back.

use serde::{Deserialize, Serialize};

/// A linear sensor read by an ideal converter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    /// Resolution of the converter; codes run from 0 to 2^bits - 1.
    pub bits: u32,
    /// Reading at 0 kPa gauge, counts.
    pub zero_counts: f64,
    /// Size of one count, kPa.
    pub kpa_per_count: f64,
}

impl Sensor {
    /// The highest code.
    #[must_use]
    pub fn full_scale_counts(&self) -> f64 {
        f64::from(self.bits).exp2() - 1.0
    }

    /// Size of one count, Pa.
    #[must_use]
    pub fn pa_per_count(&self) -> f64 {
        self.kpa_per_count * 1e3
    }

    /// Pressure at a reading of `counts`, kPa gauge.
    #[must_use]
    pub fn kpa(&self, counts: f64) -> f64 {
        (counts - self.zero_counts) * self.kpa_per_count
    }

    /// Reading at a pressure of `kpa` gauge, counts, neither rounded nor limited.
    #[must_use]
    pub fn counts(&self, kpa: f64) -> f64 {
        kpa / self.kpa_per_count + self.zero_counts
    }
}
