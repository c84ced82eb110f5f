//! ROS 2 messages: what recordings hold and what the ROS node sends. Plain data; serialised as CDR
//! in the order of their fields.
//!
//! One message a board carries its four chambers, in kPa gauge, channel 0 first:
//!
//! - `sensor_msgs/msg/JointState`, which every ROS installation has. Pressures stand in `effort`,
//!   and `name` says of each value what it is, in the words of the measured-data format
//!   (`b0_p0_kpa`, `b0_cmd0_kpa`).
//! - [`Pressures`], the original project's `{Header header, float64[] pressure}`.

mod sensors;

pub use sensors::{FluidPressure, Imu, Quaternion, Vector3};

use pneudrive_protocol::CHANNELS;
use serde::{Deserialize, Serialize};

/// `builtin_interfaces/msg/Time`: since 1970-01-01 UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// The rest, ns.
    pub nanosec: u32,
}

impl Time {
    /// From ns since 1970. ROS counts seconds in 32 bits: the year 2038 is where it stops.
    pub fn from_unix_ns(unix_ns: u64) -> Self {
        let sec = i32::try_from(unix_ns / 1_000_000_000).unwrap_or(i32::MAX);
        Self { sec, nanosec: (unix_ns % 1_000_000_000) as u32 }
    }

    /// ns since 1970. Times before count as 1970.
    pub fn unix_ns(self) -> u64 {
        u64::try_from(self.sec).unwrap_or(0) * 1_000_000_000 + u64::from(self.nanosec)
    }

    /// Whether the sender left the stamp out.
    pub fn is_zero(self) -> bool {
        self == Self::default()
    }
}

/// `std_msgs/msg/Header`
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Header {
    /// When what the message says was so.
    pub stamp: Time,
    /// In our messages the bus, such as `bus0`: boards on the same bus are asked in turn, those on
    /// different buses are not in step.
    pub frame_id: String,
}

/// `sensor_msgs/msg/JointState`
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct JointState {
    /// When and which bus.
    pub header: Header,
    /// What each value of `effort` is.
    pub name: Vec<String>,
    /// Not used.
    pub position: Vec<f64>,
    /// Not used.
    pub velocity: Vec<f64>,
    /// Pressures, kPa gauge, and what else `name` says.
    pub effort: Vec<f64>,
}

impl JointState {
    /// Its name in ROS.
    pub const ROS_TYPE: &str = "sensor_msgs/msg/JointState";
    /// What tells this definition from others of that name (REP 2016), in ROS 2 Jazzy and later.
    pub const ROS_TYPE_HASH: &str = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e";
    /// What states have of a board's sensors, behind `b{n}_`: supply pressure, kPa gauge;
    /// temperature of the chip, degrees Celsius; the I2C connector's 5 V.
    pub const SENSORS: [&str; 3] = ["supply_kpa", "chip_c", "rail_v"];
    /// Its definition with all it depends on, as the MCAP registry's `ros2msg` has it.
    pub const DEFINITION: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

    /// A state of joint `joint`: four measured pressures, then the four commands that were sent
    /// when they were asked for. Those four pressures were measured before that command could have
    /// an effect.
    pub fn state(joint: u16, bus: usize) -> Self {
        let measured = (0..CHANNELS).map(|k| format!("b{joint}_p{k}_kpa"));
        Self::of(measured.chain(commands(joint)).collect(), bus)
    }

    /// As [`state`](Self::state), with what is asked for in pages behind: the drives of the four
    /// valves, -1 (vent fully) to 1 (fill fully), then the [`SENSORS`](Self::SENSORS).
    pub fn state_with(joint: u16, bus: usize, drives: bool, sensors: bool) -> Self {
        let mut name = Self::state(joint, bus).name;
        name.extend((0..CHANNELS).filter(|_| drives).map(|k| format!("b{joint}_u{k}")));
        name.extend(Self::SENSORS.iter().filter(|_| sensors).map(|sensor| format!("b{joint}_{sensor}")));
        Self::of(name, bus)
    }

    /// Four commands to joint `joint`.
    pub fn command(joint: u16, bus: usize) -> Self {
        Self::of(commands(joint).collect(), bus)
    }

    /// Gives channels that the ROS node calls by the rig file's names their numbers again, by the
    /// joint in the name of the topic: the first of `joint_3/pressure_state`, `left_p_kpa`, is
    /// `b3_p0_kpa`.
    pub fn number_names(&mut self, topic: &str) {
        let mut parts = topic.rsplit('/');
        let joint: Option<u16> = match (parts.next(), parts.next()) {
            (Some("pressure_state"), Some(joint)) => {
                joint.strip_prefix("joint_").and_then(|number| number.parse().ok())
            }
            _ => None,
        };
        let Some(joint) = joint else { return };
        let numbered = Self::state(joint, 0).name;
        for (place, (name, numbered)) in self.name.iter_mut().zip(numbered).enumerate() {
            let ending = if place < CHANNELS { "_p_kpa" } else { "_cmd_kpa" };
            if name.ends_with(ending) {
                *name = numbered;
            }
        }
    }

    fn of(name: Vec<String>, bus: usize) -> Self {
        let effort = vec![f64::NAN; name.len()];
        let header = Header { stamp: Time::default(), frame_id: bus_frame(bus) };
        Self { header, name, effort, ..Self::default() }
    }

    /// The same message with other content.
    pub fn fill(&mut self, stamp: Time, values: impl IntoIterator<Item = f64>) {
        self.header.stamp = stamp;
        self.effort.clear();
        self.effort.extend(values);
    }
}

/// The original project's message, `{Header header, float64[] pressure}`, kPa gauge.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Pressures {
    /// When and which bus.
    pub header: Header,
    /// Pressures, kPa gauge.
    pub pressure: Vec<f64>,
}

/// `rcl_interfaces/msg/Log`: a line of a log, as nodes publish them on /rosout.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Log {
    /// When it was said.
    pub stamp: Time,
    /// How bad it is: [`INFO`](Self::INFO) or [`WARN`](Self::WARN).
    pub level: u8,
    /// Who says it.
    pub name: String,
    /// What is said.
    pub msg: String,
    /// Not used.
    pub file: String,
    /// In our messages the kind of event, such as `board_missing`.
    pub function: String,
    /// Not used.
    pub line: u32,
}

impl Log {
    /// Level of what is good to know.
    pub const INFO: u8 = 20;
    /// Level of what somebody should look after.
    pub const WARN: u8 = 30;
    /// Its name in ROS.
    pub const ROS_TYPE: &str = "rcl_interfaces/msg/Log";
    /// What tells this definition from others of that name (REP 2016), in ROS 2 Jazzy and later.
    pub const ROS_TYPE_HASH: &str = "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac";
    /// Its definition with all it depends on, as the MCAP registry's `ros2msg` has it.
    pub const DEFINITION: &str = "\
byte DEBUG=10
byte INFO=20
byte WARN=30
byte ERROR=40
byte FATAL=50
builtin_interfaces/Time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";
}

/// What `frame_id` says of the boards on bus number `bus` of one program.
pub fn bus_frame(bus: usize) -> String {
    format!("bus{bus}")
}

/// What a message calls the command to one channel of a joint, such as `b0_cmd3_kpa`.
pub fn command_name(joint: u16, channel: usize) -> String {
    format!("b{joint}_cmd{channel}_kpa")
}

fn commands(joint: u16) -> impl Iterator<Item = String> {
    (0..CHANNELS).map(move |k| command_name(joint, k))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes that PyPI `rosbags` 0.11 made of the same message (XCDR1, little endian, behind the 4
    /// bytes of encapsulation).
    #[test]
    fn a_joint_state_is_serialised_as_ros_does() {
        let message = JointState {
            header: Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "bus0".into() },
            name: vec!["a".into()],
            effort: vec![1.0, 2.0],
            ..JointState::default()
        };
        let bytes = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(&message).unwrap();
        let expected = [
            &[1, 0, 0, 0, 2, 0, 0, 0][..],            // stamp
            &[5, 0, 0, 0, b'b', b'u', b's', b'0', 0], // frame_id with its NUL
            &[0, 0, 0],                               // padding to 4
            &[1, 0, 0, 0, 2, 0, 0, 0, b'a', 0],       // one name of 2 bytes
            &[0, 0],                                  // padding to 4
            &[0, 0, 0, 0, 0, 0, 0, 0],                // no position, no velocity
            &[2, 0, 0, 0, 0, 0, 0, 0],                // two efforts, padding to 8
            &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f],          // 1.0
            &[0, 0, 0, 0, 0, 0, 0, 0x40],             // 2.0
        ]
        .concat();
        assert_eq!(bytes, expected);
    }

    #[test]
    fn names_say_what_the_values_are() {
        let state = JointState::state(5, 1);
        assert_eq!(state.name[0], "b5_p0_kpa");
        assert_eq!(state.name[7], "b5_cmd3_kpa");
        assert_eq!((state.header.frame_id.as_str(), state.effort.len()), ("bus1", 8));
        let with_drives = JointState::state_with(5, 1, true, false);
        assert_eq!((with_drives.name[7].as_str(), with_drives.name[11].as_str()), ("b5_cmd3_kpa", "b5_u3"));
        assert_eq!(with_drives.effort.len(), 12);
        let with_all = JointState::state_with(5, 1, true, true);
        assert_eq!(with_all.name[12..], ["b5_supply_kpa", "b5_chip_c", "b5_rail_v"]);
        assert_eq!(JointState::state_with(5, 1, false, true).name[8], "b5_supply_kpa");
        assert_eq!(JointState::state_with(5, 1, false, false).name, state.name);
    }

    #[test]
    fn named_channels_get_their_numbers_back() {
        let mut state = JointState::state(3, 0);
        (state.name[0], state.name[4]) = ("front left_p_kpa".into(), "front left_cmd_kpa".into());
        state.number_names("/pneudrive/joint_3/pressure_state");
        assert_eq!(state.name, JointState::state(3, 0).name);
        // A robot's own names are no channels.
        let mut elbow = JointState { name: vec!["elbow".into()], ..JointState::default() };
        elbow.number_names("/pneudrive/joint_3/pressure_state");
        elbow.number_names("/joint_states");
        assert_eq!(elbow.name, ["elbow"]);
    }

    #[test]
    fn times_go_round() {
        let unix_ns = 1_763_742_822_123_456_789;
        assert_eq!(Time::from_unix_ns(unix_ns).unix_ns(), unix_ns);
    }
}
