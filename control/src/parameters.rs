//! The parameters that a host can change, between [`BoardConfig`] and the numbers that go over the
//! bus and into flash.

use crate::{BoardConfig, Micros};
use pneudrive_protocol::pages::{LineRate, Parameter};
use pneudrive_protocol::{Address, CHANNELS, Counts};

/// A value for every [`Parameter`], in the unit of [`Parameter::info`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParameterSet([u32; Parameter::COUNT]);

impl ParameterSet {
    /// The values of a configuration, with the address left to the board's switch. Times are whole
    /// milliseconds, rounded down, where the parameter's unit is that.
    pub fn of(config: &BoardConfig) -> Self {
        let mut set = Self([0; Parameter::COUNT]);
        for parameter in Parameter::ALL {
            set.set(parameter, value_in(config, parameter));
        }
        set
    }

    /// A parameter's value.
    pub fn get(&self, parameter: Parameter) -> u32 {
        self.0.get(parameter as usize).copied().unwrap_or(0)
    }

    /// Sets it, whatever its range.
    pub fn set(&mut self, parameter: Parameter, value: u32) {
        if let Some(slot) = self.0.get_mut(parameter as usize) {
            *slot = value;
        }
    }

    /// The configuration with these values, and the rest as in `compiled`: by the same rules as a
    /// compiled one.
    ///
    /// # Errors
    /// A parameter that is outside its range, or that does not go together with others.
    pub fn apply_to(&self, compiled: &BoardConfig) -> Result<BoardConfig, Parameter> {
        let before = Self::of(compiled);
        let mut config = *compiled;
        for parameter in Parameter::ALL {
            let (value, info) = (self.get(parameter), parameter.info());
            if !(info.min..=info.max).contains(&value) {
                return Err(parameter);
            }
            // A compiled time need not be whole milliseconds.
            if value != before.get(parameter) {
                put(&mut config, parameter, value);
            }
        }
        config.check().map_err(|error| parameter_of_rule(error.parameter))?;
        Ok(config)
    }

    /// The address of a board whose switch stands at `switch`.
    pub fn address(&self, switch: Address) -> Address {
        u8::try_from(self.get(Parameter::Address)).map_or(switch, Address::of_board)
    }
}

/// Which parameter a rule of [`BoardConfig::check`] is about, where each by itself is in its range:
/// one of the two rules about the sensor's limits. (To look for its name among all takes 1.7 KB of
/// code, which start-up copies to RAM.)
fn parameter_of_rule(rule: &str) -> Parameter {
    if rule.starts_with("sensor_max") { Parameter::SensorMax } else { Parameter::SensorMin }
}

fn millis(time: Micros) -> u32 {
    u32::try_from(time.get() / 1_000).unwrap_or(u32::MAX)
}

fn value_in(config: &BoardConfig, parameter: Parameter) -> u32 {
    let micros = |time: Micros| u32::try_from(time.get()).unwrap_or(u32::MAX);
    match parameter {
        Parameter::Address => Parameter::BY_SWITCH,
        Parameter::Kp => config.kp.into(),
        Parameter::Kd => config.kd.into(),
        Parameter::Saturation => config.saturation.into(),
        Parameter::FilterPrevious => config.filter_previous.into(),
        Parameter::LoopPeriod => micros(config.loop_period),
        Parameter::AnswerDelay => micros(config.answer_delay),
        Parameter::PowerUpVent => millis(config.power_up_vent),
        Parameter::CommandTimeout => millis(config.command_timeout),
        Parameter::HoldTime => millis(config.hold_time),
        Parameter::SensorMin => config.sensor_min.get().into(),
        Parameter::SensorMax => config.sensor_max.get().into(),
        Parameter::SensorMargin => config.sensor_margin.into(),
        Parameter::FaultAfterSteps => config.fault_after_steps.into(),
        Parameter::RecoverAfterSteps => config.recover_after_steps.into(),
        Parameter::DamageLimit => config.damage_limit.into(),
        Parameter::DamageWindow => millis(config.damage_window),
        Parameter::RiseNeedsTwo => config.rise_needs_two.into(),
        Parameter::Channels => {
            (0..).zip(config.enabled).fold(0, |bits, (bit, used)| bits | u32::from(used) << bit)
        }
        Parameter::MaxBaud => config.max_baud as u32,
    }
}

/// `value` is in the parameter's range.
fn put(config: &mut BoardConfig, parameter: Parameter, value: u32) {
    let small = u16::try_from(value).unwrap_or(u16::MAX);
    let counts = Counts::saturating(small);
    let (micros, millis) = (Micros::new(value.into()), Micros::from_millis(value.into()));
    match parameter {
        Parameter::Address => {}
        Parameter::Kp => config.kp = small,
        Parameter::Kd => config.kd = small,
        Parameter::Saturation => config.saturation = small,
        Parameter::FilterPrevious => config.filter_previous = u8::try_from(value).unwrap_or(u8::MAX),
        Parameter::LoopPeriod => config.loop_period = micros,
        Parameter::AnswerDelay => config.answer_delay = micros,
        Parameter::PowerUpVent => config.power_up_vent = millis,
        Parameter::CommandTimeout => config.command_timeout = millis,
        Parameter::HoldTime => config.hold_time = millis,
        Parameter::SensorMin => config.sensor_min = counts,
        Parameter::SensorMax => config.sensor_max = counts,
        Parameter::SensorMargin => config.sensor_margin = small,
        Parameter::FaultAfterSteps => config.fault_after_steps = small,
        Parameter::RecoverAfterSteps => config.recover_after_steps = small,
        Parameter::DamageLimit => config.damage_limit = small,
        Parameter::DamageWindow => config.damage_window = millis,
        Parameter::RiseNeedsTwo => config.rise_needs_two = value != 0,
        Parameter::Channels => {
            let mut enabled = [false; CHANNELS];
            for (bit, used) in enabled.iter_mut().enumerate() {
                *used = value >> bit & 1 == 1;
            }
            config.enabled = enabled;
        }
        Parameter::MaxBaud => {
            let rate = u8::try_from(value).ok().and_then(LineRate::of_number);
            config.max_baud = rate.unwrap_or(LineRate::Compiled);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMPILED: BoardConfig = BoardConfig::ORIGINAL;

    fn with(parameter: Parameter, value: u32) -> Result<BoardConfig, Parameter> {
        let mut set = ParameterSet::of(&COMPILED);
        set.set(parameter, value);
        set.apply_to(&COMPILED)
    }

    /// Both limits of the table, and what lies beyond them, so that table and `check` cannot part.
    #[test]
    fn the_table_and_the_rules_of_compiled_parameters_agree() {
        use Parameter::{
            Address, Channels, FilterPrevious, MaxBaud, RiseNeedsTwo, SensorMargin, SensorMax, SensorMin,
        };
        for parameter in Parameter::ALL {
            let info = parameter.info();
            assert_eq!(with(parameter, info.max + 1), Err(parameter));
            assert_eq!(with(parameter, info.min.wrapping_sub(1)), Err(parameter));
            if [Address, Channels, FilterPrevious, MaxBaud, RiseNeedsTwo, SensorMargin, SensorMax, SensorMin]
                .contains(&parameter)
            {
                continue;
            }
            for value in [info.min, info.max] {
                let config = with(parameter, value).unwrap();
                assert_eq!(ParameterSet::of(&config).get(parameter), value, "{info:?}");
            }
            // Just outside, the compiled rules refuse too.
            for value in [info.min.checked_sub(1), Some(info.max + 1)].into_iter().flatten() {
                let mut config = COMPILED;
                put(&mut config, parameter, value);
                assert!(config.check().is_err(), "{info:?}: {value}");
            }
        }
    }

    #[test]
    fn values_that_do_not_go_together_are_refused_by_name() {
        assert_eq!(with(Parameter::SensorMargin, 103), Err(Parameter::SensorMin));
        assert_eq!(with(Parameter::SensorMax, 1_000), Err(Parameter::SensorMax));
        assert!(with(Parameter::SensorMax, 970).is_ok());
    }

    #[test]
    fn every_value_arrives_in_the_configuration() {
        let changed = [
            (Parameter::FilterPrevious, 100),
            (Parameter::SensorMin, 110),
            (Parameter::SensorMargin, 40),
            (Parameter::RiseNeedsTwo, 1),
            (Parameter::Channels, 0b0101),
            (Parameter::MaxBaud, 1),
            (Parameter::MaxBaud, 2),
        ];
        for (parameter, value) in changed {
            let config = with(parameter, value).unwrap();
            assert_ne!(config, COMPILED);
            assert_eq!(ParameterSet::of(&config).get(parameter), value);
        }
        assert_eq!(with(Parameter::Channels, 0b0101).unwrap().enabled, [true, false, true, false]);
    }

    #[test]
    fn a_compiled_time_that_is_no_whole_millisecond_stays() {
        let odd = BoardConfig { hold_time: Micros::new(1_500_700), ..COMPILED };
        let mut set = ParameterSet::of(&odd);
        set.set(Parameter::Kp, 12);
        assert_eq!(set.apply_to(&odd), Ok(BoardConfig { kp: 12, ..odd }));
    }

    #[test]
    fn the_address_is_the_switch_unless_it_is_set() {
        let mut set = ParameterSet::of(&COMPILED);
        let switch = Address::of_board(2);
        assert_eq!(set.address(switch), switch);
        set.set(Parameter::Address, 77);
        assert_eq!(set.address(switch), Address::of_board(77));
    }
}
