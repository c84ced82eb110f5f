//! Many starts, so that a local minimum is not taken for the best.

use crate::parallel;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rand::{Rng, RngExt, SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64Mcg;

use super::Objective;
use super::levenberg::{Ending, Minimum, Stopping, minimise};

/// Relative excess of the cost up to which a start counts as having reached the best minimum.
const SAME_MINIMUM: f64 = 1e-4;

/// Progress of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Searches done.
    pub done: usize,
    /// Searches in all.
    pub total: usize,
}

/// How a caller watches and stops a fit.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Called after each search, from any thread.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Set to stop: searches under way end after their current evaluation, those to come are left
    /// out, but for the one from the nominal values, and the best so far is kept.
    pub cancel: &'a AtomicBool,
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

impl Control<'_> {
    pub(super) fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

impl Control<'static> {
    /// Nobody watches.
    #[must_use]
    pub fn none() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { progress: &|_| {}, cancel: &NEVER }
    }
}

/// How one start ended.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct StartOutcome {
    /// Sum of squares.
    pub cost: f64,
    /// Evaluations of the normal equations.
    pub evaluations: usize,
    /// Why it ended.
    pub ending: Ending,
}

/// The best of all starts.
#[derive(Debug, Clone)]
pub struct Best {
    /// The minimum with the least cost.
    pub minimum: Minimum,
    /// Every start that was made, in order.
    pub starts: Vec<StartOutcome>,
}

impl Best {
    /// How many starts reached the best minimum.
    #[must_use]
    pub fn agreeing(&self) -> usize {
        let limit = self.minimum.normal.cost * (1.0 + SAME_MINIMUM);
        self.starts.iter().filter(|start| start.cost <= limit).count()
    }
}

/// Start points: the nominal one, then a Latin hypercube over the first `spread` coordinates (the
/// others keep their nominal values). It reaches from bound to bound and is denser near the nominal
/// values: half of the starts lie within a quarter of the way to a bound. Depends on nothing but
/// the arguments.
#[must_use]
pub fn start_points(
    nominal: &[f64],
    bounds: &[(f64, f64)],
    spread: usize,
    starts: usize,
    seed: u64,
) -> Vec<Vec<f64>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let others = starts.saturating_sub(1);
    let mut points = vec![nominal.to_vec(); starts];
    for (i, &(low, high)) in bounds.iter().enumerate().take(spread) {
        if low >= high {
            continue;
        }
        for (slot, point) in hypercube_column(&mut random, others).zip(&mut points[1.min(starts)..]) {
            let away = 2.0 * slot - 1.0;
            let reach = if away < 0.0 { nominal[i] - low } else { high - nominal[i] };
            point[i] = nominal[i] + away * away.abs() * reach;
        }
    }
    points
}

/// `count` numbers between 0 and 1, one from each of `count` equal intervals, in random order.
#[allow(clippy::cast_precision_loss)] // a few starts
fn hypercube_column(random: &mut impl Rng, count: usize) -> impl Iterator<Item = f64> {
    let mut slots: Vec<f64> =
        (0..count).map(|slot| (slot as f64 + random.random::<f64>()) / count as f64).collect();
    slots.shuffle(random);
    slots.into_iter()
}

/// A start at which the simulation runs away is moved halfway towards the nominal one until it does
/// not.
fn sound_start(objective: &(impl Objective + ?Sized), start: &[f64], control: Control<'_>) -> Vec<f64> {
    const HALVINGS: usize = 10;
    let nominal = objective.nominal();
    let mut point = start.to_vec();
    for _ in 0..HALVINGS {
        if control.cancelled() || objective.normal(&point).is_finite() {
            break;
        }
        for (x, nominal) in point.iter_mut().zip(&nominal) {
            *x = 0.5 * (*x + nominal);
        }
    }
    point
}

/// One search of the batch: which problem, from where.
struct Search<'a, O: ?Sized> {
    problem: usize,
    objective: &'a O,
    start: Vec<f64>,
    /// Made even of a fit that was cancelled before: one evaluation, so that there is a result.
    nominal: bool,
}

/// Fits every problem from `starts` points each, all searches in parallel. `spread` is the number
/// of coordinates that starts are spread over, per problem. The result does not depend on the
/// number of threads; only a cancelled fit depends on when it was cancelled.
pub fn best_of_starts<O: Objective + ?Sized>(
    objectives: &[(&O, usize)],
    starts: usize,
    seed: u64,
    stopping: &Stopping,
    control: Control<'_>,
) -> Vec<Best> {
    let searches: Vec<Search<'_, O>> = objectives
        .iter()
        .enumerate()
        .flat_map(|(problem, &(objective, spread))| {
            start_points(&objective.nominal(), &objective.bounds(), spread, starts.max(1), seed)
                .into_iter()
                .enumerate()
                .map(move |(i, start)| Search { problem, objective, start, nominal: i == 0 })
        })
        .collect();
    let (done, total) = (AtomicUsize::new(0), searches.len());
    let minima: Vec<Option<(usize, Minimum)>> = parallel::map(searches.iter(), |search| {
        if control.cancelled() && !search.nominal {
            return None;
        }
        let bounds = search.objective.bounds();
        let start = sound_start(search.objective, &search.start, control);
        let minimum = minimise(search.objective, &bounds, &start, stopping, control.cancel);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        (control.progress)(Progress { done, total });
        Some((search.problem, minimum))
    });
    let mut best: Vec<Option<Best>> = vec![None; objectives.len()];
    for (problem, minimum) in minima.into_iter().flatten() {
        let outcome = StartOutcome {
            cost: minimum.normal.cost,
            evaluations: minimum.evaluations,
            ending: minimum.ending,
        };
        match &mut best[problem] {
            None => best[problem] = Some(Best { minimum, starts: vec![outcome] }),
            Some(best) => {
                best.starts.push(outcome);
                // Strictly less, and not a number loses: ties go to the earlier start.
                if outcome.cost < best.minimum.normal.cost || best.minimum.normal.cost.is_nan() {
                    best.minimum = minimum;
                }
            }
        }
    }
    best.into_iter().flatten().collect()
}
