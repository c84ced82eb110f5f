//! Do the 95 % intervals hold the truth in 95 % of recordings?

use pneudrive_model::fit::{Control, FitOptions, Problem, Space, fit_rollouts};
use pneudrive_model::model::{Model, Nonlinear, column};
use pneudrive_model::rollout::{Chamber, Series, Start, simulate};

use crate::engine::support;

const SIGMA_PA: f64 = 360.0;

#[derive(Debug)]
struct Coverage {
    /// Share of the intervals that hold the truth, over all parameters and seeds.
    share: f64,
    /// The same per parameter.
    #[expect(dead_code, reason = "printed")]
    each: Vec<f64>,
    /// Share of the estimates that ended on a bound, where no interval is stated.
    without_interval: f64,
}

/// Fits many recordings. `wander` is the relative standard deviation of the true supply, which the
/// model does not know: a first-order process with a time constant of 0.5 s.
fn coverage(wander: f64, rows: usize, seeds: u64) -> Coverage {
    let system = Chamber::new(Nonlinear::default());
    let series: Vec<Series> = (0..seeds).map(|seed| recording(&system, wander, rows, seed)).collect();
    let problems: Vec<Problem<'_>> = series
        .iter()
        .map(|series| {
            let space = Space::new(system.model.parameters()).starting_at(&support::TRUTH);
            Problem { system: &system, series, space }
        })
        .collect();
    let options = FitOptions { starts: 1, ..FitOptions::default() };
    let fits = fit_rollouts(&problems, &options, Control::none());
    let mut held = vec![0.0; support::TRUTH.len()];
    let mut stated = vec![0.0; support::TRUTH.len()];
    for fit in fits {
        for (i, parameter) in fit.unwrap().parameters.iter().enumerate() {
            if let Some([low, high]) = parameter.ci95 {
                stated[i] += 1.0;
                held[i] += f64::from(u8::from((low..=high).contains(&support::TRUTH[i])));
            }
        }
    }
    let all = stated.len() as f64 * seeds as f64;
    let share = held.iter().sum::<f64>() / stated.iter().sum::<f64>();
    let each = held.iter().zip(&stated).map(|(held, stated)| held / stated).collect();
    Coverage { share, each, without_interval: 1.0 - stated.iter().sum::<f64>() / all }
}

/// What the true supply gave, with the nominal supply in the inputs.
fn recording(system: &Chamber<Nonlinear>, wander: f64, rows: usize, seed: u64) -> Series {
    let nominal = support::inputs(rows, seed);
    let mut random = support::random(1_000 + seed);
    let mut actual = nominal.clone();
    let memory = (-0.01_f64 / 0.5).exp();
    let mut deviation = 0.0;
    for row in actual.chunks_exact_mut(column::COUNT) {
        deviation = memory * deviation + (1.0 - memory * memory).sqrt() * support::normal(&mut random);
        row[column::SUPPLY_PA] *= 1.0 + wander * deviation;
    }
    let series = |inputs: Vec<f64>, measured: Vec<f64>| {
        #[expect(clippy::single_range_in_vec_init)]
        Series::new(column::COUNT, inputs, measured, vec![1.0; rows], vec![0..rows]).unwrap()
    };
    let truth = series(actual, vec![200e3; rows]);
    let clean = simulate(system, &support::TRUTH, &truth, Start::Measured, 1);
    support::noisy(&series(nominal, clean), SIGMA_PA, 5_000 + seed)
}

#[test]
fn intervals_cover_under_white_noise() {
    let coverage = coverage(0.0, 3_000, 200);
    println!("white noise: {coverage:.3?}");
    assert_eq!(coverage.without_interval, 0.0);
    // 1,400 intervals: the standard error of the share is below 0.007.
    assert!((0.935..=0.985).contains(&coverage.share), "{coverage:?}");
}

#[test]
fn intervals_cover_when_the_supply_wanders() {
    let coverage = coverage(0.01, 10_000, 100);
    println!("wandering supply: {coverage:.3?}");
    assert!(coverage.without_interval < 0.05, "{coverage:?}");
    assert!((0.90..=0.99).contains(&coverage.share), "{coverage:?}");
}

/// Thirty seconds of a wandering supply are worth some twenty independent samples, to determine
/// eight unknowns by.
#[test]
fn intervals_of_short_recordings_are_not_far_off() {
    let coverage = coverage(0.01, 3_000, 100);
    println!("wandering supply, short: {coverage:.3?}");
    assert!(coverage.share >= 0.85, "{coverage:?}");
}
