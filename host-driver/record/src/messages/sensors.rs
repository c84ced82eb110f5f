//! Messages of the sensors on a board's I2C connector.

use super::{Header, Time};
use serde::{Deserialize, Serialize};

/// `sensor_msgs/msg/FluidPressure`: a supply pressure, or what the ROS node sends of one chamber.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FluidPressure {
    /// When it was measured, and where: `joint_0_supply`; `joint_0_chamber_1_gauge` of a chamber.
    pub header: Header,
    /// Pa. **Absolute**, as the message's definition wants it, of a supply; gauge where the frame
    /// says so.
    pub fluid_pressure: f64,
    /// 0: not known.
    pub variance: f64,
}

impl FluidPressure {
    /// Its name in ROS.
    pub const ROS_TYPE: &str = "sensor_msgs/msg/FluidPressure";
    /// What tells this definition from others of that name (REP 2016), in ROS 2 Jazzy and later.
    pub const ROS_TYPE_HASH: &str = "RIHS01_22dfb2b145a0bd5a31a1ac3882a1b32148b51d9b2f3bab250290d66f3595bc32";
    /// Its definition with all it depends on, as the MCAP registry's `ros2msg` has it.
    pub const DEFINITION: &str = "\
std_msgs/Header header
float64 fluid_pressure
float64 variance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

    /// The supply pressure at joint `joint`, to be filled in.
    pub fn of_joint(joint: u16) -> Self {
        let header = Header { frame_id: format!("joint_{joint}_supply"), ..Header::default() };
        Self { header, ..Self::default() }
    }

    /// The same message with other content: a pressure above that of the atmosphere, kPa, where
    /// that has `ambient_kpa`.
    pub fn fill(&mut self, stamp: Time, gauge_kpa: f64, ambient_kpa: f64) {
        self.header.stamp = stamp;
        self.fluid_pressure = 1e3 * (gauge_kpa + ambient_kpa);
    }
}

/// `geometry_msgs/msg/Vector3`
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Vector3 {
    /// Along the first axis.
    pub x: f64,
    /// Along the second.
    pub y: f64,
    /// Along the third.
    pub z: f64,
}

impl From<[f64; 3]> for Vector3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

/// `geometry_msgs/msg/Quaternion`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Along the first axis.
    pub x: f64,
    /// Along the second.
    pub y: f64,
    /// Along the third.
    pub z: f64,
    /// Its real part.
    pub w: f64,
}

impl Default for Quaternion {
    /// No rotation.
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `sensor_msgs/msg/Imu`, without an orientation: `orientation_covariance[0]` is -1, as the
/// definition wants it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Imu {
    /// When the board was asked, and in whose axes: `joint_0_imu`.
    pub header: Header,
    /// Not measured.
    pub orientation: Quaternion,
    /// -1 in its first place: there is no orientation.
    pub orientation_covariance: [f64; 9],
    /// rad/s.
    pub angular_velocity: Vector3,
    /// 0: not known.
    pub angular_velocity_covariance: [f64; 9],
    /// m/s^2, gravity included.
    pub linear_acceleration: Vector3,
    /// 0: not known.
    pub linear_acceleration_covariance: [f64; 9],
}

impl Imu {
    /// Its name in ROS.
    pub const ROS_TYPE: &str = "sensor_msgs/msg/Imu";
    /// What tells this definition from others of that name (REP 2016), in ROS 2 Jazzy and later.
    pub const ROS_TYPE_HASH: &str = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b";
    /// Its definition with all it depends on, as the MCAP registry's `ros2msg` has it.
    pub const DEFINITION: &str = "\
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Quaternion
float64 x 0
float64 y 0
float64 z 0
float64 w 1
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
";

    /// Of joint `joint`, to be filled in.
    pub fn of_joint(joint: u16) -> Self {
        let header = Header { frame_id: format!("joint_{joint}_imu"), ..Header::default() };
        let mut orientation_covariance = [0.0; 9];
        orientation_covariance[0] = -1.0;
        Self {
            header,
            orientation: Quaternion::default(),
            orientation_covariance,
            angular_velocity: Vector3::default(),
            angular_velocity_covariance: [0.0; 9],
            linear_acceleration: Vector3::default(),
            linear_acceleration_covariance: [0.0; 9],
        }
    }

    /// The same message with other content: m/s^2 and rad/s.
    pub fn fill(&mut self, stamp: Time, acceleration_m_s2: [f64; 3], angular_rate_rad_s: [f64; 3]) {
        self.header.stamp = stamp;
        self.linear_acceleration = acceleration_m_s2.into();
        self.angular_velocity = angular_rate_rad_s.into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cdr(message: &impl Serialize) -> Vec<u8> {
        cdr_encoding::to_vec::<_, byteorder::LittleEndian>(message).unwrap()
    }

    /// Header of 8 + 4 + 14 + 1 bytes, padding to 8, then 37 numbers of 8 bytes: no array of fixed
    /// length has its length before it.
    #[test]
    fn an_imu_is_serialised_as_ros_does() {
        let mut message = Imu::of_joint(3);
        message.fill(Time { sec: 1, nanosec: 2 }, [0.1, 0.2, 9.81], [1.0, -1.0, 0.5]);
        let bytes = cdr(&message);
        assert_eq!(message.header.frame_id, "joint_3_imu");
        let numbers = 24;
        assert_eq!(bytes.len(), numbers + 8 * 37);
        let number = |place: usize| {
            let at = numbers + 8 * place;
            f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
        };
        assert_eq!([number(3), number(4)], [1.0, -1.0], "w, and that there is no orientation");
        assert_eq!([13, 14, 15].map(number), [1.0, -1.0, 0.5]);
        assert_eq!([25, 26, 27].map(number), [0.1, 0.2, 9.81]);
    }

    #[test]
    fn a_fluid_pressure_is_absolute_and_in_pa() {
        let mut message = FluidPressure::of_joint(0);
        message.fill(Time::default(), 550.0, 101.325);
        assert_eq!(message.fluid_pressure, 651_325.0);
        let bytes = cdr(&message);
        assert_eq!(bytes[bytes.len() - 16..bytes.len() - 8], 651_325.0_f64.to_le_bytes());
    }
}
