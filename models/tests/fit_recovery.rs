//! Fits find the parameters the data were made with.

mod support;

use pneudrive_model::fit::{Control, FitOptions, Problem, Space, fit_rollouts};
use pneudrive_model::model::{Model, Nonlinear};
use pneudrive_model::rollout::Chamber;

#[test]
fn twenty_starts_find_the_truth_within_the_intervals() {
    let system = Chamber(Nonlinear::default());
    let series = support::noisy(&support::clean(&system, &support::TRUTH, 20_000, 1, 3), 360.0, 4);
    let space = Space::new(system.0.parameters());
    let problem = Problem { system: &system, series: &series, space };
    let t = std::time::Instant::now();
    let fit = fit_rollouts(&[problem], &FitOptions::default(), Control::none()).remove(0).unwrap();
    println!("{:?}", t.elapsed());
    for (p, truth) in fit.parameters.iter().zip(support::TRUTH) {
        println!("{} {} {:?} {:?} truth {truth}", p.name, p.value, p.standard_error, p.ci95);
    }
    println!("rms {} agreeing {} cond {} bw {} sub {} err {:?} {:?}", fit.rms, fit.agreeing_starts, fit.condition, fit.bandwidth, fit.substeps, fit.integration_error_pa, fit.undetermined);
    for s in &fit.starts { println!("{s:?}"); }
    assert!(fit.agreeing_starts >= 15);
}
