//! What `ros2 param describe` says of a parameter: the help of its flag, its range, and whether it
//! can be set.

use crate::flags::Flags;
use crate::parameters::SETTABLE;
use clap::CommandFactory;
use ros2_client::ParameterValue;
use ros2_client::parameters::raw;

/// What numbers a parameter may have, both ends included.
const INTEGERS: [(&str, i64, i64); 3] =
    [("max_devices", 1, 255), ("first_joint", 0, 60_000), ("allowance_us", 1, 10_000_000)];

/// As [`INTEGERS`]. Some must be above 0, which a range cannot say.
const NUMBERS: [(&str, f64, f64); 9] = [
    ("rate_hz", 0.0, LARGEST),
    ("publish_rate_hz", 0.0, LARGEST),
    ("max_command_age_s", 0.0, LARGEST),
    ("command_timeout_s", 0.0, LARGEST),
    ("watchdog_s", 0.0, LARGEST),
    ("diagnostics_period_s", 0.0, LARGEST),
    ("max_kpa", 0.0, f64::INFINITY),
    ("max_rate_kpa_s", 0.0, f64::INFINITY),
    ("sensors", 0.0, 1.0),
];

/// No rate and no time is larger.
const LARGEST: f64 = 1e6;

/// Describes the parameter `name`, which has this value.
pub fn descriptor(name: &str, value: &ParameterValue) -> raw::ParameterDescriptor {
    let settable = SETTABLE.iter().find(|(settable, _)| *settable == name);
    let known = *value != ParameterValue::NotSet;
    let constraints = match (settable, name) {
        (Some((_, false)), _) | (_, "diagnostics_period_s") => "above 0",
        (_, "sensors") => "0: not asked for",
        (_, "rate_hz") => "0: as fast as the wire allows, at most 1000",
        _ => "",
    };
    raw::ParameterDescriptor {
        name: name.to_owned(),
        r#type: ParameterValue::to_parameter_type_raw(value),
        description: if known { description(name) } else { String::new() },
        additional_constraints: constraints.to_owned(),
        read_only: known && settable.is_none() && name != "use_sim_time",
        dynamic_typing: false,
        floating_point_range: NUMBERS
            .iter()
            .filter(|(of, ..)| *of == name)
            .map(|&(_, from_value, to_value)| raw::FloatingPointRange { from_value, to_value, step: 0.0 })
            .collect(),
        integer_range: INTEGERS
            .iter()
            .filter(|(of, ..)| *of == name)
            .map(|&(_, from_value, to_value)| raw::IntegerRange { from_value, to_value, step: 1 })
            .collect(),
    }
}

/// The help of the flag.
fn description(name: &str) -> String {
    let flags = Flags::command();
    let flag = flags.get_arguments().find(|flag| flag.get_id() == name);
    let help = flag.and_then(|flag| flag.get_help()).map(ToString::to_string);
    match name {
        "use_sim_time" => "Not used: stamps are the system's time".to_owned(),
        _ => help.unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Settings, check_number};
    use crate::parameters;
    use std::ffi::OsString;

    fn described() -> Vec<raw::ParameterDescriptor> {
        let line = ["x", "--port", "a"].map(OsString::from);
        let settings = Settings::from_command_line(line.into_iter()).unwrap();
        parameters::initial(&settings).iter().map(|(name, value)| descriptor(name, value)).collect()
    }

    #[test]
    fn every_parameter_is_described_and_three_can_be_set() {
        let all = described();
        for parameter in &all {
            assert!(!parameter.description.is_empty(), "{}", parameter.name);
            assert_eq!(
                parameter.floating_point_range.len(),
                usize::from(parameter.r#type == 3),
                "{}",
                parameter.name
            );
        }
        let settable: Vec<_> = all.iter().filter(|one| !one.read_only).map(|one| one.name.as_str()).collect();
        assert_eq!(settable, ["command_timeout_s", "max_command_age_s", "publish_rate_hz"]);
        let age = all.iter().find(|one| one.name == "max_command_age_s");
        assert!(age.is_some_and(|age| age.description.contains("Refuse commands whose stamp")));
    }

    #[test]
    fn ranges_end_where_values_are_refused() {
        for parameter in described().iter().filter(|one| !one.read_only) {
            let range = &parameter.floating_point_range[0];
            let may_be_zero = parameter.additional_constraints.is_empty();
            assert_eq!(check_number(range.from_value, may_be_zero).is_ok(), may_be_zero);
            assert!(check_number(range.to_value, may_be_zero).is_ok());
            assert!(check_number(range.to_value * 1.01, may_be_zero).is_err());
        }
    }

    #[test]
    fn what_is_no_parameter_has_no_type() {
        let unknown = descriptor("other", &ParameterValue::NotSet);
        assert_eq!((unknown.name.as_str(), unknown.r#type, unknown.read_only), ("other", 0, false));
    }
}
