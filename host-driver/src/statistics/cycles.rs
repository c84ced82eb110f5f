use super::{CycleTimes, Durations, LoopRate};

/// Periods of the cycles, as they pass.
#[derive(Debug, Clone)]
pub(crate) struct CycleStatistics {
    durations: Durations,
    count: u64,
    total_ns: u64,
    /// Welford's recurrence over the rates 1/period, Hz: its mean and sum of squared deviations.
    rate_mean: f64,
    rate_squares: f64,
}

impl CycleStatistics {
    pub(crate) fn new() -> Self {
        Self { durations: Durations::new(), count: 0, total_ns: 0, rate_mean: 0.0, rate_squares: 0.0 }
    }

    /// A cycle took `period_ns` from its start to the next one's.
    pub(crate) fn add(&mut self, period_ns: u64) {
        let period_ns = period_ns.max(1);
        self.durations.add(period_ns);
        self.count += 1;
        self.total_ns += period_ns;
        let rate = 1e9 / period_ns as f64;
        let before = rate - self.rate_mean;
        self.rate_mean += before / self.count as f64;
        self.rate_squares += before * (rate - self.rate_mean);
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    pub(crate) fn seconds(&self) -> f64 {
        self.total_ns as f64 * 1e-9
    }

    pub(crate) fn rate(&self) -> LoopRate {
        if self.count == 0 {
            return LoopRate::default();
        }
        let std = if self.count < 2 { 0.0 } else { (self.rate_squares / (self.count - 1) as f64).sqrt() };
        LoopRate {
            mean: self.count as f64 / self.seconds(),
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
    fn nothing_is_nothing() {
        assert_eq!(CycleStatistics::new().rate(), LoopRate::default());
    }
}
