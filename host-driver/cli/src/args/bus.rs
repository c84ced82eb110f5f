//! What is on the bus: options of nearly every subcommand.

use super::values::{baud, devices, seconds, spin, unit};
use clap::{Args, ValueEnum};
use pneudrive_host::bus::{BusOptions, FormatPolicy};
use pneudrive_host::line::Spin;
use pneudrive_host::poller::{BaudChoice, LineRatePolicy};
use pneudrive_host::real_time::RealTime;
use pneudrive_host::rig::Unit;
use std::path::PathBuf;

/// Heading of what is rarely needed.
const TIMING: &str = "Bus and scheduler";
const SIM: &str = "Virtual boards (--port sim)";
/// Help does not name what the program was built without.
const NO_SIM: bool = !cfg!(feature = "sim");

/// What is on the bus.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Boards")]
pub struct BusArgs {
    /// Serial port, or `sim` for virtual boards
    #[arg(long, global = true, value_name = "PATH|sim")]
    pub port: Option<PathBuf>,
    /// Boards on the bus, numbered from 0 [default: 1; bench: 4]
    #[arg(long, short = 'n', global = true, value_name = "N", value_parser = devices)]
    pub devices: Option<u16>,
    /// Rig file: port, rate, names, calibration, limits, unit
    ///
    /// docs/rig.md describes it; options of the command line come before it.
    #[arg(long, global = true, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
    /// Unit of pressures for people [default: the rig file's, or kPa]
    ///
    /// kPa, bar or psi. Options, files and JSON stay in kPa.
    #[arg(long, global = true, value_name = "UNIT", value_parser = unit)]
    pub unit: Option<Unit>,
    /// Print one JSON object at the end, and nothing else on standard output
    ///
    /// docs/recordings.md has its schema.
    #[arg(long, global = true)]
    pub json: bool,
    /// Most boards accepted for --devices, and from the rig file: 4 with the boards' two-way
    /// switch, 256 addresses exist
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub max_devices: u16,
    /// Line rate, bit/s; `auto` polls at the fastest that all boards agree to, up to 3000000, and
    /// goes back on errors [default: 1000000]
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "auto|BAUD", value_parser = baud)]
    pub baud: Option<BaudChoice>,
    /// How long a board may take to answer beyond the wire time, us [default: 2000; 20000 for
    /// virtual boards, which share the machine's cores]
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "US", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub allowance_us: Option<u64>,
    /// How long after its timeout an answer may still come, us: a board that did not answer in
    /// unchecked packets is left alone for so long, until 100 answers have told how late it really
    /// is
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "US", default_value_t = BusOptions::LATE_ANSWER_LIMIT.as_micros() as u64, value_parser = clap::value_parser!(u64).range(0..=10_000_000))]
    pub late_us: u64,
    /// How long to wait for boards at the start, s
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "S", default_value_t = 2.0, value_parser = seconds)]
    pub wait: f64,
    /// Whether the adapter returns what it sends
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_enum, default_value_t = EchoArg::Detect)]
    pub echo: EchoArg,
    /// Packet format: checked packets carry a CRC and a sequence number; boards with the published
    /// PneuDrive firmware do not understand them
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_enum, default_value_t = FramesArg::Negotiate)]
    pub frames: FramesArg,
    /// Ask boards for sessions, in which each request is obeyed once and no other host is obeyed.
    /// Without them --baud auto stays at 1 Mbaud, and parameters cannot be changed
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_enum, default_value_t = SessionsArg::On)]
    pub sessions: SessionsArg,
    /// Look for answers without sleeping: `auto` tries at the start which way of waiting brings
    /// answers soonest (sleeping, looking from shortly before they are due, looking all the time),
    /// a number of us looks so long before each sleep; saves wake-ups, costs CPU
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "auto|US", default_value = "0", value_parser = spin)]
    pub spin_us: Spin,
    /// Run the bus thread under SCHED_FIFO with this priority, 1 to 99 [without a number: 40]; an
    /// error where it is not permitted
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "PRIORITY", num_args = 0..=1, require_equals = true, default_missing_value = "40", value_parser = clap::value_parser!(u8).range(1..=99))]
    pub realtime: Option<u8>,
    /// Keep the whole process in memory; an error where it is not permitted
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING)]
    pub lock_memory: bool,
    /// Keep the bus thread on this core, counted from 0
    #[arg(long, global = true, hide_short_help = true, help_heading = TIMING, value_name = "N")]
    pub pin_core: Option<usize>,
    /// When the virtual boards' bytes appear
    #[arg(long, global = true, hide_short_help = true, hide = NO_SIM, help_heading = SIM, value_enum, default_value_t = SimTiming::Wire)]
    pub timing: SimTiming,
    /// How long the virtual boards think before they answer, us (with --timing wire); the firmware
    /// needs about 15
    #[arg(long, global = true, hide_short_help = true, hide = NO_SIM, help_heading = SIM, value_name = "US", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=100_000))]
    pub turnaround_us: u64,
    /// Virtual boards that behave as the published PneuDrive firmware does, with its faults:
    /// numbers separated by commas
    #[arg(long, global = true, hide_short_help = true, hide = NO_SIM, help_heading = SIM, value_name = "BOARDS", value_delimiter = ',')]
    pub sim_original: Vec<u8>,
}

impl BusArgs {
    /// Line rate with which it begins, bit/s.
    pub fn baud(&self) -> u32 {
        self.baud.unwrap_or_default().first()
    }

    /// The fastest line rate that it may poll at, bit/s.
    pub fn fastest_baud(&self) -> u32 {
        self.baud.unwrap_or_default().fastest()
    }

    /// Whether, and how, to ask the boards for a faster one.
    pub fn line_rate(&self) -> Option<LineRatePolicy> {
        self.baud.unwrap_or_default().policy()
    }

    /// What the bus thread asks of the scheduler.
    pub fn real_time(&self) -> RealTime {
        RealTime::default().priority(self.realtime).lock_memory(self.lock_memory).core(self.pin_core)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EchoArg {
    /// Find out by asking a board that does not exist
    Detect,
    /// It does
    Present,
    /// It does not
    Absent,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FramesArg {
    /// Checked with boards that understand it
    Negotiate,
    /// The published PneuDrive's, with all boards
    Unchecked,
    /// With all boards
    Checked,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SessionsArg {
    /// With boards that know them
    On,
    /// With none, as hosts of before: a repeated request, or that of a second host, is obeyed
    Off,
}

impl From<FramesArg> for FormatPolicy {
    fn from(arg: FramesArg) -> Self {
        match arg {
            FramesArg::Negotiate => Self::Negotiate,
            FramesArg::Unchecked => Self::Unchecked,
            FramesArg::Checked => Self::Checked,
        }
    }
}

impl From<SimTiming> for pneudrive_virtual::Timing {
    fn from(arg: SimTiming) -> Self {
        match arg {
            SimTiming::Wire => Self::Wire,
            SimTiming::Instant => Self::Instant,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SimTiming {
    /// When the line rate would deliver them
    Wire,
    /// At once
    Instant,
}
