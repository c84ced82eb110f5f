use crate::law::ControlLaw;
use crate::{Micros, ValveDrive};
use pneudrive_protocol::pages::LineRate;
use pneudrive_protocol::{Baud, CHANNELS, Counts};
use thiserror::Error;

/// Everything about a board that a user may want to change, with the original's values as defaults.
///
/// [`Board::new`](crate::Board::new) checks the limits given here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardConfig {
    /// Line rate of the bus; idle gaps and the length of the board's own answer follow from it.
    /// Default 1 Mbaud.
    pub baud: Baud,

    /// Fastest line rate that a host may ask for: what the board's transceiver and driver enable
    /// can do. Default 3 Mbaud. It speaks at [`baud`](Self::baud) until a host asks.
    pub max_baud: LineRate,

    /// Time from the last stop bit of a request to the answer's start bit, at the least, us: 0
    /// to 20. Default 14.
    ///
    /// A host whose line driver is enabled by the boards' 555 circuit holds the line for up to
    /// 113.6 us from its first start bit ([`pulse`](pneudrive_protocol::pulse), with both parts at
    /// their limits), which is 13.6 us after its last stop bit: an answer that begins earlier meets
    /// two drivers on one line. The answer must have begun after 20 us.
    pub answer_delay: Micros,

    /// Whether the board's receiver may hear the board's own answer, which has the form of a
    /// request to it. Default true: what is heard while the answer is on the wire is ignored, and a
    /// host cannot speak then. False where that cannot be and requests may follow at once: a
    /// simulated wire that takes no time.
    pub hears_itself: bool,

    /// Time between two control steps, us: 100 to 10,000. Default 1000, the original's loop of
    /// about 1 kHz.
    ///
    /// `kd` and `filter_previous` count in steps. To keep the closed loop as it is at another
    /// period, multiply `kd` by (old period / new period) and raise `filter_previous` / 256 to the
    /// power of (new period / old period): [`at_twice_the_rate`](Self::at_twice_the_rate) does.
    pub loop_period: Micros,

    /// Proportional gain, drive counts per count of error: 1 to 1000. Default 10: full drive at 40
    /// counts (34 kPa).
    pub kp: u16,

    /// Damping, drive counts per count that the filtered pressure rose in one step: 0 to 1000.
    /// Default 20.
    pub kd: u16,

    /// Largest drive, drive counts: 1 to 400. Default 400, all that the driver gives.
    pub saturation: u16,

    /// Weight of the previous output in the pressure's low-pass, 1/256: 0 (no filter) to 255.
    /// Default 210, a time constant of 5 steps.
    pub filter_previous: u8,

    /// Set point of all channels until the first request. Default 102 counts, atmosphere.
    pub initial_command: Counts,

    /// How long all channels vent from the first control step on, whatever is commanded: at most 60
    /// s. Default 2 s, as the original: whatever pressure the last run left behind is gone.
    pub power_up_vent: Micros,

    /// Silence (no valid request to this board) after which it holds: 10 ms to 10 s. Default 500
    /// ms: hundreds of cycles of a polling host, and no longer than a chamber can be left alone.
    pub command_timeout: Micros,

    /// How long it then holds its set points before it vents: at most 60 s. Default 2 s, for a host
    /// that comes back.
    pub hold_time: Micros,

    /// Reading at the sensor's lowest output, counts. Default 102, which is 0.5 V of 5 V.
    pub sensor_min: Counts,

    /// Reading at the sensor's highest output, counts. Default 922, which is 4.5 V of 5 V.
    pub sensor_max: Counts,

    /// How far outside these a sample may lie before it counts as a fault, counts. Default 51 (0.25
    /// V): a sensor at atmosphere reads 102 counts give or take its offset, while a broken wire or
    /// a short circuit reads 0 or 1023.
    ///
    /// `sensor_min` - margin must be at least 1 and `sensor_max` + margin at most 1022, because 0
    /// and 1023 say "fault" in an answer.
    pub sensor_margin: u16,

    /// Samples in a row outside the limits that make a fault: 1 to 1000. Default 10 (10 ms). Until
    /// then the channel ignores them and goes on with its last good pressure.
    pub fault_after_steps: u16,

    /// Samples in a row inside the limits that end a fault: 1 to 60,000. Default 1000 (1 s), so
    /// that a loose contact does not switch its chamber at every touch.
    pub recover_after_steps: u16,

    /// So many damaged requests in a [`damage_window`](Self::damage_window) make the board vent
    /// until its host leaves or its supply is switched off
    /// ([`BoardState::DamageVent`](crate::BoardState::DamageVent)): 1 to 10,000. Default 50: at 1
    /// kHz one in twenty.
    pub damage_limit: u16,

    /// The window, us: 1 ms to 60 s. Default 1 s.
    pub damage_window: Micros,

    /// Whether a set point rises only as far as two requests in a row want; it falls at once.
    /// Default false.
    pub rise_needs_two: bool,

    /// Channels in use. Default all. A channel that is not in use vents, its sensor is not judged,
    /// and the answer carries whatever its input reads.
    pub enabled: [bool; CHANNELS],
}

impl BoardConfig {
    /// The original's values, usable in constants.
    pub const ORIGINAL: Self = Self {
        baud: Baud::ORIGINAL,
        max_baud: LineRate::ThreeMbaud,
        answer_delay: Micros::new(14),
        hears_itself: true,
        loop_period: Micros::new(1_000),
        kp: 10,
        kd: 20,
        saturation: ValveDrive::FULL as u16,
        filter_previous: 210,
        initial_command: Counts::ATMOSPHERE,
        power_up_vent: Micros::from_millis(2_000),
        command_timeout: Micros::from_millis(500),
        hold_time: Micros::from_millis(2_000),
        sensor_min: Counts::ATMOSPHERE,
        sensor_max: Counts::saturating(922),
        sensor_margin: 51,
        fault_after_steps: 10,
        recover_after_steps: 1_000,
        damage_limit: 50,
        damage_window: Micros::from_millis(1_000),
        rise_needs_two: false,
        enabled: [true; CHANNELS],
    };

    /// The same board with half the loop period: what counts steps is changed so that filter,
    /// damping and sensor faults take the same time as before. Of the original's loop it makes one
    /// of 2 kHz.
    #[must_use]
    pub const fn at_twice_the_rate(self) -> Self {
        // The weight's square root, to the nearest 1/256: two steps weigh as much as one did.
        let square = 4 * 256 * self.filter_previous as u32;
        let filter_previous = square.isqrt().div_ceil(2) as u8;
        Self {
            loop_period: Micros::new(self.loop_period.get() / 2),
            kd: 2 * self.kd,
            filter_previous,
            fault_after_steps: 2 * self.fault_after_steps,
            recover_after_steps: 2 * self.recover_after_steps,
            ..self
        }
    }

    /// Checks every limit stated at the fields; usable in constants.
    ///
    /// # Errors
    /// The first parameter that is outside its limits, by name.
    pub const fn check(&self) -> Result<(), ConfigError> {
        const MINUTE: u64 = 60_000_000;
        let sensor_low = (self.sensor_min.get() as u64).wrapping_sub(self.sensor_margin as u64);
        let sensor_high = self.sensor_max.get() as u64 + self.sensor_margin as u64;
        let limits: [(&'static str, &'static str, u64, u64, u64); 14] = [
            ("answer_delay", "us", self.answer_delay.get(), 0, 20),
            ("loop_period", "us", self.loop_period.get(), 100, 10_000),
            ("kp", "drive counts per count", self.kp as u64, 1, ControlLaw::GAIN_MAX as u64),
            ("kd", "drive counts per count", self.kd as u64, 0, ControlLaw::GAIN_MAX as u64),
            ("saturation", "drive counts", self.saturation as u64, 1, ValveDrive::FULL as u64),
            ("power_up_vent", "us", self.power_up_vent.get(), 0, MINUTE),
            ("command_timeout", "us", self.command_timeout.get(), 10_000, 10_000_000),
            ("hold_time", "us", self.hold_time.get(), 0, MINUTE),
            ("fault_after_steps", "steps", self.fault_after_steps as u64, 1, 1_000),
            ("recover_after_steps", "steps", self.recover_after_steps as u64, 1, 60_000),
            ("damage_limit", "requests", self.damage_limit as u64, 1, 10_000),
            ("damage_window", "us", self.damage_window.get(), 1_000, MINUTE),
            ("sensor_min - sensor_margin", "counts", sensor_low, 1, self.sensor_min.get() as u64),
            ("sensor_max + sensor_margin", "counts", sensor_high, self.sensor_min.get() as u64 + 1, 1_022),
        ];
        let mut index = 0;
        while index < limits.len() {
            let (parameter, unit, value, min, max) = limits[index];
            if value < min || value > max {
                return Err(ConfigError { parameter, unit, value: value as i64, min, max });
            }
            index += 1;
        }
        Ok(())
    }

    /// The lowest sample that is no fault, counts.
    pub(crate) const fn sensor_low(&self) -> Counts {
        Counts::saturating(self.sensor_min.get().saturating_sub(self.sensor_margin))
    }

    /// The highest sample that is no fault, counts.
    pub(crate) const fn sensor_high(&self) -> Counts {
        Counts::saturating(self.sensor_max.get().saturating_add(self.sensor_margin))
    }
}

impl Default for BoardConfig {
    fn default() -> Self {
        Self::ORIGINAL
    }
}

/// A parameter of [`BoardConfig`] outside its limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{parameter} is {value} {unit}; it must be {min} to {max}")]
pub struct ConfigError {
    /// The parameter's name in [`BoardConfig`].
    pub parameter: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The value that was refused.
    pub value: i64,
    /// The smallest value accepted.
    pub min: u64,
    /// The largest value accepted.
    pub max: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_protocol::pulse::{Parts, pulse, resistor_for};
    use std::string::ToString;

    const GOOD: BoardConfig = BoardConfig::ORIGINAL;

    #[test]
    fn the_defaults_are_valid() {
        assert_eq!(BoardConfig::default().check(), Ok(()));
        assert_eq!((GOOD.sensor_low().get(), GOOD.sensor_high().get()), (51, 973));
    }

    #[test]
    fn an_answer_waits_for_the_longest_pulse_of_a_host() {
        let host = pulse(resistor_for(GOOD.baud, Parts::ORIGINAL).unwrap(), Parts::ORIGINAL);
        assert!(GOOD.baud.packet_ns() + GOOD.answer_delay.get() * 1_000 >= host.longest_ns);
    }

    #[test]
    fn every_limit_is_checked_and_named() {
        let counts = |value| Counts::new(value).unwrap();
        let bad = [
            ("answer_delay", BoardConfig { answer_delay: Micros::new(21), ..GOOD }),
            ("loop_period", BoardConfig { loop_period: Micros::new(99), ..GOOD }),
            ("loop_period", BoardConfig { loop_period: Micros::new(10_001), ..GOOD }),
            ("kp", BoardConfig { kp: 0, ..GOOD }),
            ("kp", BoardConfig { kp: 1_001, ..GOOD }),
            ("kd", BoardConfig { kd: 1_001, ..GOOD }),
            ("saturation", BoardConfig { saturation: 0, ..GOOD }),
            ("saturation", BoardConfig { saturation: 401, ..GOOD }),
            ("power_up_vent", BoardConfig { power_up_vent: Micros::new(60_000_001), ..GOOD }),
            ("command_timeout", BoardConfig { command_timeout: Micros::new(9_999), ..GOOD }),
            ("command_timeout", BoardConfig { command_timeout: Micros::new(u64::MAX), ..GOOD }),
            ("hold_time", BoardConfig { hold_time: Micros::new(60_000_001), ..GOOD }),
            ("fault_after_steps", BoardConfig { fault_after_steps: 0, ..GOOD }),
            ("recover_after_steps", BoardConfig { recover_after_steps: 60_001, ..GOOD }),
            ("damage_limit", BoardConfig { damage_limit: 0, ..GOOD }),
            ("damage_limit", BoardConfig { damage_limit: 10_001, ..GOOD }),
            ("damage_window", BoardConfig { damage_window: Micros::new(999), ..GOOD }),
            ("damage_window", BoardConfig { damage_window: Micros::new(60_000_001), ..GOOD }),
            ("sensor_min - sensor_margin", BoardConfig { sensor_margin: 102, ..GOOD }),
            ("sensor_min - sensor_margin", BoardConfig { sensor_margin: 103, ..GOOD }),
            ("sensor_max + sensor_margin", BoardConfig { sensor_max: counts(972), ..GOOD }),
            ("sensor_max + sensor_margin", BoardConfig { sensor_max: counts(50), sensor_margin: 50, ..GOOD }),
        ];
        for (parameter, config) in bad {
            assert_eq!(config.check().map_err(|refused| refused.parameter), Err(parameter), "{config:?}");
        }
    }

    #[test]
    fn an_error_says_what_would_be_right() {
        let error = BoardConfig { saturation: 401, ..GOOD }.check().unwrap_err();
        assert_eq!(error.to_string(), "saturation is 401 drive counts; it must be 1 to 400");
        let error = BoardConfig { sensor_margin: 103, ..GOOD }.check().unwrap_err();
        assert_eq!(error.to_string(), "sensor_min - sensor_margin is -1 counts; it must be 1 to 102");
    }
}
