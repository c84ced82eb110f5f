//! Polling: what is commanded, recorded and shown.

use super::values::{filter, number, seconds, share, speed};
use crate::command_arg::CommandArg;
use crate::limits::LimitArgs;
use clap::{Args, ValueEnum};
use pneudrive_host::poller::{MissedTick, PageShare, PressureFilter};
use pneudrive_record::PageColumns;
use pneudrive_record::trajectory::Interpolation;
use std::path::PathBuf;

/// What to do with the boards.
#[derive(Debug, Clone, PartialEq, Args, Default)]
#[command(next_help_heading = "Run")]
pub struct RunArgs {
    /// Cycles per second [default: the rig file's, or as fast as possible]
    #[arg(long, value_name = "HZ", value_parser = number)]
    pub rate: Option<f64>,
    /// Commanded pressure, kPa gauge: P, P0,P1,P2,P3 or BOARD:P0,P1,P2,P3
    ///
    /// P for all channels, P0,P1,P2,P3 for the channels of all boards, or BOARD:P0,P1,P2,P3; may be
    /// repeated.
    #[arg(long, short = 'c', value_name = "KPA", allow_hyphen_values = true)]
    pub command: Vec<CommandArg>,
    /// Commands from a table or recording
    ///
    /// FILE.csv, FILE.csv.gz, FILE.csv.zst or FILE.mcap, or - for a table on standard input: a
    /// column t_s, and columns such as b0_cmd3_kpa for board 0, channel 3. Before its first row,
    /// and for channels without a column, --command holds, or 0 kPa.
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Begin with the trajectory's first row at once, whatever its t_s
    #[arg(long, requires = "trajectory", hide_short_help = true)]
    pub from_first_row: bool,
    /// What to command between two rows of the trajectory [default: hold]
    #[arg(long, value_enum, requires = "trajectory", hide_short_help = true)]
    pub interpolate: Option<InterpolateArg>,
    /// Begin the trajectory anew when it is over, until --duration or a key ends the run
    #[arg(long, requires = "trajectory", hide_short_help = true)]
    pub repeat: bool,
    /// Play the trajectory so many times as fast, 0.01 to 100
    #[arg(long, requires = "trajectory", hide_short_help = true, value_name = "FACTOR", value_parser = speed)]
    pub speed: Option<f64>,
    /// Draw what the trajectory will command, and end: no board is asked
    ///
    /// Everything is checked, limits too, as for a run; exit status 2 if something is refused.
    #[arg(long, requires = "trajectory", hide_short_help = true)]
    pub preview: bool,
    /// Stop after so many seconds
    ///
    /// A shorter trajectory holds its last row until then.
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub duration: Option<f64>,
    /// Record to FILE.csv, FILE.csv.gz, FILE.csv.zst or FILE.mcap
    ///
    /// What the boards sent, unfiltered; a .mcap is a ROS 2 bag. A full disk ends the run.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Ask boards for their valves' drives after this share of the polls, above 0 to 1; recordings
    /// get columns b0_u0
    ///
    /// Each such request takes the bus as long as a poll: with 1, half the loop rate is left.
    /// Drives are -1 (vent fully) to 1 (fill fully), cells are empty where a board was not asked.
    /// Boards with the published PneuDrive firmware, or with one older than pages, do not tell
    /// them.
    #[arg(long, value_name = "SHARE", hide_short_help = true, value_parser = share)]
    pub drives: Option<PageShare>,
    /// Ask boards for a page of the sensors on their I2C connector after this share of the polls,
    /// above 0 to 1; recordings get columns b0_supply_kpa, b0_ax_m_s2 to b0_gz_rad_s, b0_chip_c and
    /// b0_rail_v
    ///
    /// Supply pressure and IMU, if a board has them, are asked for in turn: the supply takes a
    /// page, an IMU two. Each page takes the bus as long as a poll. With --drives both shares add
    /// up. Cells are empty where a board was not asked.
    #[arg(long, value_name = "SHARE", hide_short_help = true, value_parser = share)]
    pub sensors: Option<PageShare>,
    /// Send rows to HOST:PORT as JSON in UDP, at most 100 a second: PlotJuggler draws them
    #[arg(long, value_name = "HOST:PORT", hide_short_help = true)]
    pub udp: Option<String>,
    /// Run the calibrated model beside the boards: says when something changes, what it probably
    /// is, and since when
    ///
    /// The parameter file that `pneudrive-model fit` wrote, or extended.toml of `diagnose`. The
    /// program pneudrive-model is needed beside this one or in PATH. What it finds is in the view,
    /// on the page, and an event of the recording. With --drives it sees more.
    #[arg(long, value_name = "CALIBRATED.toml", hide_short_help = true)]
    pub watch: Option<PathBuf>,
    /// How long the watch learns what is usual, s [default: 600]
    #[arg(long, value_name = "S", requires = "watch", hide_short_help = true, value_parser = seconds)]
    pub watch_learn: Option<f64>,
    /// The program that watches [default: pneudrive-model beside this one, then in PATH]
    #[arg(long, value_name = "PROGRAM", requires = "watch", hide_short_help = true)]
    pub watch_program: Option<PathBuf>,
    /// Replace the recording if it exists
    #[arg(long, requires = "record", hide_short_help = true)]
    pub overwrite: bool,
    /// Plain lines even on a terminal
    #[arg(long, hide_short_help = true)]
    pub plain: bool,
    /// Fail (status 1) where a board has never answered
    ///
    /// Otherwise missing boards are told, and asked for until they come.
    #[arg(long, hide_short_help = true)]
    pub require_all: bool,
    /// What to do about cycles that could not start in time (with a rate) [default: skip]
    #[arg(long, value_enum, hide_short_help = true)]
    pub missed: Option<MissedArg>,
    /// After a port has come back, return to the set points by a ramp; otherwise boards vent until
    /// they are released (r in the live view, or on the page)
    #[arg(long, hide_short_help = true)]
    pub resume: bool,
    /// Go on without a view when the terminal closes; otherwise the run ends, and boards go to 0
    /// kPa
    #[arg(long, hide_short_help = true)]
    pub keep_running: bool,
    /// Low-pass the displayed pressures: weight of the new sample [default without a number: 0.6,
    /// as in the published PneuDrive]
    #[arg(long, hide_short_help = true, value_name = "WEIGHT", num_args = 0..=1, require_equals = true, default_missing_value = "0.6", value_parser = filter)]
    pub filter: Option<PressureFilter>,
    /// End when the port vanishes, instead of waiting for it to come back
    #[arg(long, hide_short_help = true)]
    pub no_reopen: bool,
    #[command(flatten)]
    pub limits: LimitArgs,
    #[cfg(feature = "web")]
    #[command(flatten)]
    pub web: crate::web::WebArgs,
}

impl RunArgs {
    /// What recordings have beside commands and pressures.
    pub fn pages(&self) -> PageColumns {
        PageColumns { drives: self.drives.is_some(), sensors: self.sensors.is_some() }
    }

    /// Page requests for each poll.
    pub fn pages_per_poll(&self) -> f64 {
        [self.drives, self.sensors].into_iter().flatten().map(PageShare::get).sum()
    }

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
