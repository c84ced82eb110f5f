/// A time on the board's clock, in microseconds since power-up, or the distance between two such
/// times.
///
/// The caller's clock must not run backwards. If it does, the distance to a later time counts as 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Micros(u64);

impl Micros {
    /// Power-up, or no time at all.
    pub const ZERO: Self = Self(0);

    /// From microseconds.
    pub const fn new(micros: u64) -> Self {
        Self(micros)
    }

    /// From milliseconds.
    pub const fn from_millis(millis: u64) -> Self {
        Self(millis.saturating_mul(1_000))
    }

    /// Microseconds.
    pub const fn get(self) -> u64 {
        self.0
    }

    /// Time since `earlier`; zero if that lies ahead.
    pub const fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }

    /// The time `distance` later.
    pub const fn after(self, distance: Self) -> Self {
        Self(self.0.saturating_add(distance.0))
    }

    /// The time whose low 32 bits are `stamp` and which is nearest to `self`.
    ///
    /// For hardware that stamps bytes with the low word of the clock: right as long as the stamp is
    /// read within 35 minutes. A stamp may be a little ahead, where the clock was read before the
    /// stamp was made.
    pub const fn of_stamp(self, stamp: u32) -> Self {
        let ahead = stamp.wrapping_sub(self.0 as u32).cast_signed();
        Self(self.0.saturating_add_signed(ahead as i64))
    }
}

#[cfg(test)]
mod tests {
    use super::Micros;

    #[test]
    fn a_stamp_finds_its_time_across_the_wrap() {
        let now = Micros::new(0x1_0000_0005);
        assert_eq!(now.of_stamp(5), now);
        assert_eq!(now.of_stamp(2), Micros::new(0x1_0000_0002));
        assert_eq!(now.of_stamp(0xFFFF_FFFE), Micros::new(0xFFFF_FFFE));
        // Made just after the clock was read.
        assert_eq!(now.of_stamp(7), Micros::new(0x1_0000_0007));
        assert_eq!(Micros::new(0xFFFF_FFFF).of_stamp(1), Micros::new(0x1_0000_0001));
    }

    #[test]
    fn a_clock_that_runs_backwards_gives_no_time() {
        assert_eq!(Micros::new(3).since(Micros::new(5)), Micros::ZERO);
        assert_eq!(Micros::new(u64::MAX).after(Micros::from_millis(u64::MAX)), Micros::new(u64::MAX));
    }
}
