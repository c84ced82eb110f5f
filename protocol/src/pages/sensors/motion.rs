use super::super::Entry;
use super::SensorState;
use crate::Counts;

/// Three axes of an IMU with one bit that says whether they are live, in 40 bits: entries 2 and 3
/// of page 30.
///
/// From the most significant bit: 1 if live; then x, y and z, 13 bits each, + 4095. Without a part
/// all three are 8191, and the first bit is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Axes {
    live: bool,
    /// `None` without a part.
    steps: Option<[i16; 3]>,
}

const AXIS_BITS: u32 = 13;
const AXIS_MAX: i16 = 4_095;
const NO_AXIS: u64 = (1 << AXIS_BITS) - 1;

impl Axes {
    fn new(steps: [i16; 3], live: bool) -> Self {
        Self { live, steps: Some(steps.map(|axis| axis.clamp(-AXIS_MAX, AXIS_MAX))) }
    }

    const fn state(self) -> SensorState {
        match self {
            Self { steps: None, .. } => SensorState::Absent,
            Self { live: true, .. } => SensorState::Live,
            Self { live: false, .. } => SensorState::Stale,
        }
    }

    fn to_entry(self) -> Entry {
        let number = match self.steps {
            None => NO_AXIS << (2 * AXIS_BITS) | NO_AXIS << AXIS_BITS | NO_AXIS,
            Some(steps) => steps.iter().fold(u64::from(self.live), |number, axis| {
                number << AXIS_BITS | u64::from((axis + AXIS_MAX).unsigned_abs())
            }),
        };
        [30, 20, 10, 0].map(|shift| Counts::saturating((number >> shift) as u16 & Counts::MAX.get()))
    }

    fn from_entry(entry: Entry) -> Option<Self> {
        let number = entry.iter().fold(0, |number, word| number << 10 | u64::from(word.get()));
        let live = number >> (3 * AXIS_BITS) == 1;
        let raw = [2, 1, 0].map(|axis| number >> (axis * AXIS_BITS) & NO_AXIS);
        if raw.contains(&NO_AXIS) {
            return (!live && raw == [NO_AXIS; 3]).then_some(Self { live, steps: None });
        }
        Some(Self { live, steps: Some(raw.map(|axis| axis as i16 - AXIS_MAX)) })
    }
}

/// Acceleration, gravity included, along the part's axes: page 30, entry 2.
///
/// The words' 40 bits, from the most significant one: 1 if live; then x, y and z in steps of 0.01
/// m/s^2 + 4095, 13 bits each. Without a part all three are 8191 and the first bit is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Acceleration(Axes);

/// Angular rate about the part's axes: page 30, entry 3.
///
/// The words' 40 bits, from the most significant one: 1 if live; then x, y and z in steps of 1/400
/// rad/s + 4095, 13 bits each. Without a part all three are 8191 and the first bit is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct AngularRate(Axes);

impl Acceleration {
    /// Steps in 1 m/s^2.
    pub const STEPS_PER_M_PER_S2: i16 = 100;
    /// Of a board that has no such part.
    pub const ABSENT: Self = Self(Axes { live: false, steps: None });

    /// From x, y and z in steps of 0.01 m/s^2; what lies beyond 4095 (40.95 m/s^2) becomes that.
    pub fn from_steps(steps: [i16; 3], live: bool) -> Self {
        Self(Axes::new(steps, live))
    }

    /// Absent, live or stale.
    pub const fn state(self) -> SensorState {
        self.0.state()
    }

    /// x, y and z of the last reading, m/s^2, live or not; `None` without a part.
    pub fn m_per_s2(self) -> Option<[f64; 3]> {
        self.0.steps.map(|steps| steps.map(|axis| f64::from(axis) / f64::from(Self::STEPS_PER_M_PER_S2)))
    }

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        self.0.to_entry()
    }

    /// From a page answer; `None` if it is none.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        Axes::from_entry(entry).map(Self)
    }
}

impl AngularRate {
    /// Steps in 1 rad/s.
    pub const STEPS_PER_RAD_PER_S: i16 = 400;
    /// Of a board that has no such part.
    pub const ABSENT: Self = Self(Axes { live: false, steps: None });

    /// From x, y and z in steps of 1/400 rad/s; what lies beyond 4095 (10.24 rad/s) becomes that.
    pub fn from_steps(steps: [i16; 3], live: bool) -> Self {
        Self(Axes::new(steps, live))
    }

    /// Absent, live or stale.
    pub const fn state(self) -> SensorState {
        self.0.state()
    }

    /// x, y and z of the last reading, rad/s, live or not; `None` without a part.
    pub fn rad_per_s(self) -> Option<[f64; 3]> {
        self.0.steps.map(|steps| steps.map(|axis| f64::from(axis) / f64::from(Self::STEPS_PER_RAD_PER_S)))
    }

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        self.0.to_entry()
    }

    /// From a page answer; `None` if it is none.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        Axes::from_entry(entry).map(Self)
    }
}
