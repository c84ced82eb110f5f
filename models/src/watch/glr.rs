//! Has it changed? The generalised likelihood ratio over all moments at which a change may have
//! begun, for every direction.

use super::baseline::Baseline;
use super::direction::Direction;
use super::history::{History, Moment};

/// Statistic at which a change is said. Chosen on rigs that the published rates were not measured
/// on (docs/watch.md).
pub const THRESHOLD: f64 = 40.0;
/// Blocks that a change lasts at least before it is said.
const LEAST_BLOCKS: usize = 3;
/// By how much the statistic of a moment may be less than the largest, for a 95 % interval of the
/// moment.
const INTERVAL: f64 = 3.84;

/// The direction that stands out most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alarm {
    /// Number among the channel's directions.
    pub direction: usize,
    /// The statistic.
    pub statistic: f64,
    /// When it began, s.
    pub since_s: f64,
    /// 95 % interval of that, s.
    pub since_ci95_s: [f64; 2],
}

/// The largest statistic of directions whose size is worth a word and possible.
pub fn largest(history: &History, baseline: &Baseline, directions: &[Direction]) -> Option<Alarm> {
    let now = history.now();
    let mut best: Option<Alarm> = None;
    for (k, direction) in directions.iter().enumerate() {
        let of = |Moment { sums, known }: &Moment| {
            let deviation = now.deviation[k] - sums.deviation[k];
            let weight = now.weight[k] - sums.weight[k];
            (known[k].statistic(deviation, weight), known[k].size(deviation, weight))
        };
        let statistics = || history.moments(LEAST_BLOCKS).map(|moment| (of(moment), moment.sums.t_s));
        let counts = |size: f64| direction.is_worth(size) && !direction.is_beyond(size, baseline.usual(k));
        let worth = statistics().filter(|((_, size), _)| counts(*size));
        let Some(((statistic, _), since_s)) = worth.max_by(|a, b| a.0.0.total_cmp(&b.0.0)) else { continue };
        if best.as_ref().is_some_and(|best| best.statistic >= statistic) {
            continue;
        }
        let near = statistics().filter(|((s, _), _)| *s >= statistic - INTERVAL).map(|(_, t_s)| t_s);
        let since_ci95_s = near.fold([since_s; 2], |[low, high], t_s| [low.min(t_s), high.max(t_s)]);
        best = Some(Alarm { direction: k, statistic, since_s, since_ci95_s });
    }
    best
}
