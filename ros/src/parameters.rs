//! The flags as ROS parameters: all can be read, three can be set while the node runs.

use crate::args::{Settings, check_number};
use crate::live::Live;
use pneudrive_host::poller::{BaudChoice, PageShare};
use ros2_client::{NodeOptions, ParameterValue};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Parameters that may be set, and whether 0 is a value.
pub const SETTABLE: [(&str, bool); 3] =
    [("publish_rate_hz", false), ("max_command_age_s", true), ("command_timeout_s", true)];

/// Parameters by their names.
pub type Initial = BTreeMap<&'static str, ParameterValue>;

/// All parameters with the values they have at the start.
pub fn initial(settings: &Settings) -> Initial {
    let flags = &settings.flags;
    let text = |path: &std::path::Path| path.display().to_string();
    BTreeMap::from([
        ("port", ParameterValue::StringArray(flags.port.iter().map(|port| text(port)).collect())),
        (
            "devices",
            ParameterValue::IntegerArray(
                (0..flags.port.len()).map(|bus| i64::from(settings.devices(bus))).collect(),
            ),
        ),
        ("max_devices", ParameterValue::Integer(flags.max_devices.into())),
        ("first_joint", ParameterValue::Integer(flags.first_joint.into())),
        ("baud", baud(settings.baud())),
        (
            "allowance_us",
            ParameterValue::Integer(flags.allowance().as_micros().try_into().unwrap_or(i64::MAX)),
        ),
        // 0: as fast as possible, or 1000 where the wire allows it.
        ("rate_hz", ParameterValue::Double(flags.rate_hz.unwrap_or(0.0))),
        ("publish_rate_hz", ParameterValue::Double(flags.publish_rate_hz)),
        ("max_command_age_s", ParameterValue::Double(flags.max_command_age_s)),
        ("command_timeout_s", ParameterValue::Double(flags.command_timeout_s)),
        ("max_kpa", ParameterValue::Double(flags.max_kpa.unwrap_or(f64::INFINITY))),
        ("max_rate_kpa_s", ParameterValue::Double(flags.max_rate_kpa_s.unwrap_or(f64::INFINITY))),
        ("rig", ParameterValue::String(flags.rig.as_deref().map(text).unwrap_or_default())),
        ("resume", ParameterValue::Boolean(flags.resume)),
        ("watchdog_s", ParameterValue::Double(flags.watchdog_s)),
        ("message_type", ParameterValue::String(flags.message_type.clone())),
        ("diagnostics_period_s", ParameterValue::Double(flags.diagnostics_period_s)),
        ("watch", ParameterValue::StringArray(flags.watch.iter().map(|file| text(file)).collect())),
        (
            "watch_program",
            ParameterValue::String(flags.watch_program.as_deref().map(text).unwrap_or_default()),
        ),
        // 0: not asked for.
        ("sensors", ParameterValue::Double(flags.sensors.map_or(0.0, PageShare::get))),
        ("record", ParameterValue::String(flags.record.as_deref().map(text).unwrap_or_default())),
    ])
}

/// A number of bit/s, or the text `auto`.
fn baud(choice: BaudChoice) -> ParameterValue {
    match choice {
        BaudChoice::Auto => ParameterValue::String("auto".to_owned()),
        BaudChoice::Rate(rate) => ParameterValue::Integer(rate.into()),
    }
}

/// Sets what may change, as the flags say.
pub fn start(settings: &Settings) -> Arc<Live> {
    let live = Arc::new(Live::default());
    for (name, value) in initial(settings) {
        if let ParameterValue::Double(value) = value {
            live.set(name, value);
        }
    }
    live
}

/// Declares the parameters; those that are set take effect in `live`.
pub fn declare(settings: &Settings, live: &Arc<Live>) -> NodeOptions {
    let initial = initial(settings);
    // Parameters are served, and /rosout written, by ourselves: see there.
    let mut options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
    for (name, value) in &initial {
        options = options.declare_parameter(name, value.clone());
    }
    let live = Arc::clone(live);
    options
        .parameter_validator(Box::new(move |name, value| check(&initial, name, value)))
        .parameter_set_action(Box::new(move |name, value| {
            if let Some(number) = number(value) {
                live.set(name, number);
            }
            Ok(())
        }))
}

/// Whether the parameter `name` may become `value`.
///
/// # Errors
/// Why not, as the user who sets it reads it.
pub fn check(initial: &Initial, name: &str, value: &ParameterValue) -> Result<(), String> {
    match (SETTABLE.iter().find(|(settable, _)| *settable == name), number(value)) {
        (Some((_, may_be_zero)), Some(number)) => {
            check_number(number, *may_be_zero).map_err(|advice| format!("{name} {number}: {advice}"))
        }
        (Some(_), None) => Err(format!("{name}: expected a number")),
        // The library's own, such as use_sim_time.
        (None, _) if !initial.contains_key(name) => Ok(()),
        (None, _) if initial.get(name) == Some(value) => Ok(()),
        (None, _) => Err(format!("{name} cannot change while the node runs: restart it with another value")),
    }
}

/// `value` in the type that the parameter has: `ros2 param set NODE publish_rate_hz 500` sends an
/// integer.
pub fn of_its_type(now: &Option<ParameterValue>, value: ParameterValue) -> ParameterValue {
    match (now, number(&value)) {
        (Some(ParameterValue::Double(_)), Some(number)) => ParameterValue::Double(number),
        _ => value,
    }
}

fn number(value: &ParameterValue) -> Option<f64> {
    match *value {
        ParameterValue::Double(number) => Some(number),
        ParameterValue::Integer(number) => Some(number as f64),
        _ => None,
    }
}
