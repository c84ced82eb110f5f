//! `board show`, `board set` and `board reset`: a board's parameters.

use crate::args::{BoardSetArgs, BusArgs};
use crate::board::{connect_to, explained, persist};
use crate::failure::Failure;
use crate::output::{outln, print_json};
use crate::setup::Setup;
use pneudrive_host::bus::{Bus, ChangeFrom, PageError, ParameterChange, ParameterError};
use pneudrive_protocol::pages::{Parameter, ParameterInfo, ParameterSource, StoreState};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// A board's parameters.
#[derive(Serialize)]
struct ParameterReport {
    port: String,
    board: u8,
    /// Whether any of them is not as compiled.
    changed: bool,
    /// Number of the record in its flash, modulo 1024.
    record: u16,
    parameters: BTreeMap<&'static str, ParameterValue>,
}

#[derive(Serialize)]
struct ParameterValue {
    value: u32,
    compiled: u32,
    unit: &'static str,
    min: u32,
    max: u32,
}

/// Prints them.
pub fn show(args: &BusArgs, board: u8, setup: &Setup) -> Result<(), Failure> {
    let mut connection = connect_to(args, board, setup)?;
    let bus = &mut connection.bus;
    let report = ask(bus, board, args.wait).map_err(|error| Failure::running(of_page(&error)))?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&report, &setup.board(board));
    }
    drop(connection.virtual_boards);
    Ok(())
}

fn ask(bus: &mut Bus, board: u8, wait_s: f64) -> Result<ParameterReport, PageError> {
    let until = Instant::now() + Duration::from_secs_f64(wait_s);
    let store: StoreState = persist(until, || bus.parameter_store(board))?;
    let mut parameters = BTreeMap::new();
    for parameter in Parameter::ALL {
        let ParameterInfo { name, unit, min, max, .. } = parameter.info();
        let value = match persist(until, || bus.parameter(board, parameter)) {
            // Firmware of before this parameter.
            Err(PageError::NoSuchEntry { .. }) => continue,
            value => value?,
        };
        let compiled = persist(until, || bus.compiled_parameter(board, parameter))?;
        parameters.insert(name, ParameterValue { value, compiled, unit, min, max });
    }
    Ok(ParameterReport {
        port: bus.line().path().display().to_string(),
        board,
        changed: store.source == ParameterSource::Stored,
        record: store.record,
        parameters,
    })
}

fn print(report: &ParameterReport, name: &str) {
    if report.changed {
        outln!("{name}: parameters from its flash, record {}", report.record);
    } else {
        outln!("{name}: parameters as compiled");
    }
    for parameter in Parameter::ALL {
        let info = parameter.info();
        let Some(ParameterValue { value, compiled, unit, min, max }) = report.parameters.get(info.name)
        else {
            continue;
        };
        let mark = if value == compiled { String::new() } else { format!(", compiled {compiled}") };
        let value = format!("{value} {unit}");
        outln!("  {:<20}{value:<24}{} ({min} to {max}{mark})", info.name, info.meaning);
    }
}

/// Changes some of them.
pub fn set(args: &BusArgs, set: &BoardSetArgs, setup: &Setup) -> Result<(), Failure> {
    let changes = set.changes.iter().map(|text| parse_set(text)).collect::<Result<Vec<_>, _>>()?.concat();
    if let Some((twice, _)) = changes
        .iter()
        .enumerate()
        .find_map(|(n, change)| changes[..n].iter().any(|before| before.0 == change.0).then_some(change))
    {
        return Err(Failure::input(format!("{} is given twice", twice.info().name)));
    }
    change(args, set.board.board, ChangeFrom::InEffect, &changes, setup)
}

/// Changes all of them back.
pub fn reset(args: &BusArgs, board: u8, setup: &Setup) -> Result<(), Failure> {
    change(args, board, ChangeFrom::Compiled, &[], setup)
}

/// What became of a change.
#[derive(Serialize)]
struct ChangeReport {
    port: String,
    /// Its number now; null if its switch says it.
    board: Option<u8>,
    /// Whether anything had to be changed.
    changed: bool,
}

fn change(
    args: &BusArgs,
    board: u8,
    from: ChangeFrom,
    changes: &[(Parameter, u32)],
    setup: &Setup,
) -> Result<(), Failure> {
    let mut connection = connect_to(args, board, setup)?;
    let bus = &mut connection.bus;
    let done = bus.change_parameters(board, from, changes);
    let done = done.map_err(|error| Failure::running(of_change(&error)))?;
    let (now, changed) = match done {
        ParameterChange::Unchanged => (Some(board), false),
        ParameterChange::InEffect { board } => (Some(board), true),
        ParameterChange::AtSwitchAddress => (None, true),
    };
    if let Some(board) = now {
        // It has vented already, and forgets this host by itself, too.
        let _ = bus.leave(board);
    }
    let port = bus.line().path().display().to_string();
    if args.json {
        print_json(&ChangeReport { port, board: now, changed })?;
    } else {
        let name = setup.board(board);
        match now {
            _ if !changed => outln!("{name}: was so already, nothing was written"),
            Some(now) if now == board => outln!("{name}: kept in its flash and in effect; it has restarted"),
            Some(now) => outln!("{name}: kept in its flash and in effect; it has restarted as board {now}"),
            None => outln!("{name}: kept in its flash; it has restarted at the address of its switch"),
        }
    }
    drop(connection.virtual_boards);
    Ok(())
}

/// `NAME=VALUE`, or `loop_rate=HZ` for all that a loop of that rate needs.
fn parse_set(text: &str) -> Result<Vec<(Parameter, u32)>, Failure> {
    match text.split_once('=') {
        Some(("loop_rate", "1000")) => Ok(Parameter::LOOP_1_KHZ.to_vec()),
        Some(("loop_rate", "2000")) => Ok(Parameter::LOOP_2_KHZ.to_vec()),
        Some(("loop_rate", _)) => Err(Failure::input(format!("{text}: must be 1000 or 2000 Hz"))),
        _ => parse(text).map(|change| vec![change]),
    }
}

/// `NAME=VALUE`, in the parameter's range.
fn parse(text: &str) -> Result<(Parameter, u32), Failure> {
    let Some((name, value)) = text.split_once('=') else {
        return Err(Failure::input(format!("{text}: must be NAME=VALUE, such as kp=12")));
    };
    let Some(parameter) = Parameter::of_name(name) else {
        return Err(Failure::input(format!(
            "{name}: no such parameter{}; `board show` lists them",
            similar(name)
        )));
    };
    let ParameterInfo { min, max, unit, .. } = parameter.info();
    if (parameter, value) == (Parameter::Address, "switch") {
        return Ok((parameter, Parameter::BY_SWITCH));
    }
    match value.parse() {
        Ok(value) if (min..=max).contains(&value) => Ok((parameter, value)),
        _ => {
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            Err(Failure::input(format!("{name}={value}: must be a whole number from {min} to {max}{unit}")))
        }
    }
}

/// A known name like this one, in words.
fn similar(name: &str) -> String {
    let closest = Parameter::ALL
        .map(|parameter| parameter.info().name)
        .into_iter()
        .map(|known| (strsim::jaro_winkler(name, known), known))
        .max_by(|one, other| one.0.total_cmp(&other.0));
    match closest {
        Some((likeness, known)) if likeness > 0.7 => format!(", did you mean {known}"),
        _ => String::new(),
    }
}

fn of_page(error: &PageError) -> String {
    match error {
        PageError::NoSuchEntry { asked, .. } => {
            format!("{asked}: its firmware is of before parameters that a host can change; flash a newer one")
        }
        error => explained(error),
    }
}

fn of_change(error: &ParameterError) -> String {
    match error {
        ParameterError::Page(error) => of_page(error),
        error => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_meant_is_refused_with_what_could_be() {
        let words = |text| parse_set(text).unwrap_err().to_string();
        assert_eq!(parse_set("loop_rate=2000"), Ok(Parameter::LOOP_2_KHZ.to_vec()));
        assert_eq!(words("loop_rate=1500"), "loop_rate=1500: must be 1000 or 2000 Hz");
        assert_eq!(parse("kp=12"), Ok((Parameter::Kp, 12)));
        assert_eq!(parse("address=switch"), Ok((Parameter::Address, 256)));
        assert_eq!(words("kp=0"), "kp=0: must be a whole number from 1 to 1000 drive counts/count");
        assert_eq!(words("address=-1"), "address=-1: must be a whole number from 0 to 256");
        assert_eq!(words("kp"), "kp: must be NAME=VALUE, such as kp=12");
        assert_eq!(
            words("comand_timeout=5"),
            "comand_timeout: no such parameter, did you mean command_timeout; `board show` lists them"
        );
        assert_eq!(words("xyz=5"), "xyz: no such parameter; `board show` lists them");
    }
}
