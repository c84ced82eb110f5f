//! What a board knows of its own electronics: page 31.

use super::{Entry, NO_SUCH_ENTRY};
use crate::Counts;

/// A temperature in steps of 0.2 degrees Celsius, from -50 to 154.4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Temperature(u16);

/// A voltage in steps of 10 mV, from 0 to 10.22 V.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Voltage(u16);

/// What a word holds where there is no value.
const NONE: u16 = Counts::MAX.get();
const STEPS_MAX: i32 = NONE as i32 - 1;

const fn clamped(steps: i32) -> u16 {
    if steps < 0 {
        0
    } else if steps > STEPS_MAX {
        STEPS_MAX as u16
    } else {
        steps as u16
    }
}

impl Temperature {
    /// Steps in 1 K.
    pub const STEPS_PER_K: i32 = 5;
    /// The lowest one, degrees Celsius.
    pub const MIN_CELSIUS: i32 = -50;

    /// From steps above [`MIN_CELSIUS`](Self::MIN_CELSIUS); what lies beyond the range becomes its
    /// end.
    pub const fn from_steps(steps: i32) -> Self {
        Self(clamped(steps))
    }

    /// Degrees Celsius.
    pub fn celsius(self) -> f64 {
        f64::from(i32::from(self.0) + Self::STEPS_PER_K * Self::MIN_CELSIUS) / f64::from(Self::STEPS_PER_K)
    }
}

impl Voltage {
    const UV_PER_STEP: i32 = 10_000;

    /// From uV, to the nearest step; what lies beyond the range becomes its end.
    pub const fn from_uv(uv: i32) -> Self {
        // Half a step more could be beyond 32 bits.
        Self(clamped(uv.saturating_add(Self::UV_PER_STEP / 2).div_euclid(Self::UV_PER_STEP)))
    }

    /// V.
    pub fn volts(self) -> f64 {
        f64::from(self.0) / 100.0
    }
}

/// Temperature of the chip and voltage of the I2C connector's 5 V rail: page 31, entry 0.
///
/// Words: the temperature in steps of 0.2 K above -50 degrees Celsius; the voltage in steps of 10
/// mV; 1023 where there is none. Then two that boards of today send as 0, and hosts do not look at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Electronics {
    /// By the chip's own sensor, a mean of a second; `None` in the first second.
    pub chip_temperature: Option<Temperature>,
    /// What the supply pressure's transducer is fed with, at its converter; `None` where there is
    /// no converter, or none that answers.
    pub rail_voltage: Option<Voltage>,
}

impl Electronics {
    /// Where neither is known.
    pub const NONE: Self = Self { chip_temperature: None, rail_voltage: None };

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        let temperature = self.chip_temperature.map_or(NONE, |temperature| temperature.0);
        let voltage = self.rail_voltage.map_or(NONE, |voltage| voltage.0);
        [temperature, voltage, 0, 0].map(Counts::saturating)
    }

    /// From a page answer; `None` if it says that there is no such entry.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        if entry == NO_SUCH_ENTRY {
            return None;
        }
        let [temperature, voltage, ..] = entry.map(|word| Some(word.get()).filter(|&word| word != NONE));
        Some(Self { chip_temperature: temperature.map(Temperature), rail_voltage: voltage.map(Voltage) })
    }
}
