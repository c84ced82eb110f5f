//! Flags, which are also the ROS parameters.

use clap::Parser;
use pneudrive_host::bus::BusOptions;
use pneudrive_host::poller::{BaudChoice, PageShare};
use std::path::PathBuf;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  pneudrive-ros --port sim --devices 3                       three virtual boards
  pneudrive-ros --port /dev/ttyUSB0 --devices 2 --namespace /arm
  pneudrive-ros --port /dev/ttyUSB0,/dev/ttyUSB1 --devices 4  two buses: joint_0 to joint_7
  pneudrive-ros --port /dev/ttyUSB0 --ros-args -r __ns:=/arm -p rate_hz:=500.0
  pneudrive-ros --ros-args --params-file arm.yaml            as a launch file starts it

Topics: ~/joint_N/pressure_command (subscribed), ~/joint_N/pressure_state, /diagnostics, /rosout. Services: ~/vent, ~/release. Commands hold
for --command-timeout-s: repeat them. Ends on Ctrl-C or SIGTERM; then 0 kPa is commanded to every board.

Exit status: 0 done, 1 failed while running, 2 unusable arguments.";

/// PneuDrive boards as a ROS 2 node. Each flag is also a ROS parameter: --rate-hz 500 is -p
/// rate_hz:=500.0.
#[derive(Debug, Clone, PartialEq, Parser)]
#[command(name = "pneudrive-ros", version, after_help = EXAMPLES, max_term_width = 110, args_override_self = true)]
pub struct Flags {
    /// Serial ports, or `sim` for virtual boards; several, separated by commas, for several buses
    /// [default: that of the rig file]
    #[arg(long, value_name = "PATH|sim", value_delimiter = ',', required_unless_present = "rig")]
    pub port: Vec<PathBuf>,
    /// Boards on each bus, numbered from 0: one number for all buses, or one for each [default:
    /// that of the rig file, or 1]
    #[arg(long, short = 'n', value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=255))]
    pub devices: Vec<u16>,
    /// Most boards accepted on a bus: 4 with the boards' two-way switch, 255 can be polled
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=255))]
    pub max_devices: u16,
    /// Number of the first board's joint; the boards of the second bus follow those of the first
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=60_000))]
    pub first_joint: u16,
    /// Line rate, bit/s; `auto` polls at the fastest that all boards agree to, up to 3000000, and
    /// goes back on errors [default: that of the rig file, or 1000000]
    #[arg(long, value_name = "auto|BAUD")]
    pub baud: Option<BaudChoice>,
    /// How long a board may take to answer beyond the wire time, us [default: 2000; 20000 for
    /// virtual boards, which share the machine's cores]
    #[arg(long, value_name = "US", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub allowance_us: Option<u64>,
    /// Cycles of each bus per second [default: 1000, or as fast as possible where the wire takes
    /// longer]
    #[arg(long, value_name = "HZ")]
    pub rate_hz: Option<f64>,
    /// Publish states at most so often, per board [changeable while running]
    #[arg(long, value_name = "HZ", default_value_t = 1_000.0)]
    pub publish_rate_hz: f64,
    /// Refuse commands whose stamp lies further from now, s; 0 accepts any. A stamp of 0 is always
    /// accepted [changeable while running]
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    pub max_command_age_s: f64,
    /// Command 0 kPa to channels that have got no valid command for so long, s; `never` (or 0)
    /// holds the last one for ever [changeable while running]
    #[arg(long, value_name = "S|never", default_value_t = 0.5, value_parser = timeout)]
    pub command_timeout_s: f64,
    /// Highest set point of every channel, kPa: commands above it are refused
    #[arg(long, value_name = "KPA", allow_negative_numbers = true)]
    pub max_kpa: Option<f64>,
    /// Fastest change of every set point, kPa/s: what is faster is ramped; venting is not slowed
    /// down
    #[arg(long, value_name = "KPA/S", allow_negative_numbers = true)]
    pub max_rate_kpa_s: Option<f64>,
    /// Rig file: port, boards, rate, calibration and limits (docs/rig.md). Boards are numbered as
    /// on each bus; of several limits the strictest holds
    #[arg(long, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
    /// After a port has come back, follow commands again at once, by a ramp; otherwise boards stay
    /// vented until ~/release is called
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true")]
    pub resume: bool,
    /// Vent all joints when the node itself has been stuck for so long, s: the thread of each bus
    /// does it. 0 holds their commands
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    pub watchdog_s: f64,
    /// Type of the pressure messages: joint_state (sensor_msgs/JointState, kPa in `effort`),
    /// fluid_pressure (sensor_msgs/FluidPressure, Pa gauge, topics ~/joint_N/chamber_K/..), or
    /// PACKAGE/TYPE for a message {std_msgs/Header header, float64[] pressure} of that name
    #[arg(long, value_name = "TYPE", default_value = "joint_state")]
    pub message_type: String,
    /// Publish /diagnostics every so often, s
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    pub diagnostics_period_s: f64,
    /// Ask boards for a page of the sensors on their I2C connector after this share of the polls,
    /// above 0 to 1, and publish ~/joint_N/supply_pressure and ~/joint_N/imu; each page takes the
    /// bus as long as a poll
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub sensors: Option<PageShare>,
    /// Record every row of every bus to FILE.mcap, a ROS 2 bag
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Run calibrated models beside the boards (pneudrive-model watch) and say in /diagnostics what
    /// has changed: one file of `pneudrive-model fit` for each bus
    #[arg(long, value_name = "CALIBRATED.toml", value_delimiter = ',')]
    pub watch: Vec<PathBuf>,
    /// The program that watches [default: pneudrive-model beside this one, then in PATH]
    #[arg(long, value_name = "PROGRAM")]
    pub watch_program: Option<PathBuf>,
    /// Replace the recording if it exists
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true")]
    pub overwrite: bool,
    /// Namespace of the node; __ns:= wins
    #[arg(long, value_name = "NS", default_value = "/")]
    pub namespace: String,
    /// Name of the node; __node:= wins
    #[arg(long, value_name = "NAME", default_value = "pneudrive")]
    pub name: String,
    /// DDS domain [default: ROS_DOMAIN_ID, or 0]
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u16).range(0..=232))]
    pub domain_id: Option<u16>,
}

impl Flags {
    /// How long a board may take to answer beyond the wire time: what was asked for, or what its
    /// kind needs.
    pub fn allowance(&self) -> Duration {
        let virtual_boards = self.port.iter().any(|port| pneudrive_virtual::is_sim(port));
        match self.allowance_us {
            Some(allowance_us) => Duration::from_micros(allowance_us),
            None if virtual_boards => BusOptions::VIRTUAL_ALLOWANCE,
            None => BusOptions::ANSWER_ALLOWANCE,
        }
    }
}

fn share(text: &str) -> Result<PageShare, String> {
    let share = text.parse().map_err(|_| "expected a number".to_owned())?;
    PageShare::new(share).map_err(|error| error.to_string())
}

/// A time in s, or `never`, which is 0.
fn timeout(text: &str) -> Result<f64, String> {
    if text == "never" {
        return Ok(0.0);
    }
    text.parse().map_err(|_| "expected a number of seconds, or never".to_owned())
}
