use super::super::Entry;
use crate::Counts;

/// When and how often the sensors were read: page 30, entry 4. Words in the order of the fields.
///
/// A host tells a new reading from one that it has by the count, and knows from the age when it was
/// made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SensorTimes {
    /// How long ago the supply pressure was measured, ms; 1023 stands for that or more, and for
    /// never.
    pub supply_age_ms: u16,
    /// Readings of the supply pressure since the board's start, modulo 1023.
    pub supply_readings: u16,
    /// How long ago the IMU was read, ms; 1023 stands for that or more, and for never.
    pub imu_age_ms: u16,
    /// Readings of the IMU since the board's start, modulo 1023.
    pub imu_readings: u16,
}

impl SensorTimes {
    /// Readings are counted modulo this, so that no word of theirs is 1023.
    pub const COUNT_MODULUS: u16 = 1_023;

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        let [supply, imu] = [self.supply_readings, self.imu_readings].map(|n| n % Self::COUNT_MODULUS);
        [self.supply_age_ms, supply, self.imu_age_ms, imu].map(Counts::saturating)
    }

    /// From a page answer; `None` if a word stands for nothing.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [supply_age_ms, supply_readings, imu_age_ms, imu_readings] = entry.map(Counts::get);
        let counts = supply_readings < Self::COUNT_MODULUS && imu_readings < Self::COUNT_MODULUS;
        counts.then_some(Self { supply_age_ms, supply_readings, imu_age_ms, imu_readings })
    }
}
