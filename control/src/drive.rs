use core::fmt;

/// How hard a valve is driven, in the original's counts: -400 (vent fully) to 400 (fill fully).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ValveDrive(i16);

impl ValveDrive {
    /// Drive counts at full drive, from the original.
    pub const FULL: i16 = 400;
    /// Fill as fast as possible.
    pub const FULL_FILL: Self = Self(Self::FULL);
    /// Vent as fast as possible: the safe state.
    pub const FULL_VENT: Self = Self(-Self::FULL);

    /// The nearest drive within -400 to 400.
    pub const fn saturating(counts: i32) -> Self {
        const FULL: i32 = ValveDrive::FULL as i32;
        Self(if counts > FULL {
            ValveDrive::FULL
        } else if counts < -FULL {
            -ValveDrive::FULL
        } else {
            counts as i16
        })
    }

    /// Drive counts, -400 to 400.
    pub const fn get(self) -> i16 {
        self.0
    }
}

impl fmt::Display for ValveDrive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:+} of {}", self.0, Self::FULL)
    }
}

/// Which way a valve's driver is polarised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Supply to chamber: DIR low.
    Fill,
    /// Chamber to atmosphere: DIR high.
    Vent,
}

/// The levels of one valve's two driver pins, as the original drives its A4990.
///
/// The driver puts (not DIR) - PWM across the valve's coil. So the PWM pin is inverted while
/// filling: its duty falls from 255 to 0 as the drive rises. **Both pins low means full fill**; a
/// board needs a pull-up on DIR at least, so that a chip in reset does not fill its chambers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct DirPwm {
    /// Level of the DIR pin.
    pub direction: Direction,
    /// Share of the period in which the PWM pin is high, in 1/255.
    pub duty: u8,
}

impl DirPwm {
    /// Duty of a pin that is always high.
    pub const DUTY_MAX: u8 = 255;
    /// Full vent, both pins high: what firmware sets before anything else, and in a panic.
    pub const SAFE: Self = Self { direction: Direction::Vent, duty: Self::DUTY_MAX };

    /// Whether the DIR pin is high.
    pub const fn dir_is_high(self) -> bool {
        matches!(self.direction, Direction::Vent)
    }

    /// Compare value of a timer that counts from 0 to `top` and holds the pin high while the count
    /// is below it.
    ///
    /// `top` is at most 65534, so that `top` + 1 (always high) fits; with 65535 a duty of 255 has
    /// one low tick.
    pub const fn compare(self, top: u16) -> u16 {
        const MAX: u32 = DirPwm::DUTY_MAX as u32;
        let period = top as u32 + 1;
        let compare = (self.duty as u32 * period + MAX / 2) / MAX;
        if compare > u16::MAX as u32 { u16::MAX } else { compare as u16 }
    }

    /// Mean voltage across the valve's coil in 1/255 of the supply: 255 fills fully, -255 vents
    /// fully.
    pub const fn coil(self) -> i16 {
        match self.direction {
            Direction::Fill => (Self::DUTY_MAX - self.duty) as i16,
            Direction::Vent => -(self.duty as i16),
        }
    }
}

impl From<ValveDrive> for DirPwm {
    /// The original's integer formulas: 51 |drive| / 80, cut off, which is 255 at 400.
    fn from(drive: ValveDrive) -> Self {
        let magnitude = (51 * u32::from(drive.0.unsigned_abs()) / 80) as u8;
        if drive.0 > 0 {
            Self { direction: Direction::Fill, duty: Self::DUTY_MAX - magnitude }
        } else {
            Self { direction: Direction::Vent, duty: magnitude }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Direction::{Fill, Vent};

    #[test]
    fn the_originals_pin_levels() {
        let table = [
            (400, Fill, 0),
            (399, Fill, 1),
            (200, Fill, 128),
            (80, Fill, 204),
            (2, Fill, 254),
            (1, Fill, 255),
            (0, Vent, 0),
            (-1, Vent, 0),
            (-2, Vent, 1),
            (-80, Vent, 51),
            (-200, Vent, 127),
            (-399, Vent, 254),
            (-400, Vent, 255),
        ];
        for (drive, direction, duty) in table {
            assert_eq!(DirPwm::from(ValveDrive::saturating(drive)), DirPwm { direction, duty }, "{drive}");
        }
        assert_eq!(DirPwm::from(ValveDrive::FULL_VENT), DirPwm::SAFE);
    }

    #[test]
    fn the_coil_sees_the_drive() {
        let coils: std::vec::Vec<_> =
            (-400..=400).map(|drive| DirPwm::from(ValveDrive::saturating(drive)).coil()).collect();
        assert!(coils.is_sorted());
        assert_eq!((coils[0], coils[400], coils[800]), (-255, 0, 255));
    }

    #[test]
    fn drives_saturate() {
        assert_eq!(ValveDrive::saturating(i32::MAX), ValveDrive::FULL_FILL);
        assert_eq!(ValveDrive::saturating(i32::MIN), ValveDrive::FULL_VENT);
    }

    #[test]
    fn compare_values_reach_both_ends_of_any_timer() {
        for top in [254, 3_983, 65_534] {
            let compare = |duty| DirPwm { direction: Vent, duty }.compare(top);
            assert_eq!((compare(0), compare(255)), (0, top + 1));
        }
        assert_eq!(DirPwm::SAFE.compare(u16::MAX), u16::MAX);
        // 51/255 of 3984 ticks
        assert_eq!(DirPwm { direction: Vent, duty: 51 }.compare(3_983), 797);
    }
}
