//! The subcommands.

use super::RunArgs;
use super::values::{kpa, number, seconds};
use clap::{Args, Subcommand, ValueEnum};
use pneudrive_manual::Manual;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Serial ports, their adapters, and with --scan the boards on them
    List(ListArgs),
    /// Ask for boards and write a rig file (commands 0 kPa)
    Init(InitArgs),
    /// Two-point calibration of each channel, into the rig file
    Calibrate(CalibrateArgs),
    /// Self-test of valves, chambers and sensors, compared with the last one
    Check(CheckArgs),
    /// Ask each board whether it is there (commands 0 kPa)
    Ping(PingArgs),
    /// What a board says of itself, its parameters, and updates of its firmware
    Board(BoardArgs),
    /// Measure the loop rate for 1 to --devices boards (commands 0 kPa)
    Bench(BenchArgs),
    /// Wire times at a line rate, and the resistor of the boards' 555 timer
    Timing(TimingArgs),
    /// Write a trajectory: steps, sine, sweep or APRBS, within the limits
    Generate(GenerateArgs),
    /// What a recording says of itself, and what happened meanwhile
    Info(InfoArgs),
    /// Play a recording's commands again; with --view show the recording, without boards
    Replay(Box<ReplayArgs>),
    #[command(flatten)]
    Manual(Manual),
}

impl Command {
    /// Whether it commands pressures to the boards that are asked for, or to board 0 alone.
    pub fn polls(&self) -> bool {
        matches!(self, Self::Calibrate(_) | Self::Check(_))
    }

    pub fn name(&self) -> &'static str {
        match self {
            Self::List(_) => "list",
            Self::Init(_) => "init",
            Self::Calibrate(_) => "calibrate",
            Self::Check(_) => "check",
            Self::Ping(_) => "ping",
            Self::Board(_) => "board",
            Self::Bench(_) => "bench",
            Self::Timing(_) => "timing",
            Self::Generate(_) => "generate",
            Self::Info(_) => "info",
            Self::Replay(_) => "replay",
            Self::Manual(manual) => manual.name(),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct ListArgs {
    /// Ask for boards on every port, by commanding 0 kPa
    ///
    /// Not where other devices listen. With --port that port is asked.
    #[arg(long)]
    pub scan: bool,
}

#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct InitArgs {
    /// The file to be written; one that exists is not replaced
    #[arg(value_name = "FILE.toml", default_value = "rig.toml")]
    pub file: PathBuf,
}

#[derive(Debug, Clone, PartialEq, Args)]
pub struct CalibrateArgs {
    /// Only this board
    #[arg(long, value_name = "N")]
    pub board: Option<u8>,
    /// Only this channel, 0 to 3
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(0..=3))]
    pub channel: Option<u8>,
    /// The lower set point, kPa
    ///
    /// Not 0: vented chambers keep some pressure.
    #[arg(long, value_name = "KPA", default_value_t = 50.0, value_parser = kpa)]
    pub low: f64,
    /// The higher set point, kPa
    #[arg(long, value_name = "KPA", default_value_t = 200.0, value_parser = kpa)]
    pub high: f64,
    /// How long a pressure is waited for, s
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = seconds)]
    pub settle: f64,
}

#[derive(Debug, Clone, PartialEq, Args)]
pub struct CheckArgs {
    /// Only this board
    #[arg(long, value_name = "N")]
    pub board: Option<u8>,
    /// Highest set point, kPa; a channel goes up to four fifths of its limit if that is lower
    #[arg(long, value_name = "KPA", default_value_t = 150.0, value_parser = kpa)]
    pub level: f64,
    /// How many times as long as usual (25 s a board), 0.5 to 10: for chambers that need more than
    /// a second to fill
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = number)]
    pub stretch: f64,
    /// Cycles per second [default: the rig file's, or 500]
    #[arg(long, value_name = "HZ", value_parser = number)]
    pub rate: Option<f64>,
    /// Write a page of what was found
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// The check to compare with; made by the first check [default: rig.check.json beside the rig
    /// file rig.toml]
    #[arg(long, value_name = "FILE.json")]
    pub baseline: Option<PathBuf>,
    /// Make this check the one that later ones are compared with
    #[arg(long)]
    pub new_baseline: bool,
}

#[derive(Debug, Clone, PartialEq, Args)]
pub struct GenerateArgs {
    /// What it does
    #[arg(value_enum)]
    pub shape: ShapeArg,
    /// The file; standard output without it, or as `-`
    #[arg(value_name = "FILE.csv")]
    pub file: Option<PathBuf>,
    /// Its length, s
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub seconds: f64,
    /// The lowest set point, kPa
    #[arg(long, value_name = "KPA", default_value_t = 0.0, value_parser = kpa)]
    pub low: f64,
    /// The highest set point, kPa; a channel whose limit (--rig) is lower ends at its limit
    #[arg(long, value_name = "KPA", default_value_t = 200.0, value_parser = kpa)]
    pub high: f64,
    /// Steps and APRBS: how long a level is held, s (APRBS: on the mean). Sines: the period, s
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = seconds)]
    pub hold: f64,
    /// Sweep: the period at its end, s
    #[arg(long, value_name = "S", default_value_t = 0.2, value_parser = seconds)]
    pub last_period: f64,
    /// APRBS: which of the random ones
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Shapes of trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShapeArg {
    /// Up and down again in five steps
    Steps,
    /// A sine
    Sine,
    /// A sine that becomes faster
    Sweep,
    /// Random levels held for random times, each channel for itself
    Aprbs,
}

#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct BoardArgs {
    #[command(subcommand)]
    pub command: BoardCommand,
}

#[derive(Debug, Clone, PartialEq, Eq, Subcommand)]
pub enum BoardCommand {
    /// State, channels, drives, firmware, counters, and why it was last reset
    Status(BoardStatusArgs),
    /// Its parameters, with range and compiled value
    Show(BoardStatusArgs),
    /// Change parameters: all or none, kept in flash; commands 0 kPa and restarts the board
    Set(BoardSetArgs),
    /// Back to the parameters it was compiled with; commands 0 kPa and restarts the board
    Reset(BoardStatusArgs),
    /// A new program over the bus, kept if it answers; commands 0 kPa and restarts the board
    ///
    /// FILE is what `cargo fw-build` (ELF) or `cargo fw-uf2` (UF2) makes, or the program alone. The
    /// board must be vented. It checks the program before it starts it, tries it once, and goes
    /// back to the old one if that does not answer.
    Update(BoardUpdateArgs),
}

#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct BoardUpdateArgs {
    /// ELF, UF2, or the program alone
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    #[command(flatten)]
    pub board: BoardStatusArgs,
}

#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct BoardSetArgs {
    /// Parameters, as `board show` names them; `address=switch` for that of its switch;
    /// `loop_rate=2000` for all that a loop of 2 kHz needs (or 1000)
    #[arg(value_name = "NAME=VALUE", required = true)]
    pub changes: Vec<String>,
    #[command(flatten)]
    pub board: BoardStatusArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Args)]
pub struct BoardStatusArgs {
    /// The board's number
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub board: u8,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Args)]
pub struct PingArgs {
    /// Exchanges with each board
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub count: u32,
}

#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct InfoArgs {
    /// FILE.csv, FILE.csv.gz, FILE.csv.zst or FILE.mcap
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
}

/// A run whose trajectory is the recording. Options that would command something else are gone.
#[derive(Debug, Clone, PartialEq, Args)]
#[command(
    mut_arg("trajectory", |arg| {
        // Without its name it is what stands behind the subcommand.
        arg.long(None)
            .required(true)
            .value_name("RECORDING")
            .help_heading(None::<&str>)
            .help("FILE.csv, FILE.csv.gz, FILE.csv.zst or FILE.mcap")
            .long_help("FILE.csv, FILE.csv.gz, FILE.csv.zst or FILE.mcap. Its first row is commanded at once, whatever its time.")
    }),
    mut_arg("command", |arg| arg.hide(true)),
    mut_arg("from_first_row", |arg| arg.hide(true)),
)]
pub struct ReplayArgs {
    /// Show the recording on terminal (and page, with --web) as it was; no port is opened
    ///
    /// Space pauses, Left and Right go 5 s back and forward. --speed, --repeat and --plain act.
    #[arg(long)]
    pub view: bool,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Args)]
pub struct TimingArgs {
    /// Capacitor of the 555, nF
    #[arg(long, value_name = "NF", default_value_t = 100.0, value_parser = number)]
    pub capacitor_nf: f64,
    /// Its tolerance, percent
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0, value_parser = number)]
    pub capacitor_tolerance: f64,
    /// Tolerance of the resistor, percent
    #[arg(long, value_name = "PERCENT", default_value_t = 1.0, value_parser = number)]
    pub resistor_tolerance: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Args)]
pub struct BenchArgs {
    /// Cycles measured for each number of boards; the paper took 2044
    #[arg(long, value_name = "N", default_value_t = 2044, value_parser = clap::value_parser!(u32).range(2..=100_000_000))]
    pub cycles: u32,
    /// Take the pty's round trip off each request (with --port sim): an estimate of a UART, which
    /// has no such detour
    #[arg(long, hide = !cfg!(feature = "sim"))]
    pub dated: bool,
    /// Measure what a watched live page costs: runs of all boards without and with it, in turn. For
    /// developers of the page: docs/web.md
    #[cfg(feature = "web")]
    #[arg(long, hide = true)]
    pub web: bool,
    /// Such pairs of runs
    #[cfg(feature = "web")]
    #[arg(long, hide = true, value_name = "N", requires = "web", default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1_000))]
    pub pairs: u32,
}
