//! The host changes the parameters of virtual boards, in virtual time.

use pneudrive_control::{BoardConfig, ParameterSet};
use pneudrive_host::bus::{
    Bus, BusOptions, ChangeFrom, FormatPolicy, PageError, ParameterChange, ParameterError,
};
use pneudrive_protocol::Counts;
use pneudrive_protocol::pages::{Parameter, ParameterInfo};
use pneudrive_sim::rig::RigOptions;
use system_tests::virtual_bus::{VirtualBus, bus};

fn boards(boards: usize) -> Bus<VirtualBus> {
    bus(&RigOptions { boards, ..RigOptions::default() }, BusOptions::default())
}

#[test]
fn a_change_is_in_effect_after_the_restart_and_a_reset_undoes_it() {
    let mut bus = boards(2);
    let changes = [(Parameter::Kp, 12), (Parameter::CommandTimeout, 250)];
    let started_ns = bus.line().rig_now_ns();
    let done = bus.change_parameters(1, ChangeFrom::InEffect, &changes);
    println!("a change takes {} ms", (bus.line().rig_now_ns() - started_ns) / 1_000_000);
    assert_eq!(done, Ok(ParameterChange::InEffect { board: 1 }));
    assert_eq!((bus.parameter(1, Parameter::Kp), bus.compiled_parameter(1, Parameter::Kp)), (Ok(12), Ok(10)));
    assert_eq!(bus.parameter(1, Parameter::CommandTimeout), Ok(250));
    assert_eq!(bus.parameter(0, Parameter::Kp), Ok(10), "the other board");
    let again = bus.change_parameters(1, ChangeFrom::InEffect, &changes);
    assert_eq!(again, Ok(ParameterChange::Unchanged));
    let more = bus.change_parameters(1, ChangeFrom::InEffect, &[(Parameter::Kd, 5)]);
    assert_eq!(more, Ok(ParameterChange::InEffect { board: 1 }));
    assert_eq!((bus.parameter(1, Parameter::Kp), bus.parameter(1, Parameter::Kd)), (Ok(12), Ok(5)));
    let reset = bus.change_parameters(1, ChangeFrom::Compiled, &[]);
    assert_eq!(reset, Ok(ParameterChange::InEffect { board: 1 }));
    assert_eq!((bus.parameter(1, Parameter::Kp), bus.parameter(1, Parameter::Kd)), (Ok(10), Ok(20)));
    assert_eq!(bus.line().counters().unasked, 0);
}

#[test]
fn a_board_moves_to_another_address_unless_that_is_taken() {
    let mut bus = boards(2);
    let taken = bus.change_parameters(1, ChangeFrom::InEffect, &[(Parameter::Address, 0)]).unwrap_err();
    assert!(matches!(taken, ParameterError::AddressTaken { wanted: 0, .. }), "{taken}");
    let moved = bus.change_parameters(1, ChangeFrom::InEffect, &[(Parameter::Address, 200)]);
    assert_eq!(moved, Ok(ParameterChange::InEffect { board: 200 }));
    assert_eq!(bus.parameter(200, Parameter::Address), Ok(200));
    assert!(bus.ping(1).is_err());
    assert!(bus.ping(200).is_ok());
    assert_eq!(bus.line().counters().unasked, 0, "the board answers to its new address");
    let back = bus.change_parameters(200, ChangeFrom::Compiled, &[]);
    assert_eq!(back, Ok(ParameterChange::AtSwitchAddress));
    let later_ns = bus.line().rig_now_ns() + 300_000_000;
    bus.line_mut().sleep_until_s(later_ns as f64 / 1e9);
    assert!(bus.ping(1).is_ok());
}

#[test]
fn what_does_not_go_together_is_refused_by_name_and_changes_nothing() {
    let mut bus = boards(1);
    let changes = [(Parameter::Kp, 12), (Parameter::SensorMargin, 103)];
    let refused = bus.change_parameters(0, ChangeFrom::InEffect, &changes).unwrap_err();
    assert!(matches!(refused, ParameterError::Refused { parameter: Parameter::SensorMin, .. }), "{refused}");
    let beyond = bus.change_parameters(0, ChangeFrom::InEffect, &[(Parameter::Kp, 1_001)]).unwrap_err();
    assert!(matches!(beyond, ParameterError::Refused { parameter: Parameter::Kp, .. }), "{beyond}");
    assert_eq!(bus.parameter(0, Parameter::Kp), Ok(10));
}

/// Pressure in the chambers, although the host commands 0 kPa first.
#[test]
fn a_board_with_pressure_refuses() {
    let mut bus = boards(1);
    let filled = [Counts::saturating(500); 4];
    for _ in 0..400 {
        bus.exchange(0, filled).unwrap();
        let next_s = bus.line().rig_now_ns() as f64 / 1e9 + 0.01;
        bus.line_mut().sleep_until_s(next_s);
    }
    assert!(bus.exchange(0, filled).unwrap().pressures[0].get() > 400);
    let refused = bus.change_parameters(0, ChangeFrom::InEffect, &[(Parameter::Kp, 12)]).unwrap_err();
    assert!(matches!(refused, ParameterError::NotVented { .. }), "{refused}");
    assert_eq!(bus.parameter(0, Parameter::Kp), Ok(10));
}

/// The table of docs/firmware.md is that of the protocol, with the values that boards are compiled
/// with.
#[test]
fn the_manual_has_the_same_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/firmware.md");
    let manual = std::fs::read_to_string(path).unwrap();
    let compiled = ParameterSet::of(&BoardConfig::ORIGINAL);
    for parameter in Parameter::ALL {
        let info = parameter.info();
        let ParameterInfo { name, unit, min, max, meaning } = info;
        let row = format!("| `{name}` | {unit} | {min} to {max} | {} | {meaning} |", compiled.get(parameter));
        assert!(manual.contains(&row), "{row}");
    }
}

/// Without a session, and at a board of the original kind, nothing is changed.
#[test]
fn who_cannot_be_changed_says_so() {
    let one = RigOptions { boards: 1, ..RigOptions::default() };
    let mut bare = bus(&one, BusOptions::default().sessions(false));
    let refused = bare.change_parameters(0, ChangeFrom::InEffect, &[(Parameter::Kp, 12)]).unwrap_err();
    assert!(matches!(refused, ParameterError::NoSession { .. }), "{refused}");
    let mut unchecked = bus(&one, BusOptions::default().formats(FormatPolicy::Unchecked));
    let refused = unchecked.parameter(0, Parameter::Kp).unwrap_err();
    assert!(matches!(refused, PageError::NotChecked { .. }), "{refused}");
}
