use super::super::Entry;
use super::SensorState;
use crate::Counts;

/// A pressure above that of the atmosphere, in steps of 10 Pa, from -5,242,880 to 5,242,870 Pa.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct GaugePressure(i32);

impl GaugePressure {
    const PA_PER_STEP: i32 = 10;
    const ZERO: i32 = 1 << 19;

    /// From Pa, rounded down to a step; what lies beyond the range becomes its end.
    pub const fn from_pa(pa: i32) -> Self {
        let steps = pa.div_euclid(Self::PA_PER_STEP);
        Self(if steps < -Self::ZERO {
            -Self::ZERO
        } else if steps >= Self::ZERO {
            Self::ZERO - 1
        } else {
            steps
        })
    }

    /// Pa.
    pub const fn pa(self) -> i32 {
        self.0 * Self::PA_PER_STEP
    }

    /// kPa.
    pub fn kpa(self) -> f64 {
        f64::from(self.0) / 100.0
    }
}

/// The supply pressure: page 30, entry 1.
///
/// Words: age in ms (1023: that or more), state, then in steps of 10 Pa the gauge pressure + 2^19,
/// 10 bits each, most significant first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SupplyReading {
    /// Whether the rest can be relied on.
    pub state: SensorState,
    /// How long ago it was measured, ms; 1023 stands for that or more, and for never.
    pub age_ms: u16,
    /// What was measured last; 0 if nothing ever was.
    pub pressure: GaugePressure,
}

impl SupplyReading {
    /// The largest age.
    pub const AGE_MAX_MS: u16 = Counts::MAX.get();
    /// Of a board that has no such part.
    pub const ABSENT: Self =
        Self { state: SensorState::Absent, age_ms: Self::AGE_MAX_MS, pressure: GaugePressure(0) };

    /// kPa above the atmosphere, if it is live.
    pub fn live_kpa(self) -> Option<f64> {
        (self.state == SensorState::Live).then(|| self.pressure.kpa())
    }

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        let steps = (self.pressure.0 + GaugePressure::ZERO).unsigned_abs();
        [self.age_ms, self.state as u16, (steps >> 10) as u16, (steps & 0x3FF) as u16].map(Counts::saturating)
    }

    /// From a page answer; `None` if a word stands for nothing.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [age_ms, state, high, low] = entry.map(Counts::get);
        let steps = i32::from(high) << 10 | i32::from(low);
        let pressure = GaugePressure(steps - GaugePressure::ZERO);
        SensorState::of_number(state).map(|state| Self { state, age_ms, pressure })
    }
}
