//! `board`: what a board says of itself, by page requests. `status` commands nothing.

use crate::cli::args::{BoardArgs, BoardCommand, BoardStatusArgs, BusArgs};
use crate::cli::connect::{Connection, connect, devices as devices_of};
use crate::cli::failure::Failure;
use crate::cli::output::{outln, print_json};
use crate::cli::setup::Setup;
use crate::cli::{board_parameters, board_update};
use pneudrive_host::bus::{Bus, ExchangeError, PageError};
use pneudrive_protocol::pages::{About, Counter, Drives, NowState, PostMortem};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// What a board said.
#[derive(Serialize)]
struct StatusReport {
    port: String,
    board: u8,
    chip: String,
    /// Version of its firmware.
    firmware: String,
    /// `power_up_vent`, `running`, `hold`, `vent` or `damage_vent`.
    state: &'static str,
    /// Of each channel: `regulating`, `venting`, `sensor_below_range`, `sensor_above_range` or `disabled`.
    channels: [&'static str; 4],
    /// Of each valve: -1 (vent fully) to 1 (fill fully).
    drives: [f64; 4],
    /// By name, those that its firmware has; us where the name says so, s where it says so.
    counters: BTreeMap<&'static str, u32>,
    /// Why its watchdog reset it last, in words; null where it has not since power-on, or nothing is known.
    post_mortem: Option<String>,
}

/// A word of the post-mortem that is lost is asked for so often.
const TRIES: u32 = 100;

pub fn run(args: &BusArgs, board: &BoardArgs, setup: &Setup) -> Result<(), Failure> {
    match &board.command {
        BoardCommand::Status(status) => show(args, *status, setup),
        BoardCommand::Show(status) => board_parameters::show(args, status.board, setup),
        BoardCommand::Set(set) => board_parameters::set(args, set, setup),
        BoardCommand::Reset(status) => board_parameters::reset(args, status.board, setup),
        BoardCommand::Update(update) => board_update::update(args, update, setup),
    }
}

/// A bus with this board on it.
pub fn connect_to(args: &BusArgs, board: u8, setup: &Setup) -> Result<Connection, Failure> {
    if u16::from(board) >= args.max_devices {
        return Err(Failure::input(format!(
            "--board {board}: boards with more than a two-way address switch need --max-devices, up to 256"
        )));
    }
    // As many virtual boards as there must be, where none are asked for.
    let least = u16::from(board) + 1;
    let devices = Some(args.devices.unwrap_or(least).max(least));
    let devices = devices_of(&BusArgs { devices, ..args.clone() }, least)?;
    connect(args, devices, &setup.calibration)
}

fn show(args: &BusArgs, BoardStatusArgs { board }: BoardStatusArgs, setup: &Setup) -> Result<(), Failure> {
    let mut connection = connect_to(args, board, setup)?;
    let bus = &mut connection.bus;
    let report = ask(bus, board, args.wait).map_err(|error| Failure::running(explained(&error)))?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&report, &setup.board(board));
    }
    connection.behind.end();
    Ok(())
}

/// Firmware that knows no pages keeps silent, as a board that is not there does.
pub fn explained(error: &PageError) -> String {
    match error {
        PageError::Exchange(ExchangeError::NoAnswer { .. }) => {
            format!(
                "{error}; firmware of before pages does not answer them: `ping` tells whether the board is there"
            )
        }
        PageError::Exchange(ExchangeError::OriginalFormat { .. }) => format!("{error}; it has no pages"),
        error => error.to_string(),
    }
}

/// What is lost is asked for again, for so long.
fn ask(bus: &mut Bus, board: u8, wait_s: f64) -> Result<StatusReport, PageError> {
    let until = Instant::now() + Duration::from_secs_f64(wait_s);
    let about: About = persist(until, || bus.about(board))?;
    let state: NowState = persist(until, || bus.board_state(board))?;
    let (drives, _): (Drives, u64) = persist(until, || bus.drives(board))?;
    let mut counters = BTreeMap::new();
    for counter in Counter::ALL {
        match persist(until, || bus.counter(board, counter)) {
            Ok(value) => drop(counters.insert(counter.name(), value)),
            // Firmware of before this counter.
            Err(PageError::NoSuchEntry { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    let post_mortem: Option<PostMortem> = bus.post_mortem(board, TRIES)?;
    Ok(StatusReport {
        port: bus.line().path().display().to_string(),
        board,
        chip: about.chip.to_string(),
        firmware: about.version.map(|number| number.to_string()).join("."),
        state: state.board.name(),
        channels: state.channels.map(|channel| channel.name()),
        drives: drives.share(),
        counters,
        post_mortem: post_mortem.map(|record| record.to_string()),
    })
}

/// Asks again where the exchange failed, but not where the line did, or nothing would change.
pub fn persist<T>(until: Instant, mut ask: impl FnMut() -> Result<T, PageError>) -> Result<T, PageError> {
    loop {
        match ask() {
            Err(PageError::Exchange(error))
                if !matches!(error, ExchangeError::Line(_) | ExchangeError::OriginalFormat { .. })
                    && Instant::now() < until => {}
            result => return result,
        }
    }
}

fn print(report: &StatusReport, name: &str) {
    let words = |name: &str| name.replace('_', " ");
    outln!("{name}: {}, firmware {}, {}", report.chip, report.firmware, words(report.state));
    for (channel, (status, drive)) in report.channels.iter().zip(report.drives).enumerate() {
        outln!("  channel {channel}: {}, drive {drive:+.4}", words(status));
    }
    for counter in Counter::ALL {
        let name = counter.name();
        if let Some(value) = report.counters.get(name) {
            outln!("  {}: {value}", words(name));
        }
    }
    match &report.post_mortem {
        Some(record) => outln!("  last reset by the watchdog: {record}"),
        None => outln!("  last reset by the watchdog: none known since power-on"),
    }
}
