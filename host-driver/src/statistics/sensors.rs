use crate::poller::BoardSensors;
use serde::Serialize;

/// The last readings of a board's sensors. `None` where it has no such sensor, or that is not live.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SensorFigures {
    /// Supply pressure, kPa gauge.
    pub supply_kpa: Option<f64>,
    /// Age of the supply pressure when these figures were made, s.
    pub supply_age_s: Option<f64>,
    /// Along x, y and z of the IMU, gravity included, m/s^2.
    pub acceleration_m_s2: Option<[f64; 3]>,
    /// About x, y and z of the IMU, rad/s.
    pub angular_rate_rad_s: Option<[f64; 3]>,
    /// Temperature of the board's chip, degrees Celsius.
    pub chip_c: Option<f64>,
    /// The 5 V of its I2C connector, V.
    pub rail_v: Option<f64>,
}

impl SensorFigures {
    pub(crate) fn new(sensors: &BoardSensors, now_ns: u64) -> Self {
        Self {
            supply_kpa: sensors.supply.map(|supply| supply.kpa),
            supply_age_s: sensors.supply.map(|supply| supply.age(now_ns).as_secs_f64()),
            acceleration_m_s2: sensors.motion.map(|motion| motion.acceleration_m_s2),
            angular_rate_rad_s: sensors.motion.map(|motion| motion.angular_rate_rad_s),
            chip_c: sensors.electronics.and_then(|electronics| electronics.chip_c),
            rail_v: sensors.electronics.and_then(|electronics| electronics.rail_v),
        }
    }
}
