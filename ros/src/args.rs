//! What flags and ROS parameters mean together.

use crate::flags::Flags;
use crate::names::{NameError, Names};
use crate::params_file::{self, ParamsFileError};
use crate::ros_args::{self, RosArgsError};
use clap::parser::ValueSource;
use clap::{CommandFactory, Parser};
use pneudrive_host::Calibration;
use pneudrive_host::poller::{BaudChoice, ChannelLimit, Limits};
use pneudrive_host::rig::{self, CalibrationError, LeftOut, Rig, RigError, TooMany};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::PathBuf;

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
    /// Its boards.
    #[error(transparent)]
    LeftOut(#[from] LeftOut),
    /// How many those are.
    #[error(transparent)]
    TooMany(#[from] TooMany),
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
        // The node's name says which parameters of a file are its own. What is wrong with the flags
        // is told below.
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
            flags.devices.extend(bus.boards);
        }
        flags.baud = flags.baud.or(rig::baud(rig));
        flags.rate_hz = flags.rate_hz.or(bus.rate_hz);
    }

    fn check(mut flags: Flags, names: Names) -> Result<Self, ArgsError> {
        let rig = flags.rig.as_deref().map(Rig::load).transpose()?;
        if let Some(rig) = &rig {
            let said = flags.devices.iter().max().map(|most| (*most, format!("--devices {most}")));
            let given = said.as_ref().map(|(most, said)| (*most, said.as_str()));
            if let Some(left_out) = rig::left_out(rig, given)? {
                log::warn!("{left_out}");
            }
            if flags.devices.is_empty() {
                rig::few_enough(rig, flags.max_devices, "--max-devices")?;
            }
            Self::fill(&mut flags, rig);
        }
        if flags.devices.is_empty() {
            flags.devices.push(1);
        }
        let value =
            |name, value: String, advice: &str| Err(ArgsError::Value { name, value, advice: advice.into() });
        if let Some(devices) = flags.devices.iter().find(|devices| **devices > flags.max_devices) {
            let advice = format!(
                "must be 1 to {}; boards with more than a two-way address switch need --max-devices, up to 255",
                flags.max_devices
            );
            return value("--devices", devices.to_string(), &advice);
        }
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

/// Whether a parameter is what belongs to every node and means nothing to this one, or the value
/// that `ros2 param dump` shows for a flag that was not given.
fn means_nothing(name: &str, value: &str) -> bool {
    let not_given = value.is_empty() || (matches!(name, "rate_hz" | "sensors") && value == "0");
    not_given
        || name == "use_sim_time"
        || name == "start_type_description_service"
        || name.starts_with("qos_overrides")
}

#[cfg(test)]
mod tests;
