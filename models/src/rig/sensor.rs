//! `[sensor]`: from pressure to counts and back.

use serde::{Deserialize, Serialize};

use crate::data::SensorLimits;

/// A linear sensor read by an ideal converter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
        f64::from((1_u32 << self.bits) - 1)
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

    /// The pressures beyond which a reading says nothing.
    #[must_use]
    pub fn limits(&self) -> SensorLimits {
        SensorLimits {
            low_kpa: self.kpa(0.0),
            high_kpa: self.kpa(self.full_scale_counts()),
            step_kpa: self.kpa_per_count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_go_round_and_limits_are_the_end_codes() {
        let sensor = Sensor { bits: 10, zero_counts: 102.4, kpa_per_count: 0.841_645 };
        assert!((sensor.counts(sensor.kpa(511.0)) - 511.0).abs() < 1e-9);
        let limits = sensor.limits();
        assert!((limits.low_kpa + 86.184).abs() < 1e-3, "{limits:?}");
        assert!((limits.high_kpa - 774.818).abs() < 1e-3, "{limits:?}");
    }
}
