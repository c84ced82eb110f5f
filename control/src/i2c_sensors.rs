//! The latest readings of the sensors on the I2C connector, and of the board's electronics, for
//! those who ask for them.

use crate::Micros;
use pneudrive_protocol::pages::{
    Acceleration, AngularRate, Electronics, Entry, GaugePressure, SensorEntry, SensorPart, SensorState,
    SensorStatus, SensorTimes, SupplyReading, Temperature, Voltage,
};

/// The latest readings of a board's I2C sensors and when they were made.
///
/// Whoever reads the sensors tells it what was found, lost and read; pages say it. Nothing waits,
/// and nothing of it goes into the control loop. A reading older than
/// [`STALE_AFTER`](Self::STALE_AFTER) is said to be stale.
///
/// ```
/// use pneudrive_control::{I2cSensors, Micros};
/// use pneudrive_protocol::pages::{GaugePressure, SensorPart, SensorState};
///
/// let mut sensors = I2cSensors::new();
/// sensors.supply_found(SensorPart::Ads1115);
/// sensors.supply_read(Micros::from_millis(40), Some(GaugePressure::from_pa(650_000)));
/// assert_eq!(sensors.supply(Micros::from_millis(90)).live_kpa(), Some(650.0));
/// assert_eq!(sensors.supply(Micros::from_millis(141)).state, SensorState::Stale);
/// ```
#[derive(Debug, Clone)]
pub struct I2cSensors {
    supply: Part,
    pressure: GaugePressure,
    out_of_range: bool,
    imu: Part,
    motion: Motion,
    rail: Option<Voltage>,
    chip: Option<Temperature>,
    errors: u16,
    recoveries: u16,
}

/// A part, if one was found, and when it was read.
#[derive(Debug, Clone, Copy)]
struct Part {
    part: SensorPart,
    read: Option<Micros>,
    readings: u16,
}

/// Acceleration and angular rate of one moment, as they stand in pages.
///
/// They are made into words when they are read, because a board has 20 us for an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Motion {
    live: [Entry; 2],
    stale: [Entry; 2],
}

impl Motion {
    /// From x, y and z of the [`Acceleration`] in steps of 0.01 m/s^2 and of the [`AngularRate`] in
    /// steps of 1/400 rad/s.
    pub fn new(acceleration: [i16; 3], rate: [i16; 3]) -> Self {
        let entries = |live| {
            [
                Acceleration::from_steps(acceleration, live).to_entry(),
                AngularRate::from_steps(rate, live).to_entry(),
            ]
        };
        Self { live: entries(true), stale: entries(false) }
    }
}

impl Part {
    const NONE: Self = Self { part: SensorPart::None, read: None, readings: 0 };

    fn found(&mut self, part: SensorPart) {
        *self = Self { part, read: None, ..*self };
    }

    fn is_absent(&self) -> bool {
        self.part == SensorPart::None
    }

    fn read(&mut self, now: Micros) {
        self.read = Some(now);
        let next = self.readings + 1;
        self.readings = if next == SensorTimes::COUNT_MODULUS { 0 } else { next };
    }

    fn age(&self, now: Micros) -> Option<Micros> {
        self.read.map(|read| now.since(read))
    }

    fn state(&self, now: Micros) -> SensorState {
        match self.age(now) {
            _ if self.is_absent() => SensorState::Absent,
            Some(age) if age <= I2cSensors::STALE_AFTER => SensorState::Live,
            _ => SensorState::Stale,
        }
    }

    fn age_ms(&self, now: Micros) -> u16 {
        self.age(now).map_or(SupplyReading::AGE_MAX_MS, whole_millis)
    }
}

/// ms, at most 1023. Without a division, which takes a processor that has none 2 us.
fn whole_millis(age: Micros) -> u16 {
    const MAX: u32 = 1_000 * SupplyReading::AGE_MAX_MS as u32;
    let age = u32::try_from(age.get()).map_or(MAX, |age| age.min(MAX));
    // 33,555 / 2^22 is 1/125 and 17 millionths of it; the product is below 2^32.
    (((age >> 3) * 33_555) >> 22) as u16
}

impl I2cSensors {
    /// How long a reading counts as live: five or more times the time between two readings.
    pub const STALE_AFTER: Micros = Micros::from_millis(100);

    /// Of a board that has found nothing yet.
    pub fn new() -> Self {
        Self {
            supply: Part::NONE,
            pressure: GaugePressure::from_pa(0),
            out_of_range: false,
            imu: Part::NONE,
            motion: Motion::new([0; 3], [0; 3]),
            rail: None,
            chip: None,
            errors: 0,
            recoveries: 0,
        }
    }

    /// A part that measures the supply pressure was found. It has no reading yet.
    pub fn supply_found(&mut self, part: SensorPart) {
        self.supply.found(part);
        self.pressure = GaugePressure::from_pa(0);
        self.out_of_range = false;
        self.rail = None;
    }

    /// It does not answer any more.
    pub fn supply_lost(&mut self) {
        self.supply_found(SensorPart::None);
    }

    /// The supply pressure was measured at `now`: `None` if the signal is none that its transducer
    /// gives.
    pub fn supply_read(&mut self, now: Micros, pressure: Option<GaugePressure>) {
        self.supply.read(now);
        self.out_of_range = pressure.is_none();
        if let Some(pressure) = pressure {
            self.pressure = pressure;
        }
    }

    /// Its converter measured the 5 V that the transducer is fed with, in the same moment.
    pub fn rail_read(&mut self, rail: Voltage) {
        self.rail = Some(rail);
    }

    /// The chip has measured its temperature.
    pub fn chip_read(&mut self, temperature: Temperature) {
        self.chip = Some(temperature);
    }

    /// An IMU was found. It has no reading yet.
    pub fn imu_found(&mut self, part: SensorPart) {
        self.imu.found(part);
        self.motion = Motion::new([0; 3], [0; 3]);
    }

    /// It does not answer any more.
    pub fn imu_lost(&mut self) {
        self.imu_found(SensorPart::None);
    }

    /// The IMU was read at `now`.
    pub fn imu_read(&mut self, now: Micros, motion: Motion) {
        self.imu.read(now);
        self.motion = motion;
    }

    /// A transfer with a part that had been found failed, or what was read makes no sense.
    pub fn error(&mut self) {
        self.errors = (self.errors + 1) % SensorStatus::COUNT_MODULUS;
    }

    /// Something held the lines, and they were freed.
    pub fn recovered(&mut self) {
        self.recoveries = (self.recoveries + 1) % SensorStatus::COUNT_MODULUS;
    }

    /// What is there at `now`.
    pub fn status(&self, now: Micros) -> SensorStatus {
        SensorStatus {
            supply: self.supply.part,
            supply_state: self.supply_state(now),
            imu: self.imu.part,
            imu_state: self.imu.state(now),
            errors: self.errors,
            recoveries: self.recoveries,
        }
    }

    fn supply_state(&self, now: Micros) -> SensorState {
        match self.supply.state(now) {
            SensorState::Live if self.out_of_range => SensorState::OutOfRange,
            state => state,
        }
    }

    /// The supply pressure as it is known at `now`.
    pub fn supply(&self, now: Micros) -> SupplyReading {
        let (state, age_ms) = (self.supply_state(now), self.supply.age_ms(now));
        SupplyReading { state, age_ms, pressure: self.pressure }
    }

    /// The words of an entry at `now`.
    pub(crate) fn entry(&self, entry: SensorEntry, now: Micros) -> Entry {
        match entry {
            SensorEntry::Status => self.status(now).to_entry(),
            SensorEntry::Supply => self.supply(now).to_entry(),
            SensorEntry::Acceleration => self.motion_words(now)[0],
            SensorEntry::AngularRate => self.motion_words(now)[1],
            SensorEntry::Times => SensorTimes {
                supply_age_ms: self.supply.age_ms(now),
                supply_readings: self.supply.readings,
                imu_age_ms: self.imu.age_ms(now),
                imu_readings: self.imu.readings,
            }
            .to_entry(),
        }
    }

    /// What the board knows of its electronics at `now`. A voltage is as old as the supply
    /// pressure.
    pub fn electronics(&self, now: Micros) -> Electronics {
        let is_live = self.supply.state(now) == SensorState::Live;
        Electronics { chip_temperature: self.chip, rail_voltage: self.rail.filter(|_| is_live) }
    }

    fn motion_words(&self, now: Micros) -> [Entry; 2] {
        match self.imu.state(now) {
            SensorState::Live => self.motion.live,
            SensorState::Stale | SensorState::OutOfRange => self.motion.stale,
            SensorState::Absent => [Acceleration::ABSENT.to_entry(), AngularRate::ABSENT.to_entry()],
        }
    }
}

impl Default for I2cSensors {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The next one may begin 17 millionths of the age early: 18 us at the most.
    #[test]
    fn ages_are_whole_milliseconds() {
        for age in (0..1_100_000).step_by(3).chain([u64::MAX]) {
            let ms = u64::from(whole_millis(Micros::new(age)));
            let (least, most) = (age / 1_000, age.saturating_add(18) / 1_000);
            assert!((least.min(1_023)..=most.min(1_023)).contains(&ms), "{age} us: {ms} ms");
        }
    }

    #[test]
    fn counts_start_again_before_they_leave_their_word() {
        let mut sensors = I2cSensors::new();
        for _ in 0..2_048 {
            sensors.error();
            sensors.imu_read(Micros::ZERO, Motion::new([0; 3], [0; 3]));
        }
        assert_eq!((sensors.status(Micros::ZERO).errors, sensors.imu.readings), (0, 2_048 % 1_023));
    }
}
