//! How fast the models are evaluated, simulated and fitted. `cargo bench -p pneudrive-model`
//!
//! One thread; counters give evaluations or Runge-Kutta steps per second.

#![allow(clippy::unwrap_used)]

#[allow(dead_code)] // shared with the tests
#[path = "../tests/engine/support.rs"]
mod support;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use pneudrive_model::fit::{Control, FitOptions, Objective, Problem, Space, StartPressure};
use pneudrive_model::fit::{RateObjective, RolloutObjective, fit_rates, fit_rollouts};
use pneudrive_model::model::{Drive, Model, Nonlinear, column};
use pneudrive_model::rollout::{
    BatchColumn, BatchInputs, Chamber, Job, Series, Start, simulate, simulate_batch,
};

const ROWS: usize = 20_000;

fn main() {
    // Everything on one core: throughput per core is what machines can be compared by.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().ok();
    divan::main();
}

fn series(segments: usize) -> Series {
    let clean = support::clean(&Chamber::new(Nonlinear::default()), &support::TRUTH, ROWS, segments, 3);
    support::noisy(&clean, 360.0, 4)
}

/// One evaluation of the right-hand side, valve areas included (a rollout computes those once a
/// sample).
#[divan::bench]
fn evaluate_nonlinear(bencher: Bencher<'_, '_>) {
    let model = Nonlinear::default();
    let inputs = support::inputs(16, 1);
    let coefficients = model.coefficients(&support::TRUTH);
    bencher.counter(ItemsCount::new(16_u32)).bench(|| {
        for row in inputs.chunks_exact(column::COUNT) {
            let row = black_box(row);
            let held = model.hold(&coefficients, row, Drive::recorded(row));
            black_box(model.rate(&coefficients, &held, black_box(3e5)));
        }
    });
}

#[divan::bench]
fn rollout_scalar(bencher: Bencher<'_, '_>) {
    let (system, series) = (Chamber::new(Nonlinear::default()), series(1));
    bencher
        .counter(ItemsCount::new(ROWS))
        .bench(|| simulate(&system, black_box(&support::TRUTH), &series, Start::Measured, 1));
}

fn batch(bencher: Bencher<'_, '_>, rollouts: usize, rows: usize, sensitivities: bool) {
    let system = Chamber::new(Nonlinear::default());
    let inputs = support::inputs(rows, 1);
    let sets: Vec<Vec<f64>> = (0..rollouts)
        .map(|i| support::TRUTH.iter().map(|value| value * (1.0 + 0.001 * i as f64)).collect())
        .collect();
    let jobs: Vec<Job<'_>> = sets.iter().map(|parameters| Job { parameters, start: 2e5 }).collect();
    let columns: Vec<Vec<f64>> = (0..column::COUNT)
        .map(|column| inputs.iter().skip(column).step_by(column::COUNT).copied().collect())
        .collect();
    let columns = columns.iter().map(|values| BatchColumn::per_row(values)).collect();
    let inputs = BatchInputs::new(columns, rollouts, rows).unwrap();
    bencher
        .counter(ItemsCount::new(rows * rollouts))
        .bench(|| simulate_batch(&system, black_box(&jobs), &inputs, 1, sensitivities).unwrap());
}

#[divan::bench]
fn rollout_lanes(bencher: Bencher<'_, '_>) {
    batch(bencher, 64, 2_000, false);
}

#[divan::bench]
fn rollout_lanes_with_sensitivities(bencher: Bencher<'_, '_>) {
    batch(bencher, 16, 2_000, true);
}

/// Normal equations of a rollout: 20,000 steps with 8 derivatives, in one segment or in lockstep
/// segments.
#[divan::bench(args = [1, 8])]
fn rollout_normal(bencher: Bencher<'_, '_>, segments: usize) {
    let (system, series) = (Chamber::new(Nonlinear::default()), series(segments));
    let space = Space::new(system.model.parameters());
    let objective = RolloutObjective::new(&system, &series, space, StartPressure::Fitted, 1);
    let nominal = objective.nominal();
    bencher.counter(ItemsCount::new(ROWS)).bench(|| objective.normal(black_box(&nominal)));
}

#[divan::bench]
fn rate_normal(bencher: Bencher<'_, '_>) {
    let (system, series) = (Chamber::new(Nonlinear::default()), series(1));
    let objective = RateObjective::new(&system, &series, Space::new(system.model.parameters()), 2);
    let nominal = objective.nominal();
    bencher.counter(ItemsCount::new(ROWS)).bench(|| objective.normal(black_box(&nominal)));
}

#[divan::bench(args = [1, 20], sample_count = 5)]
fn fit_rollout(bencher: Bencher<'_, '_>, starts: usize) {
    let (system, series) = (Chamber::new(Nonlinear::default()), series(1));
    let options = FitOptions { starts, ..FitOptions::default() };
    bencher.bench(|| {
        let space = Space::new(system.model.parameters());
        fit_rollouts(&[Problem { system: &system, series: &series, space }], &options, Control::none())
    });
}

#[divan::bench(args = [1, 20], sample_count = 5)]
fn fit_rate(bencher: Bencher<'_, '_>, starts: usize) {
    let (system, series) = (Chamber::new(Nonlinear::default()), series(1));
    let options = FitOptions { starts, ..FitOptions::default() };
    bencher.bench(|| {
        let space = Space::new(system.model.parameters());
        fit_rates(&[Problem { system: &system, series: &series, space }], 2, &options, Control::none())
    });
}
