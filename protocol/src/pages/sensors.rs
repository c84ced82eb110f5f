//! The sensors on a board's I2C connector: page 30.

mod motion;
mod supply;
mod times;

use super::Entry;
use crate::Counts;
use core::fmt;
pub use motion::{Acceleration, AngularRate};
pub use supply::{GaugePressure, SupplyReading};
pub use times::SensorTimes;

/// An entry of page 30; the discriminant is its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum SensorEntry {
    /// A [`SensorStatus`].
    Status = 0,
    /// A [`SupplyReading`].
    Supply = 1,
    /// An [`Acceleration`].
    Acceleration = 2,
    /// An [`AngularRate`], of the same moment if both come between two readings.
    AngularRate = 3,
    /// [`SensorTimes`].
    Times = 4,
}

impl SensorEntry {
    /// In the order of their numbers.
    pub const ALL: [Self; 5] =
        [Self::Status, Self::Supply, Self::Acceleration, Self::AngularRate, Self::Times];
    pub(super) const PAGE: u8 = 30;

    /// The entry with this number.
    #[inline]
    pub const fn of_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Status),
            1 => Some(Self::Supply),
            2 => Some(Self::Acceleration),
            3 => Some(Self::AngularRate),
            4 => Some(Self::Times),
            _ => None,
        }
    }
}

/// How much the reading of a sensor can be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum SensorState {
    /// There is no such part on the connector.
    Absent = 0,
    /// The last reading is at most 100 ms old.
    Live = 1,
    /// There is a part, but its last reading is older, or there was none yet.
    Stale = 2,
    /// There is a part, and its signal says that what it measures is not connected properly.
    OutOfRange = 3,
}

impl SensorState {
    /// Its name in JSON: that of the variant, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::Live => "live",
            Self::Stale => "stale",
            Self::OutOfRange => "out_of_range",
        }
    }

    const fn of_number(number: u16) -> Option<Self> {
        match number {
            0 => Some(Self::Absent),
            1 => Some(Self::Live),
            2 => Some(Self::Stale),
            3 => Some(Self::OutOfRange),
            _ => None,
        }
    }
}

/// A part that boards know how to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SensorPart {
    /// None.
    None,
    /// ADS1115 of Texas Instruments: an analogue-to-digital converter, with a pressure transducer.
    Ads1115,
    /// BMI323 of Bosch: accelerometer and gyroscope.
    Bmi323,
    /// What this version of the crate does not know, by its number: 3 to 254.
    Other(u8),
}

impl SensorPart {
    const fn number(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Ads1115 => 1,
            Self::Bmi323 => 2,
            Self::Other(number) => number,
        }
    }

    const fn of_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::None),
            1 => Some(Self::Ads1115),
            2 => Some(Self::Bmi323),
            3..=254 => Some(Self::Other(number)),
            255 => None,
        }
    }
}

impl fmt::Display for SensorPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Ads1115 => f.write_str("ADS1115"),
            Self::Bmi323 => f.write_str("BMI323"),
            Self::Other(number) => write!(f, "unknown part {number}"),
        }
    }
}

/// What is on a board's I2C connector: page 30, entry 0.
///
/// Words: of the supply pressure and then of the IMU 256 x state + part; errors and recoveries
/// modulo 1024.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SensorStatus {
    /// What measures the supply pressure.
    pub supply: SensorPart,
    /// How it is.
    pub supply_state: SensorState,
    /// What measures acceleration and angular rate.
    pub imu: SensorPart,
    /// How it is.
    pub imu_state: SensorState,
    /// Transfers that failed with a part that had been found, and readings that made no sense,
    /// modulo 1024.
    pub errors: u16,
    /// Times that the board freed the I2C lines because something held them, modulo 1024.
    pub recoveries: u16,
}

impl SensorStatus {
    /// Errors and recoveries are sent modulo this.
    pub const COUNT_MODULUS: u16 = 1_024;
    /// What boards say that have found nothing.
    pub const NONE: Self = Self {
        supply: SensorPart::None,
        supply_state: SensorState::Absent,
        imu: SensorPart::None,
        imu_state: SensorState::Absent,
        errors: 0,
        recoveries: 0,
    };

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        let sensor = |part: SensorPart, state: SensorState| (state as u16) << 8 | u16::from(part.number());
        [
            sensor(self.supply, self.supply_state),
            sensor(self.imu, self.imu_state),
            self.errors % Self::COUNT_MODULUS,
            self.recoveries % Self::COUNT_MODULUS,
        ]
        .map(Counts::saturating)
    }

    /// From a page answer; `None` if a word stands for nothing.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [supply, imu, errors, recoveries] = entry.map(Counts::get);
        let part = |word: u16| SensorPart::of_number(word.to_le_bytes()[0]);
        let state = |word: u16| SensorState::of_number(word >> 8);
        Some(Self {
            supply: part(supply)?,
            supply_state: state(supply)?,
            imu: part(imu)?,
            imu_state: state(imu)?,
            errors,
            recoveries,
        })
    }
}
