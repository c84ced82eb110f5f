#![allow(clippy::unwrap_used, reason = "the faults are constants, and a virtual line does not fail")]

use super::Case;
use super::air::Waves;
use super::board::SpiedBoard;
use super::host::{Believer, NewEveryCycle, TappedLine};
use super::strangers::{LineWithStranger, Met, Speech, Stranger};
use super::truth::SharedTruth;
use crate::firmware;
use crate::virtual_bus::VirtualBus;
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{Pace, PollerOptions, Polling};
use pneudrive_protocol::{Address, Baud, Echo};
use pneudrive_sim::board::{ChipBoard, I2cConfig, NativeBoard, NativeBoardConfig};
use pneudrive_sim::bus::{self, BusNode};
use pneudrive_sim::fault::FaultInjector;
use std::time::Duration;

/// What is on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Boards {
    /// The control crate, natively.
    Native,
    /// The firmware's ELF on emulated chips.
    Chips,
}

impl Boards {
    /// As it stands in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            Self::Chips => "chips",
        }
    }

    /// How long a stranger is met, s of virtual time.
    fn seconds_with_stranger(self) -> u64 {
        match self {
            Self::Native => 10,
            Self::Chips => 3,
        }
    }

    /// How long a run lasts, s of virtual time.
    pub fn seconds(self, case: &Case) -> u64 {
        match self {
            Self::Native => 20,
            Self::Chips => case.chip_seconds,
        }
    }
}

/// A run of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// What is on the bus.
    pub boards: Boards,
    /// In which packets the host speaks.
    pub frames: FormatPolicy,
    /// Whether it asks the boards for sessions.
    pub sessions: bool,
    /// What goes wrong.
    pub case: Case,
}

/// What came of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// Requests sent.
    pub tried: u64,
    /// Requests without an answer that the host accepted.
    pub lost: u64,
    /// Answers accepted that the board had not given to that request.
    pub wrong_pressures: u64,
    /// Requests obeyed that the host had not sent to that board.
    pub wrong_commands: u64,
    /// Longest time from one answer of a board to its next, less the fault's own duration and the
    /// period, ns.
    pub recovery_ns: u64,
    /// Greatest age of the command that a board's valves acted on, from its first bit on the wire,
    /// ns.
    pub oldest_command_ns: u64,
    /// How often the fault took effect.
    pub struck: u64,
}

const DEVICES: u8 = 2;
const PERIOD_NS: u64 = 1_000_000;
/// Until then the boards boot.
const START_NS: u64 = 200_000_000;
const SEED: u64 = 8;

/// Two boards, polled at 1 kHz.
///
/// # Panics
/// The firmware does not build, or the fault is none.
pub fn run(setting: Setting) -> Outcome {
    let kind = setting.case.fault.split(['=', '@']).next().unwrap_or_default();
    let truth = SharedTruth::new(usize::from(DEVICES));
    let mut rig = rig(setting.boards, &[setting.case.fault], &truth);
    rig.run_until(START_NS);
    let line = TappedLine::new(VirtualBus::new(rig), truth.clone());
    let options = BusOptions::default().formats(setting.frames).sessions(setting.sessions).echo(echo(kind));
    let bus = Bus::new(line, options).unwrap();
    let pace = Pace::every(Duration::from_nanos(PERIOD_NS));
    let polled = PollerOptions::for_devices(DEVICES.into()).pace(pace);
    let (believer, silences) = Believer::new(truth.clone());
    let mut polling = Polling::new(bus, polled, Box::new(NewEveryCycle(0)), vec![Box::new(believer)]);
    let end_ns = START_NS + setting.boards.seconds(&setting.case) * 1_000_000_000;
    while polling.bus_mut().line().now_ns() < end_ns {
        let due = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due);
        polling.cycle().unwrap();
    }
    let statistics = polling.finish();
    let now_ns = polling.bus_mut().line().now_ns();
    let struck = polling.bus_mut().line().bus().counters().fault(kind);
    let mut truth = truth.lock();
    truth.end(now_ns);
    let expected_ns = setting.case.lasts_ms * 1_000_000 + PERIOD_NS;
    Outcome {
        tried: statistics.exchanges,
        lost: statistics.lost,
        wrong_pressures: truth.wrong_pressures(),
        wrong_commands: truth.wrong_commands(),
        recovery_ns: silences.longest_ns(now_ns).saturating_sub(expected_ns),
        oldest_command_ns: truth.oldest_command_ns(),
        struck,
    }
}

/// Two boards, polled at 1 kHz for 10 s (chips: 3 s), while a stranger speaks.
///
/// # Panics
/// The firmware does not build.
pub fn meet(boards: Boards, stranger: Stranger, speech: Speech) -> Met {
    let truth = SharedTruth::new(usize::from(DEVICES));
    let mut rig = rig(boards, &[], &truth);
    rig.run_until(START_NS);
    let line = LineWithStranger::new(VirtualBus::new(rig), stranger, speech.frames);
    let line = TappedLine::new(line, truth.clone());
    let options = BusOptions::default()
        .formats(speech.frames)
        .sessions(speech.sessions)
        .echo(EchoMode::Known(Echo::Absent));
    let bus = Bus::new(line, options).unwrap();
    let pace = Pace::every(Duration::from_nanos(PERIOD_NS));
    let polled = PollerOptions::for_devices(DEVICES.into()).pace(pace);
    let mut polling = Polling::new(bus, polled, Box::new(NewEveryCycle(0)), Vec::new());
    while polling.bus_mut().line().now_ns() < START_NS + boards.seconds_with_stranger() * 1_000_000_000 {
        let due = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due);
        polling.cycle().unwrap();
    }
    let struck = polling.bus_mut().line().bus().struck;
    let statistics = polling.finish();
    let wrong_commands = truth.lock().wrong_commands();
    Met { struck, tried: statistics.exchanges, lost: statistics.lost, wrong_commands }
}

fn rig(boards: Boards, faults: &[&str], truth: &SharedTruth) -> bus::Bus {
    match boards {
        Boards::Native => faulty_rig(DEVICES, faults, truth),
        Boards::Chips => on_a_line(DEVICES, faults, truth, |n, line| {
            Box::new(ChipBoard::from_elf(firmware::elf(), n, line, I2cConfig::default()).unwrap())
        }),
    }
}

/// Native boards behind these faults, over pressures that never stand still; what they say and obey
/// is noted in `truth`.
///
/// # Panics
/// A fault is none.
pub fn faulty_rig(boards: u8, faults: &[&str], truth: &SharedTruth) -> bus::Bus {
    on_a_line(boards, faults, truth, |n, line| {
        let config = NativeBoardConfig { phase_ns: u64::from(n) * 300_000, ..Default::default() };
        Box::new(NativeBoard::new(config, Address::of_board(n), n, line).unwrap())
    })
}

fn on_a_line(
    boards: u8,
    faults: &[&str],
    truth: &SharedTruth,
    board: impl Fn(u8, bus::Line) -> Box<dyn BusNode + Send>,
) -> bus::Bus {
    let line = bus::Line::at_baud(Baud::ORIGINAL).unwrap();
    let spied = |n: u8| -> Box<dyn BusNode + Send> {
        Box::new(SpiedBoard::new(board(n, line), n.into(), truth.clone()))
    };
    let nodes = (0..boards).map(spied).collect();
    let faults: Vec<_> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    let faults = FaultInjector::new(&faults, line, boards.into(), SEED).unwrap();
    bus::Bus::new(line, nodes, Box::new(Waves), faults, false)
}

/// The host knows its adapter, unless the fault is that it echoes: on a line this noisy it could
/// not always find out.
fn echo(fault: &str) -> EchoMode {
    if fault == "echo" { BusOptions::default().echo } else { EchoMode::Known(Echo::Absent) }
}
