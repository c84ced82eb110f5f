//! Single precision stays near double precision, over hours of rows and where hardly anything
//! flows.

use pneudrive_model::model::{Model, Nonlinear, Parametric, column, nominal_values};
use pneudrive_model::rollout::{
    BatchColumn, BatchError, BatchInputs, BatchUnit, Chamber, Job, System, simulate_batch,
    simulate_batch_single_into,
};
use rand::RngExt;

use crate::engine::support;

const ROWS: usize = 20_000;

/// More than one lot, and not a multiple of the lanes.
const JOBS: usize = 70;

/// 0.02 kPa.
const NEAR_PA: f64 = 20.0;

/// Parameters around the truth; of every third chamber with valves that hardly leak.
fn sets(jobs: usize) -> Vec<Vec<f64>> {
    let mut random = support::random(5);
    (0..jobs)
        .map(|job| {
            let mut set: Vec<f64> =
                support::TRUTH.iter().map(|value| value * random.random_range(0.5..1.5)).collect();
            if job % 3 == 0 {
                (set[0], set[1], set[5]) = (1e-5, 2e-5, 0.01);
            }
            set
        })
        .collect()
}

/// Largest difference in Pa between the two precisions, and the range of the pressures.
fn difference(system: &dyn System, sets: &[Vec<f64>], drive: &[f64]) -> (f64, f64) {
    let inputs = support::inputs(ROWS, 7);
    let columns: Vec<Vec<f64>> = (0..column::COUNT)
        .map(|column| inputs.iter().skip(column).step_by(column::COUNT).copied().collect())
        .collect();
    let vent: Vec<f64> = drive.iter().map(|u| -u).collect();
    let mut given: Vec<BatchColumn<'_>> = columns.iter().map(|values| BatchColumn::per_row(values)).collect();
    given[column::FILL] = BatchColumn::per_job_and_row(drive);
    given[column::VENT] = BatchColumn::per_job_and_row(&vent);
    let inputs = BatchInputs::new(given, sets.len(), ROWS).unwrap();
    let jobs: Vec<Job<'_>> = sets.iter().map(|parameters| Job { parameters, start: 3e5 }).collect();
    let double = simulate_batch(system, &jobs, &inputs, 1, false).unwrap().outputs;
    let mut single = vec![0.0_f32; double.len()];
    simulate_batch_single_into(system, &jobs, &inputs, 1, &mut single, BatchUnit::PASCAL).unwrap();
    let apart = single.iter().zip(&double).map(|(s, d)| (f64::from(*s) - d).abs()).fold(0.0, f64::max);
    let low = double.iter().copied().fold(f64::INFINITY, f64::min);
    (apart, double.iter().copied().fold(0.0, f64::max) - low)
}

/// Steps of 50 to 500 ms in a tenth of the time, else a valve that is closed.
fn drives(jobs: usize) -> Vec<f64> {
    let mut random = support::random(9);
    let mut drive = Vec::with_capacity(jobs * ROWS);
    for job in 0..jobs {
        let mut left = 0;
        let mut now = 0.0;
        for row in 0..ROWS {
            if left == 0 {
                let moving = job % 2 == 1 || (row / 1000) % 10 == 0;
                now = if moving { random.random_range(-0.6..0.6) } else { 0.0 };
                left = random.random_range(5..50);
            }
            left -= 1;
            drive.push(now);
        }
    }
    drive
}

#[test]
fn nonlinear_chambers_stay_within_a_fiftieth_of_a_kpa() {
    let (apart, range) = difference(&Chamber::new(Nonlinear::default()), &sets(JOBS), &drives(JOBS));
    println!("single precision is within {:.4} kPa", apart * 1e-3);
    assert!(apart < NEAR_PA, "{apart} Pa");
    assert!(apart > 0.0, "that is double precision");
    assert!(range > 4e5, "nothing moves");
}

#[test]
fn parametric_chambers_stay_within_a_fiftieth_of_a_kpa() {
    let chamber = Chamber::new(Parametric::default());
    let sets = vec![nominal_values(&chamber.model.parameters()); JOBS];
    let (apart, range) = difference(&chamber, &sets, &drives(JOBS));
    println!("single precision is within {:.4} kPa", apart * 1e-3);
    assert!(apart < NEAR_PA, "{apart} Pa");
    assert!(range > 1e5, "nothing moves");
}

/// A leak of 1.5 Pa/s moves the pressure by half of its last digit in a step: only what is kept of
/// the rounding shows it. What is left is the rounding of the closed port's opening.
#[test]
fn a_slow_leak_is_not_rounded_away() {
    let set = vec![1e-9, 5e-6, 4.0, 0.9, -0.9, 1e-3, 1.0];
    let chamber = Chamber::new(Nonlinear::default());
    let mut columns = vec![BatchColumn::constant(0.0); column::COUNT];
    columns[column::INTERVAL_S] = BatchColumn::constant(0.01);
    columns[column::SUPPLY_PA] = BatchColumn::constant(6.5e5);
    columns[column::INVERSE_VOLUME_PER_M3] = BatchColumn::constant(1.0 / 3.6e-4);
    let inputs = BatchInputs::new(columns, 1, ROWS).unwrap();
    let jobs = [Job { parameters: &set, start: 4e5 }];
    let double = simulate_batch(&chamber, &jobs, &inputs, 1, false).unwrap().outputs;
    let mut single = vec![0.0_f32; ROWS];
    simulate_batch_single_into(&chamber, &jobs, &inputs, 1, &mut single, BatchUnit::PASCAL).unwrap();
    let (lost, kept) = (double[0] - double[ROWS - 1], f64::from(single[0] - single[ROWS - 1]));
    assert!((100.0..1000.0).contains(&lost), "{lost} Pa leak away");
    assert!((lost - kept).abs() < NEAR_PA, "{lost} Pa leak away, in single precision {kept}");
}

#[test]
fn inputs_may_be_in_either_precision_and_are_checked() {
    let chamber = Chamber::new(Nonlinear::default());
    let drive: Vec<f32> = (0..40 * 100).map(|k| 0.5 * (0.1 * k as f32).sin()).collect();
    let wide: Vec<f64> = drive.iter().map(|u| f64::from(*u)).collect();
    let jobs = vec![Job { parameters: &support::TRUTH, start: 2e5 }; 40];
    let run = |fill: BatchColumn<'_>| {
        let mut columns = vec![BatchColumn::constant(1.0); column::COUNT];
        columns[column::INTERVAL_S] = BatchColumn::constant(0.01);
        columns[column::SUPPLY_PA] = BatchColumn::constant(6.5e5);
        columns[column::INVERSE_VOLUME_PER_M3] = BatchColumn::constant(1.0 / 3.6e-4);
        columns[column::VOLUME_RATE_M3_S] = BatchColumn::constant(0.0);
        columns[column::VENT] = fill.scaled(-1.0, 0.0);
        columns[column::FILL] = fill.within([-1.0, 1.0]);
        let inputs = BatchInputs::new(columns, 40, 100).unwrap();
        let mut single = vec![0.0_f32; 40 * 100];
        simulate_batch_single_into(&chamber, &jobs, &inputs, 1, &mut single, BatchUnit::PASCAL)
            .map(|()| single)
    };
    let narrow = run(BatchColumn::per_job_and_row(&drive)).unwrap();
    assert!(narrow.iter().all(|pa| pa.is_finite()) && narrow[99] != narrow[0], "a simulation");
    assert!(narrow == run(BatchColumn::per_job_and_row(&wide)).unwrap(), "they differ");
    for wrong in [1.01, f32::NAN] {
        let mut drive = drive.clone();
        drive[33 * 100 + 7] = wrong;
        let error = run(BatchColumn::per_job_and_row(&drive)).unwrap_err();
        assert!(
            matches!(error, BatchError::Range { column: column::FILL, job: 33, row: 7, .. }),
            "{error:?}"
        );
    }
}
