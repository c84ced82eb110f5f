//! Times of rows and board loops as integers, so that nothing drifts.

/// The `k`-th multiple of a period given as a rate, ns, rounded.
pub fn instant_ns(k: u64, rate_hz: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, below 1e14 ns by validation"
    )]
    let ns = (k as f64 * 1e9 / rate_hz).round() as u64;
    ns
}

/// Board loops: the `k`-th runs at `(k + phase) / rate`.
#[derive(Debug, Clone)]
pub struct LoopClock {
    rate_hz: f64,
    offset_ns: u64,
    next: u64,
}

impl LoopClock {
    /// `phase` in loops, 0 to 1.
    pub fn new(rate_hz: f64, phase: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most one loop, 2e7 ns"
        )]
        let offset_ns = (phase * 1e9 / rate_hz).round() as u64;
        Self { rate_hz, offset_ns, next: 0 }
    }

    /// The next loop's time if it is not after `time_ns`; then it is taken.
    pub fn next_until(&mut self, time_ns: u64) -> Option<u64> {
        let at = self.offset_ns + instant_ns(self.next, self.rate_hz);
        (at <= time_ns).then(|| {
            self.next += 1;
            at
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_do_not_drift() {
        assert_eq!(instant_ns(3, 3.0), 1_000_000_000);
        assert_eq!(instant_ns(1, 3.0), 333_333_333);
    }

    #[test]
    fn loops_come_once_each() {
        let mut clock = LoopClock::new(1000.0, 0.5);
        assert_eq!(clock.next_until(400_000), None);
        assert_eq!(clock.next_until(1_500_000), Some(500_000));
        assert_eq!(clock.next_until(1_500_000), Some(1_500_000));
        assert_eq!(clock.next_until(1_500_000), None);
    }
}
