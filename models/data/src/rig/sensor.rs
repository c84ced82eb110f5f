//! `[sensor]`: from pressure to counts and back.

use crate::SensorLimits;
pub use pneudrive_plant::board::Sensor;

impl From<Sensor> for SensorLimits {
    /// The pressures beyond which a reading says nothing.
    fn from(sensor: Sensor) -> Self {
        Self {
            low_kpa: sensor.kpa(0.0),
            high_kpa: sensor.kpa(sensor.full_scale_counts()),
            step_kpa: sensor.kpa_per_count,
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
        let limits = SensorLimits::from(sensor);
        assert!((limits.low_kpa + 86.184).abs() < 1e-3, "{limits:?}");
        assert!((limits.high_kpa - 774.818).abs() < 1e-3, "{limits:?}");
    }
}
