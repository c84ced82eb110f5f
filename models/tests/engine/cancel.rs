//! A fit that somebody stops ends soon, with what it has.

use std::sync::atomic::{AtomicBool, Ordering};

use pneudrive_model::fit::{Control, Ending, FitOptions, Problem, Progress, Space, fit_rollouts};
use pneudrive_model::model::{Model, Nonlinear};
use pneudrive_model::rollout::{Chamber, Series};

use crate::engine::support;

fn recording() -> (Chamber<Nonlinear>, Series) {
    let system = Chamber::new(Nonlinear::default());
    let clean = support::clean(&system, &support::TRUTH, 500, 1, 3);
    (system, support::noisy(&clean, 360.0, 4))
}

#[test]
fn a_fit_that_is_stopped_makes_no_more_searches() {
    let (system, series) = recording();
    let problem =
        || Problem { system: &system, series: &series, space: Space::new(system.model.parameters()) };
    let cancel = AtomicBool::new(false);
    let progress = |_: Progress| cancel.store(true, Ordering::Relaxed);
    let control = Control { progress: &progress, cancel: &cancel };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let fits = pool.install(|| fit_rollouts(&[problem(), problem()], &FitOptions::default(), control));
    let fits: Vec<_> = fits.into_iter().map(Result::unwrap).collect();
    // The first search of twenty ends by itself; of the other problem only the nominal values are
    // looked at.
    assert_eq!(fits[0].starts.len(), 1);
    assert_ne!(fits[0].starts[0].ending, Ending::Cancelled);
    assert_eq!(fits[1].starts.len(), 1);
    assert_eq!((fits[1].starts[0].ending, fits[1].starts[0].evaluations), (Ending::Cancelled, 1));
    // What is no minimum has no intervals.
    assert!(
        fits[0].parameters.iter().any(|p| p.ci95.is_some())
            && fits[1].parameters.iter().all(|p| p.ci95.is_none())
    );
    assert!(fits[0].rms < fits[1].rms && fits[1].rms.is_finite());
}
