//! Why a sample is not used.

use std::ops::BitOr;

use serde::{Deserialize, Serialize};

/// Reasons, one bit each, for which one row of one channel is not taken at face value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Flags(u8);

impl Flags {
    /// Nothing is wrong with this sample.
    pub const NONE: Self = Self(0);
    /// The pressure cell is empty or not a finite number.
    pub const PRESSURE_MISSING: Self = Self(1);
    /// The pressure repeats itself exactly while the drive or the command moves.
    pub const STUCK: Self = Self(1 << 1);
    /// The pressure is at a limit of the sensor.
    pub const SATURATED: Self = Self(1 << 2);
    /// An input (command, drive, joint, supply) was missing here and its last value was held.
    pub const INPUT_HELD: Self = Self(1 << 3);
    /// An input was missing for too long to be held: no simulation passes here.
    pub const INPUT_MISSING: Self = Self(1 << 4);

    /// Whether all bits of `other` are set here.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Sets the bits of `other`.
    pub const fn insert(&mut self, other: Self) {
        self.0 |= other.0;
    }

    /// Clears the bits of `other`.
    pub const fn remove(&mut self, other: Self) {
        self.0 &= !other.0;
    }

    /// Whether the measured pressure may be compared with a simulated one.
    #[must_use]
    pub const fn pressure_usable(self) -> bool {
        const UNUSABLE: u8 = Flags::PRESSURE_MISSING.0 | Flags::STUCK.0 | Flags::SATURATED.0;
        self.0 & UNUSABLE == 0
    }
}

impl BitOr for Flags {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_inputs_leave_the_pressure_usable() {
        assert!(Flags::NONE.pressure_usable());
        assert!(Flags::INPUT_HELD.pressure_usable());
        assert!(!(Flags::INPUT_HELD | Flags::STUCK).pressure_usable());
        assert!((Flags::STUCK | Flags::SATURATED).contains(Flags::SATURATED));
        assert!(!Flags::STUCK.contains(Flags::SATURATED));
    }
}
