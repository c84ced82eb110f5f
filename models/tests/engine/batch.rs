//! Batches give what single rollouts give.

use pneudrive_model::model::{Nonlinear, column};
use pneudrive_model::numeric::Dual;
use pneudrive_model::rollout::{BatchError, Chamber, Job, Rows, Steps, System, rollout, simulate_batch};

use crate::support;

const ROWS: usize = 120;

/// More jobs than lanes, and not a multiple of them.
const JOBS: usize = 37;

#[test]
fn lanes_give_bit_for_bit_what_single_rollouts_give() {
    let system = Chamber(Nonlinear::default());
    let sets: Vec<Vec<f64>> =
        (0..JOBS).map(|i| support::TRUTH.map(|value| value * (1.0 + 0.01 * i as f64)).to_vec()).collect();
    let inputs: Vec<Vec<f64>> = (0..JOBS).map(|i| support::inputs(ROWS, i as u64)).collect();
    let jobs: Vec<Job<'_, 1>> = sets
        .iter()
        .zip(&inputs)
        .map(|(parameters, inputs)| Job { parameters, inputs, start: [2e5] })
        .collect();
    let plain = simulate_batch(&system, &jobs, column::COUNT, 2, false).unwrap();
    let with = simulate_batch(&system, &jobs, column::COUNT, 2, true).unwrap();
    assert_eq!(plain.outputs, with.outputs);
    for (i, job) in jobs.iter().enumerate() {
        let duals: Vec<Dual<f64, 7>> =
            job.parameters.iter().enumerate().map(|(j, &value)| Dual::variable(value, j)).collect();
        let rows = (Rows { inputs: job.inputs, width: column::COUNT }, ROWS);
        let steps = Steps { ticks: 1, substeps: 2 };
        rollout(
            &system,
            &system.coefficients(&duals),
            rows,
            [Dual { value: 2e5, gradient: [0.0; 7] }],
            steps,
            |k, y| {
                assert_eq!(y[0].value, plain.rollout(i)[k][0], "job {i}, row {k}");
                let sensitivity: Vec<f64> = with.sensitivity(i, k).iter().map(|s| s[0]).collect();
                assert_eq!(y[0].gradient.to_vec(), sensitivity, "job {i}, row {k}");
            },
        );
    }
}

#[test]
fn uneven_batches_are_refused() {
    let system = Chamber(Nonlinear::default());
    let inputs = support::inputs(10, 0);
    let job = Job { parameters: &support::TRUTH, inputs: &inputs, start: [2e5] };
    let short = Job { inputs: &inputs[..5 * column::COUNT], ..job };
    let few = Job { parameters: &support::TRUTH[..6], ..job };
    let batch = |jobs: &[Job<'_, 1>]| simulate_batch(&system, jobs, column::COUNT, 1, false).unwrap_err();
    assert_eq!(batch(&[job, short]), BatchError::Inputs { job: 1, expected: 80, found: 40 });
    assert_eq!(batch(&[job, few]), BatchError::Parameters { job: 1, expected: 7, found: 6 });
}
