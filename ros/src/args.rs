//! Flags, which are also the ROS parameters, and what they mean.

use crate::names::{NameError, Names};
use crate::params_file::{self, ParamsFileError};
use crate::ros_args::{self, RosArgsError};
use clap::parser::ValueSource;
use clap::{CommandFactory, Parser};
use pneudrive_host::Calibration;
use pneudrive_host::poller::{BaudChoice, ChannelLimit, Limits, PageShare};
use pneudrive_host::rig::{self, CalibrationError, Rig, RigError};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  pneudrive-ros --port sim --devices 3                       three virtual boards
  pneudrive-ros --port /dev/ttyUSB0 --devices 2 --namespace /arm
  pneudrive-ros --port /dev/ttyUSB0,/dev/ttyUSB1 --devices 4 two buses of four boards: joint_0 to joint_7
  pneudrive-ros --port /dev/ttyUSB0 --ros-args -r __ns:=/arm -p rate_hz:=500.0
  pneudrive-ros --ros-args --params-file arm.yaml            as a launch file starts it

Topics: ~/joint_N/pressure_command (subscribed), ~/joint_N/pressure_state, /diagnostics, /rosout. Services: ~/vent, ~/release. Commands hold
for --command-timeout-s: repeat them. Ends on Ctrl-C or SIGTERM; then 0 kPa is commanded to every board.

Exit status: 0 done, 1 failed while running, 2 unusable arguments.";

/// PneuDrive boards as a ROS 2 node. Each flag is also a ROS parameter: --rate-hz 500 is -p rate_hz:=500.0.
#[derive(Debug, Clone, PartialEq, Parser)]
#[command(name = "pneudrive-ros", version, after_help = EXAMPLES, max_term_width = 110, args_override_self = true)]
pub struct Flags {
    /// Serial ports, or `sim` for virtual boards; several, separated by commas, for several buses [default: that of the rig file]
    #[arg(long, value_name = "PATH|sim", value_delimiter = ',', required_unless_present = "rig")]
    pub port: Vec<PathBuf>,
    /// Boards on each bus, numbered from 0: one number for all buses, or one for each [default: that of the rig file, or 1]
    #[arg(long, short = 'n', value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=255))]
    pub devices: Vec<u16>,
    /// Number of the first board's joint; the boards of the second bus follow those of the first
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=60_000))]
    pub first_joint: u16,
    /// Line rate, bit/s; `auto` polls at the fastest that all boards agree to, up to 3000000, and goes back on errors
    /// [default: that of the rig file, or 1000000]
    #[arg(long, value_name = "auto|BAUD")]
    pub baud: Option<BaudChoice>,
    /// How long a board may take to answer beyond the wire time, us
    #[arg(long, value_name = "US", default_value_t = 2_000, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub allowance_us: u64,
    /// Cycles of each bus per second [default: 1000, or as fast as possible where the wire takes longer]
    #[arg(long, value_name = "HZ")]
    pub rate_hz: Option<f64>,
    /// Publish states at most so often, per board [changeable while running]
    #[arg(long, value_name = "HZ", default_value_t = 1_000.0)]
    pub publish_rate_hz: f64,
    /// Refuse commands whose stamp lies further from now, s; 0 accepts any. A stamp of 0 is always accepted [changeable while running]
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    pub max_command_age_s: f64,
    /// Command 0 kPa to channels that have got no valid command for so long, s; `never` (or 0) holds the last one for ever
    /// [changeable while running]
    #[arg(long, value_name = "S|never", default_value_t = 0.5, value_parser = timeout)]
    pub command_timeout_s: f64,
    /// Highest set point of every channel, kPa: commands above it are refused
    #[arg(long, value_name = "KPA", allow_negative_numbers = true)]
    pub max_kpa: Option<f64>,
    /// Fastest change of every set point, kPa/s: what is faster is ramped; venting is not slowed down
    #[arg(long, value_name = "KPA/S", allow_negative_numbers = true)]
    pub max_rate_kpa_s: Option<f64>,
    /// Rig file: port, boards, rate, calibration and limits (docs/rig.md). Boards are numbered as on each bus; of several limits the
    /// strictest holds
    #[arg(long, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
    /// After a port has come back, follow commands again at once, by a ramp; otherwise boards stay vented until ~/release is called
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true")]
    pub resume: bool,
    /// Vent all joints when the node itself has been stuck for so long, s: the thread of each bus does it. 0 holds their commands
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    pub watchdog_s: f64,
    /// Type of the pressure messages: joint_state (sensor_msgs/JointState, kPa in `effort`), fluid_pressure (sensor_msgs/FluidPressure, Pa
    /// gauge, topics ~/joint_N/chamber_K/..), or PACKAGE/TYPE for a message {std_msgs/Header header, float64[] pressure} of that name
    #[arg(long, value_name = "TYPE", default_value = "joint_state")]
    pub message_type: String,
    /// Publish /diagnostics every so often, s
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    pub diagnostics_period_s: f64,
    /// Ask boards for a page of the sensors on their I2C connector after this share of the polls, above 0 to 1, and publish
    /// ~/joint_N/supply_pressure and ~/joint_N/imu; each page takes the bus as long as a poll
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub sensors: Option<PageShare>,
    /// Record every row of every bus to FILE.mcap, a ROS 2 bag
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Run calibrated models beside the boards (pneudrive-model watch) and say in /diagnostics what has changed: one file of `pneudrive-model
    /// fit` for each bus
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

/// The flags, checked, with what follows from them.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// As given.
    pub flags: Flags,
    /// The node's and its topics'.
    pub names: Names,
    /// DDS domain.
    pub domain_id: u16,
    /// Which messages to speak.
    pub message: MessageType,
    /// Highest set points and fastest changes.
    pub limits: Limits,
    /// What counts mean.
    pub calibration: Calibration,
    /// The rig file.
    pub rig: Option<Rig>,
}

/// Type of the pressure messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MessageType {
    /// `sensor_msgs/msg/JointState`
    JointState,
    /// `sensor_msgs/msg/FluidPressure`, one for each chamber.
    FluidPressure,
    /// `{Header, float64[]}` under a name of the user's.
    Pressures {
        /// Its package.
        package: String,
        /// Its name in that.
        name: String,
    },
}

/// Arguments that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ArgsError {
    /// In the ROS part.
    #[error(transparent)]
    Ros(#[from] RosArgsError),
    /// In a file of parameters.
    #[error(transparent)]
    File(#[from] ParamsFileError),
    /// A name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The rig file.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Its calibration.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A value.
    #[error("{name} {value}: {advice}")]
    Value {
        /// Of which flag.
        name: &'static str,
        /// What came.
        value: String,
        /// What is expected.
        advice: String,
    },
}

impl Settings {
    /// Reads the command line. Ends the process for --help, --version and flags that clap refuses.
    pub fn from_command_line(line: impl Iterator<Item = OsString>) -> Result<Self, ArgsError> {
        let (mut own, ros) = ros_args::split(line)?;
        // The node's name says which parameters of a file are its own. What is wrong with the flags is told below.
        let given = Flags::command().ignore_errors(true).try_get_matches_from(&own).unwrap_or_default();
        let word = |id: &str, default: &str| {
            given.try_get_one::<String>(id).ok().flatten().cloned().unwrap_or_else(|| default.to_owned())
        };
        let names = Names::new(&word("namespace", "/"), &word("name", "pneudrive"), &ros.remaps)?;
        let mut parameters = BTreeMap::new();
        for file in &ros.files {
            parameters.extend(params_file::read(file, &names.full())?);
        }
        // Flags are nearer than a file.
        let is_flag = |name: &str| {
            given.ids().any(|id| id.as_str() == name)
                && given.value_source(name) == Some(ValueSource::CommandLine)
        };
        parameters.retain(|name, _| !is_flag(name));
        parameters.extend(ros.parameters.into_iter().map(|(name, value)| (name, params_file::value(&value))));
        parameters.retain(|name, value| !means_nothing(name, value));
        for (name, value) in &parameters {
            own.push(format!("--{}={value}", name.replace('_', "-")).into());
        }
        let [ports, devices] = ["port", "devices"]
            .map(|name| parameters.get(name).map_or(0, |value: &String| value.split(',').count()));
        let mut flags = Flags::parse_from(own);
        // Flags that are given several times add up, but a parameter takes the place of a flag.
        keep_last(&mut flags.port, ports);
        keep_last(&mut flags.devices, devices);
        Self::check(flags, names)
    }

    /// What the rig file says where the flags say nothing.
    fn fill(flags: &mut Flags, rig: &Rig) {
        let bus = rig.bus();
        if flags.port.is_empty() {
            flags.port.extend(bus.port.map(PathBuf::from));
        }
        if flags.devices.is_empty() {
            flags.devices.extend(bus.boards.filter(|boards| *boards <= 255));
        }
        flags.baud = flags.baud.or(rig::baud(rig));
        flags.rate_hz = flags.rate_hz.or(bus.rate_hz);
    }

    fn check(mut flags: Flags, names: Names) -> Result<Self, ArgsError> {
        let rig = flags.rig.as_deref().map(Rig::load).transpose()?;
        if let Some(rig) = &rig {
            Self::fill(&mut flags, rig);
        }
        if flags.devices.is_empty() {
            flags.devices.push(1);
        }
        let value =
            |name, value: String, advice: &str| Err(ArgsError::Value { name, value, advice: advice.into() });
        if flags.port.is_empty() {
            return value("--port", String::new(), "give one here, or as port under [bus] of the rig file");
        }
        if flags.overwrite && flags.record.is_none() {
            return value("--overwrite", "true".into(), "give --record FILE.mcap, the recording to replace");
        }
        if flags.devices.len() != 1 && flags.devices.len() != flags.port.len() {
            let counts = flags.devices.iter().map(u16::to_string).collect::<Vec<_>>().join(",");
            let advice = format!("one number, or one for each of the {} ports", flags.port.len());
            return value("--devices", counts, &advice);
        }
        if !flags.watch.is_empty() && flags.watch.len() != flags.port.len() {
            let files =
                flags.watch.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(",");
            return value("--watch", files, &format!("one file for each of the {} ports", flags.port.len()));
        }
        let boards: u32 = (0..flags.port.len())
            .map(|bus| u32::from(*flags.devices.get(bus).or(flags.devices.first()).unwrap_or(&1)))
            .sum();
        if u32::from(flags.first_joint) + boards > u32::from(u16::MAX) {
            return value("--first-joint", flags.first_joint.to_string(), "too high for so many boards");
        }
        let numbers = [
            ("--rate-hz", flags.rate_hz.unwrap_or(1.0), false),
            ("--publish-rate-hz", flags.publish_rate_hz, false),
            ("--max-command-age-s", flags.max_command_age_s, true),
            ("--command-timeout-s", flags.command_timeout_s, true),
            ("--watchdog-s", flags.watchdog_s, true),
            ("--diagnostics-period-s", flags.diagnostics_period_s, false),
        ];
        for (name, number, may_be_zero) in numbers {
            if let Err(advice) = check_number(number, may_be_zero) {
                return value(name, number.to_string(), &advice);
            }
        }
        let message = match flags.message_type.split('/').collect::<Vec<_>>()[..] {
            ["joint_state"] | ["sensor_msgs", "JointState"] | ["sensor_msgs", "msg", "JointState"] => {
                MessageType::JointState
            }
            ["fluid_pressure"]
            | ["sensor_msgs", "FluidPressure"]
            | ["sensor_msgs", "msg", "FluidPressure"] => MessageType::FluidPressure,
            [package, name] | [package, "msg", name] if !package.is_empty() && !name.is_empty() => {
                MessageType::Pressures { package: package.to_owned(), name: name.to_owned() }
            }
            _ => {
                return value(
                    "--message-type",
                    flags.message_type.clone(),
                    "expected joint_state, fluid_pressure or PACKAGE/TYPE",
                );
            }
        };
        let from_environment = match (flags.domain_id, std::env::var("ROS_DOMAIN_ID")) {
            (None, Ok(text)) if !text.is_empty() => match text.parse() {
                Ok(id) if id <= 232 => Some(id),
                _ => return value("ROS_DOMAIN_ID", text, "expected a number from 0 to 232"),
            },
            _ => None,
        };
        let domain_id = flags.domain_id.or(from_environment).unwrap_or(0);
        let calibration = rig.as_ref().map_or(Ok(Calibration::default()), rig::calibration)?;
        let own = ChannelLimit {
            max_kpa: flags.max_kpa.unwrap_or(f64::INFINITY),
            max_rate_kpa_s: flags.max_rate_kpa_s.unwrap_or(f64::INFINITY),
        };
        let limits = rig.as_ref().map_or(Ok(Limits::default()), rig::limits);
        let limits = match limits.and_then(|limits| limits.and(own)) {
            Ok(limits) => limits,
            Err(error) => {
                let both = format!("{}, {}", own.max_kpa, own.max_rate_kpa_s);
                return value("--max-kpa, --max-rate-kpa-s", both, &error.to_string());
            }
        };
        Ok(Self { flags, names, domain_id, message, limits, calibration, rig })
    }

    /// Line rate, or the fastest that all boards agree to.
    pub fn baud(&self) -> BaudChoice {
        self.flags.baud.unwrap_or_default()
    }

    /// Boards on the bus at `index`.
    pub fn devices(&self, index: usize) -> u16 {
        let devices = &self.flags.devices;
        devices.get(index).or(devices.first()).copied().unwrap_or(1)
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

/// Whether `number` can be a rate or a time.
pub fn check_number(number: f64, may_be_zero: bool) -> Result<(), String> {
    let allowed = if may_be_zero { number >= 0.0 } else { number > 0.0 };
    if allowed && number <= 1e6 {
        Ok(())
    } else {
        Err(format!("must be {} 0 and at most 1e6", if may_be_zero { "at least" } else { "above" }))
    }
}

/// Leaves the last `count` of `items`, or all if that is 0.
fn keep_last<T>(items: &mut Vec<T>, count: usize) {
    if count > 0 {
        items.drain(..items.len().saturating_sub(count));
    }
}

/// Whether a parameter is what belongs to every node and means nothing to this one, or the value that `ros2 param dump` shows for a flag
/// that was not given.
fn means_nothing(name: &str, value: &str) -> bool {
    let not_given = value.is_empty() || (matches!(name, "rate_hz" | "sensors") && value == "0");
    not_given
        || name == "use_sim_time"
        || name == "start_type_description_service"
        || name.starts_with("qos_overrides")
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn settings(line: &str) -> Result<Settings, ArgsError> {
        Settings::from_command_line(format!("x {line}").split_whitespace().map(OsString::from))
    }

    #[test]
    fn the_arguments_are_consistent() {
        Flags::command().debug_assert();
    }

    #[test]
    fn parameters_are_flags() {
        let line =
            "--ros-args -p port:=['/dev/a','/dev/b'] -p devices:=[4,2] -p rate_hz:=500.0 -r __ns:=/arm";
        let settings = settings(line).unwrap();
        assert_eq!(settings.flags.port, [PathBuf::from("/dev/a"), PathBuf::from("/dev/b")]);
        assert_eq!((settings.devices(0), settings.devices(1)), (4, 2));
        assert_eq!(settings.flags.rate_hz, Some(500.0));
        assert_eq!(settings.names.full(), "/arm/pneudrive");
    }

    /// As launch files do, which put parameters behind flags. Only ports add up: each is a bus.
    #[test]
    fn the_last_word_counts_and_ports_add_up() {
        let settings = settings("--port a,b --rate-hz 100 --port c --ros-args -p rate_hz:=200.0").unwrap();
        assert_eq!(settings.flags.port, ["a", "b", "c"].map(PathBuf::from));
        assert_eq!(settings.flags.rate_hz, Some(200.0));
    }

    /// A file is the farthest away: flags win over it, and parameters on the command line over both.
    #[test]
    fn files_of_parameters_come_before_flags() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("params.yaml");
        let text = "/**:\n  ros__parameters: {port: [/dev/f, /dev/g], devices: [3, 2], rate_hz: 0.0, rig: '', use_sim_time: false}\n\
                    /arm/air:\n  ros__parameters: {max_kpa: 200.0, watchdog_s: 3.0}\n/other:\n  ros__parameters: {devices: 9}\n";
        std::fs::write(&file, text).unwrap();
        let file = file.display();
        let of = |line: &str| {
            let flags = settings(line).unwrap().flags;
            (flags.port, flags.devices, flags.max_kpa, flags.watchdog_s)
        };
        let ports = |ports: &[&str]| ports.iter().map(PathBuf::from).collect::<Vec<_>>();
        let alone = of(&format!("--ros-args --params-file {file}"));
        assert_eq!(alone, (ports(&["/dev/f", "/dev/g"]), vec![3, 2], None, 1.0));
        let named = of(&format!("--name air --ros-args -r __ns:=/arm --params-file {file}"));
        assert_eq!((named.2, named.3), (Some(200.0), 3.0));
        let flags = of(&format!("--port /dev/a -n 1 --ros-args --params-file {file}"));
        assert_eq!((flags.0, flags.1), (ports(&["/dev/a"]), vec![1]));
        let last = of(&format!(
            "--port /dev/a -n 1 --ros-args --params-file {file} -p port:=/dev/p -p devices:=[7]"
        ));
        assert_eq!((last.0, last.1), (ports(&["/dev/p"]), vec![7]));
        let refused = |line: &str| settings(line).unwrap_err().to_string();
        assert!(refused("--port a --ros-args --params-file /nowhere.yaml").contains("/nowhere.yaml"));
        assert!(refused("--port a --overwrite").contains("give --record"));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let refused = |line: &str| settings(line).unwrap_err().to_string();
        assert!(refused("--port a,b,c --devices 4,2").contains("each of the 3 ports"));
        assert!(refused("--port a,b --watch x.toml").contains("one file for each of the 2 ports"));
        assert!(refused("--port a --rate-hz 0").contains("--rate-hz 0: must be above 0"));
        assert!(refused("--port a --max-command-age-s NaN").contains("at least 0"));
        assert!(refused("--port a --message-type a/b/c").contains("PACKAGE/TYPE"));
    }

    /// Whoever wants commands to hold for ever says so.
    #[test]
    fn commands_expire_by_default() {
        let timeout_s = |line: &str| settings(line).unwrap().flags.command_timeout_s;
        assert_eq!(timeout_s("--port a"), 0.5);
        assert_eq!(timeout_s("--port a --command-timeout-s 2.5"), 2.5);
        for never in
            ["--command-timeout-s never", "--command-timeout-s 0", "--ros-args -p command_timeout_s:=never"]
        {
            assert_eq!(timeout_s(&format!("--port a {never}")), 0.0);
        }
    }

    #[test]
    fn limits_come_from_flags_and_rig_file_and_the_strictest_holds() {
        let folder = tempfile::tempdir().unwrap();
        let rig = folder.path().join("rig.toml");
        std::fs::write(&rig, "[boards.1.limits]\nmax_kpa = 100.0\n").unwrap();
        let line = format!(
            "--port a -n 2 --max-kpa 300 --ros-args -p max_rate_kpa_s:=50.0 -p rig:={}",
            rig.display()
        );
        let limits = settings(&line).unwrap().limits;
        let limit = |max_kpa| ChannelLimit { max_kpa, max_rate_kpa_s: 50.0 };
        assert_eq!((limits.of(0)[0], limits.of(1)[3]), (limit(300.0), limit(100.0)));
        let refused = |line: &str| settings(line).unwrap_err().to_string();
        assert!(refused("--port a --max-kpa -1").contains("a highest pressure of -1 kPa"));
        assert!(refused("--port a --rig /nowhere.toml").contains("/nowhere.toml"));
    }

    #[test]
    fn a_rig_file_says_what_the_flags_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let rig = folder.path().join("rig.toml");
        let text = "[bus]\nport = \"/dev/a\"\nboards = 3\nrate_hz = 250\n\
                    [boards.1.channels.2.sensor]\nzero_counts = 110.0\nkpa_per_count = 0.9\n";
        std::fs::write(&rig, text).unwrap();
        let settings = |line: &str| settings(&format!("--rig {} {line}", rig.display())).unwrap();
        let all = settings("");
        assert_eq!((&all.flags.port, all.devices(0)), (&vec![PathBuf::from("/dev/a")], 3));
        assert_eq!((all.flags.rate_hz, all.baud()), (Some(250.0), BaudChoice::Rate(1_000_000)));
        assert_eq!(all.calibration.channel(1, 2).zero_counts(), 110.0);
        std::fs::write(&rig, text.replace("rate_hz = 250", "baud = \"auto\"")).unwrap();
        assert_eq!(settings("").baud(), BaudChoice::Auto);
        assert_eq!(settings("--baud 500000").baud(), BaudChoice::Rate(500_000));
        let some = settings("--port b -n 2 --rate-hz 100");
        assert_eq!((&some.flags.port, some.devices(0)), (&vec![PathBuf::from("b")], 2));
        assert_eq!(some.flags.rate_hz, Some(100.0));
    }

    #[test]
    fn the_originals_message_goes_by_any_name() {
        let message = settings("--port a --message-type arm_msgs/Pressures").unwrap().message;
        assert_eq!(message, MessageType::Pressures { package: "arm_msgs".into(), name: "Pressures".into() });
    }
}
