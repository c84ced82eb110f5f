use crate::cli::command_arg::CommandArg;
use crate::cli::limits::LimitArgs;
use clap::{Args, Parser, Subcommand, ValueEnum};
use pneudrive_host::bus::FrameMode;
use pneudrive_host::line::Spin;
use pneudrive_host::poller::{MissedTick, PressureFilter};
use pneudrive_host::real_time::RealTime;
use pneudrive_host::trajectory::Interpolation;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  pneudrive-host --port sim --devices 3                    three virtual boards, live on the terminal
  pneudrive-host --port /dev/ttyUSB0 --devices 2 --command 100
                                                           two boards, all chambers at 100 kPa
  pneudrive-host --port /dev/ttyUSB0 --rate 500 --duration 10 --command 0:50,50,120,120 --record run.csv.zst
  pneudrive-host --port sim --trajectory steps.csv --interpolate linear --record run.csv --json
  pneudrive-host --port /dev/ttyUSB0 --devices 4 --web     the same in a browser, with a vent button (feature `web`)
  pneudrive-host ping --port /dev/ttyUSB0 --devices 4      which boards answer, and how fast
  pneudrive-host timing --baud 460800                      wire times and the 555's resistor for a line rate
  pneudrive-host bench --port sim --devices 4              the loop rate for 1 to 4 boards
  pneudrive-host info run.csv.zst                          when, with what and how it was recorded, and what happened
  pneudrive-host --port /dev/ttyUSB0 --rate 1000 --realtime --lock-memory --pin-core 3
                                                           with real-time scheduling

In the live view v, V and the space bar vent all boards until r releases them. A run ends on Ctrl-C, SIGTERM, q or Esc (which asks) in
the live view, when the terminal closes, after --duration or a trajectory. Then 0 kPa is commanded to every board, and the statistics are printed.

Exit status: 0 done, 1 failed while running, 2 unusable arguments or input.";

/// Polls PneuDrive boards: sends commands, shows and records pressures.
#[derive(Debug, Parser)]
#[command(name = "pneudrive-host", version, after_help = EXAMPLES, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub bus: BusArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Ask each board whether it is there (commands 0 kPa)
    Ping(PingArgs),
    /// Wire times at a line rate, and the resistor of the boards' 555 timer
    Timing(TimingArgs),
    /// Measure the loop rate for 1 to --devices boards (commands 0 kPa)
    Bench(BenchArgs),
    /// What a recording says of itself, and what happened meanwhile
    Info(InfoArgs),
}

impl Command {
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ping(_) => "ping",
            Self::Timing(_) => "timing",
            Self::Bench(_) => "bench",
            Self::Info(_) => "info",
        }
    }
}

/// What is on the bus.
#[derive(Debug, Clone, Args)]
pub struct BusArgs {
    /// Serial port, or `sim` for virtual boards
    #[arg(long, global = true, value_name = "PATH|sim")]
    pub port: Option<PathBuf>,
    /// Boards on the bus, numbered from 0 [default: 1; bench: 4]
    #[arg(long, short = 'n', global = true, value_name = "N")]
    pub devices: Option<u16>,
    /// Most boards accepted for --devices: 4 with the boards' two-way switch, 256 addresses exist
    #[arg(long, global = true, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub max_devices: u16,
    /// Line rate, bit/s
    #[arg(long, global = true, value_name = "BAUD", default_value_t = 1_000_000)]
    pub baud: u32,
    /// How long a board may take to answer beyond the wire time, us
    #[arg(long, global = true, value_name = "US", default_value_t = 2_000, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub allowance_us: u64,
    /// How long after its timeout an answer may still come, us: a board that did not answer in unchecked packets is left alone for so
    /// long, until 100 answers have told how late it really is
    #[arg(long, global = true, value_name = "US", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(0..=10_000_000))]
    pub late_us: u64,
    /// How long to wait for boards at the start, s
    #[arg(long, global = true, value_name = "S", default_value_t = 2.0, value_parser = seconds)]
    pub wait: f64,
    /// Whether the adapter returns what it sends
    #[arg(long, global = true, value_enum, default_value_t = EchoArg::Detect)]
    pub echo: EchoArg,
    /// Packet format: checked packets carry a CRC and a sequence number, boards of the original kind do not understand them
    #[arg(long, global = true, value_enum, default_value_t = FramesArg::Negotiate)]
    pub frames: FramesArg,
    /// Look for answers without sleeping: `auto` tries at the start which way of waiting brings answers soonest (sleeping, looking from
    /// shortly before they are due, looking all the time), a number of us looks so long before each sleep; saves wake-ups, costs CPU
    #[arg(long, global = true, value_name = "auto|US", default_value = "0", value_parser = spin)]
    pub spin_us: Spin,
    /// Run the bus thread under SCHED_FIFO with this priority, 1 to 99 [without a number: 40]; an error where it is not permitted
    #[arg(long, global = true, value_name = "PRIORITY", num_args = 0..=1, require_equals = true, default_missing_value = "40", value_parser = clap::value_parser!(u8).range(1..=99))]
    pub realtime: Option<u8>,
    /// Keep the whole process in memory; an error where it is not permitted
    #[arg(long, global = true)]
    pub lock_memory: bool,
    /// Keep the bus thread on this core, counted from 0
    #[arg(long, global = true, value_name = "N")]
    pub pin_core: Option<usize>,
    /// When the virtual boards' bytes appear (with --port sim)
    #[cfg(feature = "sim")]
    #[arg(long, global = true, value_enum, default_value_t = SimTiming::Wire)]
    pub timing: SimTiming,
    /// How long the virtual boards think before they answer, us (with --port sim and --timing wire); the firmware needs about 15
    #[cfg(feature = "sim")]
    #[arg(long, global = true, value_name = "US", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=100_000))]
    pub turnaround_us: u64,
    /// Virtual boards that behave as the original's firmware does, with its faults (with --port sim): numbers separated by commas
    #[cfg(feature = "sim")]
    #[arg(long, global = true, value_name = "BOARDS", value_delimiter = ',')]
    pub sim_original: Vec<u8>,
    /// Print one JSON object on standard output at the end, and nothing else there
    #[arg(long, global = true)]
    pub json: bool,
}

impl BenchArgs {
    /// Whether virtual boards date requests back.
    pub fn dated(&self) -> bool {
        #[cfg(feature = "sim")]
        return self.dated;
        #[cfg(not(feature = "sim"))]
        return false;
    }
}

impl BusArgs {
    /// What the bus thread asks of the scheduler.
    pub fn real_time(&self) -> RealTime {
        RealTime { priority: self.realtime, lock_memory: self.lock_memory, core: self.pin_core }
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
    /// The original's, with all boards
    Unchecked,
    /// With all boards
    Checked,
}

impl From<FramesArg> for FrameMode {
    fn from(arg: FramesArg) -> Self {
        match arg {
            FramesArg::Negotiate => Self::Negotiate,
            FramesArg::Unchecked => Self::Unchecked,
            FramesArg::Checked => Self::Checked,
        }
    }
}

#[cfg(feature = "sim")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SimTiming {
    /// When the line rate would deliver them
    Wire,
    /// At once
    Instant,
}

/// What to do with the boards.
#[derive(Debug, Clone, PartialEq, Args, Default)]
pub struct RunArgs {
    /// Cycles per second [default: as fast as possible]
    #[arg(long, value_name = "HZ", value_parser = number)]
    pub rate: Option<f64>,
    /// What to do about cycles that could not start in time (with --rate) [default: skip]
    #[arg(long, value_enum, requires = "rate")]
    pub missed: Option<MissedArg>,
    /// Commanded pressure, kPa gauge: P for all, P0,P1,P2,P3 for the channels of all boards, or BOARD:P0,P1,P2,P3; may be repeated
    #[arg(long, short = 'c', value_name = "KPA", allow_hyphen_values = true)]
    pub command: Vec<CommandArg>,
    /// Commands from FILE.csv, FILE.csv.gz, FILE.csv.zst or FILE.mcap, such as a recording: a
    /// column t_s, and columns such as b0_cmd3_kpa for board 0, channel 3. Before its first row,
    /// and for channels without a column, --command holds, or 0 kPa
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Begin with the trajectory's first row at once, whatever its t_s
    #[arg(long, requires = "trajectory")]
    pub from_first_row: bool,
    /// What to command between two rows of the trajectory [default: hold]
    #[arg(long, value_enum, requires = "trajectory")]
    pub interpolate: Option<InterpolateArg>,
    /// Record to FILE.csv, FILE.csv.gz, FILE.csv.zst or FILE.mcap, a ROS 2 bag (what the boards sent, unfiltered). A full disk ends the run
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Replace the recording if it exists
    #[arg(long, requires = "record")]
    pub overwrite: bool,
    /// Stop after so many seconds; a shorter trajectory holds its last row until then
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub duration: Option<f64>,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// After a port has come back, return to the set points by a ramp; otherwise boards vent until they are released (r in the live
    /// view, or on the page)
    #[arg(long)]
    pub resume: bool,
    /// Go on without a view when the terminal closes; otherwise the run ends, and boards go to 0 kPa
    #[arg(long)]
    pub keep_running: bool,
    /// Low-pass the displayed pressures: weight of the new sample [default without a number: 0.6, as the original]
    #[arg(long, value_name = "WEIGHT", num_args = 0..=1, require_equals = true, default_missing_value = "0.6", value_parser = filter)]
    pub filter: Option<PressureFilter>,
    /// End when the port vanishes, instead of waiting for it to come back
    #[arg(long)]
    pub no_reopen: bool,
    /// Plain lines even on a terminal
    #[arg(long)]
    pub plain: bool,
    #[cfg(feature = "web")]
    #[command(flatten)]
    pub web: crate::cli::web::WebArgs,
}

impl RunArgs {
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MissedArg {
    /// Leave them out, stay in phase
    Skip,
    /// Make up for them
    CatchUp,
    /// Start at once and go on from there
    Shift,
}

impl From<MissedArg> for MissedTick {
    fn from(arg: MissedArg) -> Self {
        match arg {
            MissedArg::Skip => Self::Skip,
            MissedArg::CatchUp => Self::CatchUp,
            MissedArg::Shift => Self::Shift,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum InterpolateArg {
    /// The earlier row
    Hold,
    /// The straight line
    Linear,
}

impl From<InterpolateArg> for Interpolation {
    fn from(arg: InterpolateArg) -> Self {
        match arg {
            InterpolateArg::Hold => Self::Hold,
            InterpolateArg::Linear => Self::Linear,
        }
    }
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
    /// Take the pty's round trip off each request (with --port sim): an estimate of a UART, which has no such detour
    #[cfg(feature = "sim")]
    #[arg(long)]
    pub dated: bool,
    /// Measure what a watched live page costs: runs of all boards without and with it, in turn
    #[cfg(feature = "web")]
    #[arg(long)]
    pub web: bool,
    /// Such pairs of runs
    #[cfg(feature = "web")]
    #[arg(long, value_name = "N", requires = "web", default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1_000))]
    pub pairs: u32,
}

/// A number, of which its user says what it must be.
pub fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "expected a number".to_owned())
}

fn spin(text: &str) -> Result<Spin, String> {
    match text.parse() {
        _ if text == "auto" => Ok(Spin::Auto),
        Ok(0) => Ok(Spin::Never),
        Ok(us @ 1..=1_000) => Ok(Spin::BeforeSleep { ns: 1_000 * us }),
        _ => Err("expected `auto`, or a whole number of us from 0 (never) to 1000".to_owned()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    if seconds > 0.0 && seconds <= 1e9 {
        Ok(seconds)
    } else {
        Err("must be above 0 and at most 1e9 s".to_owned())
    }
}

fn filter(text: &str) -> Result<PressureFilter, String> {
    let weight: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    PressureFilter::new(weight).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn bus_options_may_stand_before_or_behind_the_subcommand() {
        for line in ["x --port sim ping", "x ping --port sim"] {
            let cli = Cli::try_parse_from(line.split(' ')).unwrap();
            assert_eq!(cli.bus.port, Some("sim".into()));
            assert!(matches!(cli.command, Some(Command::Ping(_))) && cli.run.is_default());
        }
    }
}
