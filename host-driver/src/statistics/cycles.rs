use super::{CycleTimes, Durations, LoopRate};

/// Periods of the cycles, as they pass.
#[derive(Debug, Clone)]
pub(crate) struct CycleStatistics {
    durations: Durations,
    /// Periods, and their sum, ns.
    periods: u64,
    total_ns: u64,
    /// Cycles without a period: those that ended the run, and the time from their start to it, ns.
    last: (u64, u64),
    /// Welford's recurrence over the rates 1/period, Hz: its mean and sum of squared deviations.
    rate_mean: f64,
    rate_squares: f64,
}

impl CycleStatistics {
    pub(crate) fn new() -> Self {
        Self {
            durations: Durations::new(),
            periods: 0,
            total_ns: 0,
            last: (0, 0),
            rate_mean: 0.0,
            rate_squares: 0.0,
        }
    }

    /// A cycle took `period_ns` from its start to the next one's.
    pub(crate) fn add(&mut self, period_ns: u64) {
        let period_ns = period_ns.max(1);
        self.durations.add(period_ns);
        self.periods += 1;
        self.total_ns += period_ns;
        let rate = 1e9 / period_ns as f64;
        let before = rate - self.rate_mean;
        self.rate_mean += before / self.periods as f64;
        self.rate_squares += before * (rate - self.rate_mean);
    }

    /// The last cycle took `took_ns`, and the next one would not have started then: it counts, but
    /// it has no period.
    pub(crate) fn end(&mut self, took_ns: u64) {
        self.last.0 += 1;
        self.last.1 += took_ns;
    }

    pub(crate) fn count(&self) -> u64 {
        self.periods + self.last.0
    }

    pub(crate) fn seconds(&self) -> f64 {
        (self.total_ns + self.last.1) as f64 * 1e-9
    }

    pub(crate) fn rate(&self) -> LoopRate {
        if self.periods == 0 {
            return LoopRate::default();
        }
        let std = if self.periods < 2 { 0.0 } else { (self.rate_squares / (self.periods - 1) as f64).sqrt() };
        LoopRate {
            mean: self.periods as f64 / (self.total_ns as f64 * 1e-9),
            std,
            min: 1e9 / self.durations.longest_ns() as f64,
        }
    }

    pub(crate) fn times(&self) -> CycleTimes {
        self.durations.quantiles()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, relative: f64) -> bool {
        (a - b).abs() <= relative * b.abs()
    }

    #[test]
    fn figures_of_a_known_set() {
        let mut cycles = CycleStatistics::new();
        // 98 periods of 1 ms, one of 2 ms, one of 10 ms.
        (0..98).for_each(|_| cycles.add(1_000_000));
        cycles.add(2_000_000);
        cycles.add(10_000_000);
        let rate = cycles.rate();
        assert!(close(rate.mean, 100.0 / 0.110, 1e-12), "{rate:?}");
        assert!(close(rate.min, 100.0, 1e-12), "{rate:?}");
        // Rates: 98 x 1000, 500, 100 Hz: mean 986, sum of squares 98 x 14^2 + 486^2 + 886^2.
        let expected = ((98.0 * 196.0 + 486.0f64.powi(2) + 886.0f64.powi(2)) / 99.0).sqrt();
        assert!(close(rate.std, expected, 1e-9), "{rate:?}, expected {expected}");
        let times = cycles.times();
        assert!(close(times.p50, 1_000.0, 1e-3) && close(times.p99, 2_000.0, 1e-3), "{times:?}");
        assert!(close(times.p999, 10_000.0, 1e-3) && close(times.max, 10_000.0, 1e-12), "{times:?}");
    }

    #[test]
    fn a_cycle_without_a_period_counts_and_changes_no_figure() {
        let mut cycles = CycleStatistics::new();
        (0..20).for_each(|_| cycles.add(50_000_000));
        let before = (cycles.rate(), cycles.times());
        cycles.end(400_000);
        assert_eq!((cycles.rate(), cycles.times()), before);
        assert!(close(before.0.mean, 20.0, 1e-12) && before.0.std.abs() < 1e-9, "{before:?}");
        assert_eq!(cycles.count(), 21);
        assert!(close(cycles.seconds(), 1.0004, 1e-12), "{}", cycles.seconds());
    }

    #[test]
    fn nothing_is_nothing() {
        assert_eq!(CycleStatistics::new().rate(), LoopRate::default());
    }
}
