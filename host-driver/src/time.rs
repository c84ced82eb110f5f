//! From a user's durations to the ns that the bus thread counts in.

use std::time::Duration;

/// 73 years. Time stamps and a few such durations can be added up without an overflow.
const LONGEST_NS: u64 = u64::MAX / 8;

/// `duration` in ns, at most 73 years.
pub(crate) const fn saturating_ns(duration: Duration) -> u64 {
    let ns = duration.as_nanos();
    if ns > LONGEST_NS as u128 { LONGEST_NS } else { ns as u64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_durations_do_not_wrap_around() {
        assert_eq!(saturating_ns(Duration::from_micros(2_200)), 2_200_000);
        // 2^64 ns are 584 years: cut off, these would be 1 ns.
        let wrapping = Duration::new(18_446_744_073, 709_551_617);
        for long in [wrapping, Duration::MAX] {
            assert_eq!(saturating_ns(long), LONGEST_NS);
        }
    }
}
