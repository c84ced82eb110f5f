//! Virtual time: integer ticks of 8 ns, and exact rates between clocks and ticks.

use std::fmt;
use std::ops::{Add, AddAssign, Mul, Sub};

/// A point in virtual time since power-on of the simulation, or a duration. One tick is 1/125 us (8
/// ns): one processor cycle at the RP2040's usual 125 MHz, 125 ticks a bit at 1 Mbaud.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticks(u64);

impl Ticks {
    /// Time zero, or no duration.
    pub const ZERO: Ticks = Ticks(0);
    /// Later than every time: "no event".
    pub const NEVER: Ticks = Ticks(u64::MAX);
    /// Ticks in a microsecond.
    pub const PER_MICROSECOND: u64 = 125;
    /// Ticks in a second.
    pub const PER_SECOND: u64 = 125_000_000;

    /// From a number of ticks.
    pub const fn new(ticks: u64) -> Ticks {
        Ticks(ticks)
    }

    /// From whole microseconds.
    pub const fn from_micros(micros: u64) -> Ticks {
        Ticks(micros * Self::PER_MICROSECOND)
    }

    /// From whole milliseconds.
    pub const fn from_millis(millis: u64) -> Ticks {
        Ticks(millis * 1000 * Self::PER_MICROSECOND)
    }

    /// The number of ticks.
    pub const fn get(self) -> u64 {
        self.0
    }

    /// The number of microseconds, with the fraction.
    pub fn as_micros(self) -> f64 {
        self.0 as f64 / Self::PER_MICROSECOND as f64
    }

    /// The duration since `earlier`, zero if `earlier` is later.
    pub const fn saturating_sub(self, earlier: Ticks) -> Ticks {
        Ticks(self.0.saturating_sub(earlier.0))
    }
}

impl Add for Ticks {
    type Output = Ticks;
    /// The later time. [`Ticks::NEVER`] stays never.
    fn add(self, duration: Ticks) -> Ticks {
        Ticks(self.0.saturating_add(duration.0))
    }
}

impl AddAssign for Ticks {
    fn add_assign(&mut self, duration: Ticks) {
        *self = *self + duration;
    }
}

impl Sub for Ticks {
    type Output = Ticks;
    fn sub(self, earlier: Ticks) -> Ticks {
        Ticks(self.0 - earlier.0)
    }
}

impl Mul<u64> for Ticks {
    type Output = Ticks;
    fn mul(self, factor: u64) -> Ticks {
        Ticks(self.0.saturating_mul(factor))
    }
}

impl fmt::Display for Ticks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Ticks::NEVER { f.write_str("never") } else { write!(f, "{:.3} us", self.as_micros()) }
    }
}

/// How fast a counter counts, as an exact fraction in lowest terms: `counts` counts in `ticks`
/// ticks.
///
/// Counters are never advanced step by step: their value is computed from the time since they
/// started, so rates that are no whole number of ticks (12 MHz, 48 MHz, fractional dividers) do not
/// drift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rate {
    counts: u64,
    ticks: u64,
}

impl Rate {
    /// A counter whose clock is off.
    pub const STOPPED: Rate = Rate { counts: 0, ticks: 1 };

    /// `numerator / denominator` counts a second.
    pub fn hertz(numerator: u64, denominator: u64) -> Rate {
        if numerator == 0 || denominator == 0 {
            return Rate::STOPPED;
        }
        let ticks = Ticks::PER_SECOND * denominator;
        let common = greatest_common_divisor(numerator, ticks);
        Rate { counts: numerator / common, ticks: ticks / common }
    }

    pub fn is_stopped(self) -> bool {
        self.counts == 0
    }

    /// Whole counts within `duration`.
    pub fn counts_in(self, duration: Ticks) -> u64 {
        if self.counts == 1 {
            return duration.0 / self.ticks;
        }
        to_u64(u128::from(duration.0) * u128::from(self.counts) / u128::from(self.ticks))
    }

    /// The first tick at which `counts` counts are complete; [`Ticks::NEVER`] if the counter is
    /// stopped.
    pub fn ticks_for(self, counts: u64) -> Ticks {
        match self.counts {
            0 => Ticks::NEVER,
            1 => Ticks(counts.saturating_mul(self.ticks)),
            _ => {
                Ticks(to_u64((u128::from(counts) * u128::from(self.ticks)).div_ceil(u128::from(self.counts))))
            }
        }
    }

    /// Numerator (ticks) and denominator (counts) of the period of one count.
    pub fn period(self) -> (u64, u64) {
        (self.ticks, self.counts)
    }
}

fn to_u64(value: u128) -> u64 {
    u64::try_from(value).unwrap_or(u64::MAX)
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_of_48_mhz_is_exact_over_a_day() {
        let rate = Rate::hertz(48_000_000, 1);
        let day = Ticks(86_400 * Ticks::PER_SECOND);
        assert_eq!(rate.counts_in(day), 86_400 * 48_000_000);
        assert_eq!(rate.ticks_for(96), Ticks(250));
        assert_eq!(rate.ticks_for(1), Ticks(3), "2.6 ticks: complete at the third");
    }

    #[test]
    fn a_count_is_complete_at_its_tick_and_not_before() {
        for (numerator, denominator) in
            [(12_000_000, 1), (133_000_000, 1), (125_000_000 * 16, 19), (1_000_000, 1)]
        {
            let rate = Rate::hertz(numerator, denominator);
            for counts in [1, 2, 7, 1000, 12_345_678] {
                let at = rate.ticks_for(counts);
                assert!(rate.counts_in(at) >= counts);
                assert!(rate.counts_in(Ticks(at.0 - 1)) < counts);
            }
        }
    }

    #[test]
    fn a_stopped_counter_never_arrives() {
        assert_eq!(Rate::hertz(0, 1).ticks_for(1), Ticks::NEVER);
        assert_eq!(Rate::STOPPED.counts_in(Ticks(1000)), 0);
    }
}
