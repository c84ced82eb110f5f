//! What boards have measured beside their pressures.

use std::time::Duration;

/// A supply pressure that a board has measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupplyPressure {
    /// Above the atmosphere, kPa.
    pub kpa: f64,
    /// When it was measured, to a ms, ns on the line's clock: the board was asked later.
    pub measured_ns: u64,
}

impl SupplyPressure {
    /// An older one is not shown to people: longer than the seconds between two questions where
    /// boards are asked seldom.
    pub const OLD: Duration = Duration::from_secs(10);

    /// How old it is at `now_ns`.
    pub fn age(&self, now_ns: u64) -> Duration {
        Duration::from_nanos(now_ns.saturating_sub(self.measured_ns))
    }

    /// What people are shown at `now_ns`, kPa gauge: nothing that is [old](Self::OLD).
    pub fn shown_kpa(&self, now_ns: u64) -> Option<f64> {
        (self.age(now_ns) <= Self::OLD).then_some(self.kpa)
    }
}

/// What a board's IMU has measured, along and about its own axes x, y and z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Acceleration, gravity included, m/s^2.
    pub acceleration_m_s2: [f64; 3],
    /// Angular rate, rad/s.
    pub angular_rate_rad_s: [f64; 3],
    /// When the board was asked, ns on the line's clock: it had measured at most 100 ms before.
    pub asked_ns: u64,
}

/// What a board tells of its electronics. `None` where it does not know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElectronicsReading {
    /// Temperature of its chip, a mean of a second, degrees Celsius.
    pub chip_c: Option<f64>,
    /// The 5 V of its I2C connector, at the supply sensor, V.
    pub rail_v: Option<f64>,
    /// When the board was asked, ns on the line's clock.
    pub asked_ns: u64,
}

impl ElectronicsReading {
    /// The chip's temperature that people are shown at `now_ns`, degrees Celsius: none that is as
    /// old as a supply pressure may not be.
    pub fn shown_chip_c(&self, now_ns: u64) -> Option<f64> {
        let age = Duration::from_nanos(now_ns.saturating_sub(self.asked_ns));
        self.chip_c.filter(|_| age <= SupplyPressure::OLD)
    }
}

/// The last readings of a board's sensors. `None` where it has none, or it is not live.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoardSensors {
    /// The supply pressure. It does not get newer by being looked at.
    pub supply: Option<SupplyPressure>,
    /// Acceleration and angular rate.
    pub motion: Option<Motion>,
    /// Temperature and voltage, asked for once a second.
    pub electronics: Option<ElectronicsReading>,
    /// Whether `supply` is of this cycle.
    pub supply_is_new: bool,
    /// Whether `motion` is of this cycle.
    pub motion_is_new: bool,
    /// Whether `electronics` is of this cycle.
    pub electronics_is_new: bool,
}

impl BoardSensors {
    /// The supply pressure, if it is of this cycle.
    pub fn new_supply(&self) -> Option<SupplyPressure> {
        self.supply.filter(|_| self.supply_is_new)
    }

    /// Acceleration and angular rate, if they are of this cycle.
    pub fn new_motion(&self) -> Option<Motion> {
        self.motion.filter(|_| self.motion_is_new)
    }

    /// Temperature and voltage, if they are of this cycle.
    pub fn new_electronics(&self) -> Option<ElectronicsReading> {
        self.electronics.filter(|_| self.electronics_is_new)
    }

    /// The same readings in the next cycle.
    pub(super) fn grow_old(&mut self) {
        (self.supply_is_new, self.motion_is_new, self.electronics_is_new) = (false, false, false);
    }
}
