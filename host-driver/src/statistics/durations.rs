use super::{CycleTimes, HistogramBin};
use hdrhistogram::Histogram;

/// How often something took how long.
#[derive(Debug, Clone)]
pub(crate) struct Durations {
    histogram: Option<Histogram<u64>>,
    longest_ns: u64,
}

impl Durations {
    /// Longest duration that the histogram resolves, ns; longer ones count as this long in
    /// quantiles and bins only.
    const LONGEST_NS: u64 = 100_000_000_000;
    /// 0.1 %.
    const SIGNIFICANT_FIGURES: u8 = 3;
    /// Finer steps than 0.1 us are below what a clock read costs.
    const FINEST_NS: u64 = 100;
    /// Bins a decade: each is 26 % wider than the one before.
    const BINS_A_DECADE: i32 = 10;

    pub(crate) fn new() -> Self {
        let histogram =
            Histogram::new_with_bounds(Self::FINEST_NS, Self::LONGEST_NS, Self::SIGNIFICANT_FIGURES);
        Self { histogram: histogram.ok(), longest_ns: 0 }
    }

    pub(crate) fn add(&mut self, ns: u64) {
        if let Some(histogram) = &mut self.histogram {
            histogram.saturating_record(ns);
        }
        self.longest_ns = self.longest_ns.max(ns);
    }

    pub(crate) fn longest_ns(&self) -> u64 {
        self.longest_ns
    }

    pub(crate) fn quantiles(&self) -> CycleTimes {
        let quantile = |q| {
            self.histogram.as_ref().map_or(0.0, |h| h.value_at_quantile(q).min(self.longest_ns) as f64 * 1e-3)
        };
        CycleTimes {
            p50: quantile(0.5),
            p99: quantile(0.99),
            p999: quantile(0.999),
            max: self.longest_ns as f64 * 1e-3,
        }
    }

    /// Counts in bins whose edges are evenly spaced on a logarithmic scale, from the first bin that
    /// is not empty to the last.
    pub(crate) fn bins(&self) -> Vec<HistogramBin> {
        let Some(histogram) = self.histogram.as_ref().filter(|histogram| !histogram.is_empty()) else {
            return Vec::new();
        };
        let mut bins: Vec<HistogramBin> = Vec::new();
        for value in histogram.iter_recorded() {
            let us = value.value_iterated_to() as f64 * 1e-3;
            let index = (us.log10() * f64::from(Self::BINS_A_DECADE)).floor() as i32;
            let first = bins.first().map_or(index, |bin| bin.index);
            while first + bins.len() as i32 <= index {
                bins.push(HistogramBin::new(first + bins.len() as i32, Self::BINS_A_DECADE));
            }
            if let Some(bin) = bins.last_mut() {
                bin.count += value.count_at_value();
            }
        }
        bins
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_evenly_spaced_on_a_logarithmic_scale() {
        let mut durations = Durations::new();
        assert!(durations.bins().is_empty());
        // 10 us to 12.59 us is the bin of 10 and 12 us; 15.85 us to 19.95 us that of 16 us; the one
        // between is empty.
        [10_000, 12_000, 12_000, 16_000].into_iter().for_each(|ns| durations.add(ns));
        let bins: Vec<_> =
            durations.bins().iter().map(|bin| (bin.from_us.round(), bin.to_us.round(), bin.count)).collect();
        assert_eq!(bins, [(10.0, 13.0, 3), (13.0, 16.0, 0), (16.0, 20.0, 1)]);
    }

    #[test]
    fn every_duration_is_in_a_bin() {
        let mut durations = Durations::new();
        (0..60).for_each(|k| durations.add(137 << (k / 2)));
        durations.add(u64::MAX);
        assert_eq!(durations.bins().iter().map(|bin| bin.count).sum::<u64>(), 61);
        assert!(durations.bins().windows(2).all(|pair| pair[0].to_us == pair[1].from_us));
    }
}
