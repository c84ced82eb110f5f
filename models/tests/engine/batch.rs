//! Batches give what single rollouts give.

use pneudrive_model::model::{Model, Nonlinear, column};
use pneudrive_model::numeric::Dual;
use pneudrive_model::rollout::{
    BatchColumn, BatchError, BatchInputs, Chamber, Job, Rows, Steps, rollout, simulate_batch,
};

use crate::engine::support;

/// Not a multiple of the rows that are fetched and written at once.
const ROWS: usize = 123;

/// More jobs than lanes, and not a multiple of them.
const JOBS: usize = 37;

#[test]
fn lanes_give_bit_for_bit_what_single_rollouts_give() {
    let system = Chamber::new(Nonlinear::default());
    let sets: Vec<Vec<f64>> =
        (0..JOBS).map(|i| support::TRUTH.map(|value| value * (1.0 + 0.01 * i as f64)).to_vec()).collect();
    let inputs: Vec<Vec<f64>> = (0..JOBS).map(|i| support::inputs(ROWS, i as u64)).collect();
    let jobs: Vec<Job<'_>> = sets.iter().map(|parameters| Job { parameters, start: 2e5 }).collect();
    let columns: Vec<Vec<f64>> = (0..column::COUNT)
        .map(|column| {
            let of = |inputs: &Vec<f64>| inputs.iter().skip(column).step_by(column::COUNT).copied().collect();
            inputs.iter().flat_map(|inputs| -> Vec<f64> { of(inputs) }).collect()
        })
        .collect();
    let columns = columns.iter().map(BatchColumn::per_job_and_row).collect();
    let together = BatchInputs::new(columns, JOBS, ROWS).unwrap();
    let plain = simulate_batch(&system, &jobs, &together, 2, false).unwrap();
    let with = simulate_batch(&system, &jobs, &together, 2, true).unwrap();
    assert_eq!(plain.outputs, with.outputs);
    for (i, job) in jobs.iter().enumerate() {
        let duals: Vec<Dual<f64, 7>> =
            job.parameters.iter().enumerate().map(|(j, &value)| Dual::variable(value, j)).collect();
        let rows = (Rows { inputs: &inputs[i], width: column::COUNT }, ROWS);
        let steps = Steps { ticks: 1, substeps: 2 };
        rollout(
            &system,
            &system.model.coefficients(&duals),
            rows,
            Dual { value: 2e5, gradient: [0.0; 7] },
            steps,
            |k, y| {
                assert_eq!(y.value, plain.rollout(i)[k], "job {i}, row {k}");
                assert_eq!(y.gradient, *with.sensitivity(i, k), "job {i}, row {k}");
            },
        );
    }
}

/// Constant over rows or jobs, in other units, negated: as if every value had been written out.
#[test]
fn columns_broadcast() {
    let system = Chamber::new(Nonlinear::default());
    let drive: Vec<f64> = (0..ROWS).map(|row| 0.3 * (0.2 * row as f64).sin()).collect();
    let supply_kpa: Vec<f64> = (0..JOBS).map(|job| 400.0 + job as f64).collect();
    let repeated = |value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        (0..JOBS).flat_map(|job| (0..ROWS).map(move |row| (job, row))).map(|(j, r)| value(j, r)).collect()
    };
    let mut short = vec![BatchColumn::constant(0.0); column::COUNT];
    short[column::INTERVAL_S] = BatchColumn::constant(0.01);
    short[column::INVERSE_VOLUME_PER_M3] = BatchColumn::constant(1.0 / 3.6e-4);
    let mut long = short.clone();
    short[column::FILL] = BatchColumn::per_row(&drive);
    short[column::VENT] = BatchColumn::per_row(&drive).scaled(-1.0, 0.0);
    short[column::SUPPLY_PA] = BatchColumn::per_job(&supply_kpa).scaled(1e3, 101_325.0);
    let written = [
        repeated(&|_, row| drive[row]),
        repeated(&|_, row| -drive[row]),
        repeated(&|job, _| 101_325.0 + 1e3 * supply_kpa[job]),
    ];
    for (column, values) in [column::FILL, column::VENT, column::SUPPLY_PA].into_iter().zip(&written) {
        long[column] = BatchColumn::per_job_and_row(values);
    }
    let jobs = vec![Job { parameters: &support::TRUTH, start: 2e5 }; JOBS];
    let batch = |columns| {
        let inputs = BatchInputs::new(columns, JOBS, ROWS).unwrap();
        simulate_batch(&system, &jobs, &inputs, 1, false).unwrap().outputs
    };
    assert_eq!(batch(short), batch(long));
}

#[test]
fn uneven_batches_are_refused() {
    let system = Chamber::new(Nonlinear::default());
    let constant = vec![BatchColumn::constant(1.0); column::COUNT];
    let inputs = BatchInputs::new(constant.clone(), 2, 10).unwrap();
    let job = Job { parameters: &support::TRUTH, start: 2e5 };
    let few = Job { parameters: &support::TRUTH[..6], ..job };
    let batch = |jobs: &[Job<'_>]| simulate_batch(&system, jobs, &inputs, 1, false).unwrap_err();
    assert_eq!(batch(&[job]), BatchError::Jobs { jobs: 1, inputs: 2 });
    assert_eq!(batch(&[job, few]), BatchError::Parameters { job: 1, expected: 7, found: 6 });
    let too_few = BatchInputs::new(constant[..7].to_vec(), 2, 10).unwrap_err();
    assert_eq!(too_few, BatchError::Columns { columns: 7 });
    let mut short = constant;
    short[column::FILL] = BatchColumn::per_row(&[0.0; 9]);
    let short = BatchInputs::new(short, 2, 10).unwrap_err();
    assert_eq!(short, BatchError::Values { column: column::FILL, expected: 10, found: 9 });
}

/// Found while the rows are simulated, before that where it costs nothing, and named as it was
/// given.
#[test]
fn values_out_of_range_are_refused() {
    let system = Chamber::new(Nonlinear::default());
    let batch = |drive: BatchColumn<'_>, sensitivities| {
        let mut columns = vec![BatchColumn::constant(1.0); column::COUNT];
        columns[column::VENT] = drive.scaled(-1.0, 0.0);
        columns[column::FILL] = drive;
        let jobs = vec![Job { parameters: &support::TRUTH, start: 2e5 }; JOBS];
        simulate_batch(&system, &jobs, &BatchInputs::new(columns, JOBS, ROWS)?, 1, sensitivities)
    };
    let limits = [-1.0, 1.0];
    for (job, row) in [(0, 0), (31, 7), (36, ROWS - 1)] {
        for wrong in [-1.001, f64::INFINITY, f64::NAN] {
            let mut drive = vec![0.5; JOBS * ROWS];
            drive[job * ROWS + row] = wrong;
            for sensitivities in [false, true] {
                let error = batch(BatchColumn::per_job_and_row(&drive).within(limits), sensitivities);
                let Err(BatchError::Range { column, job: found, row: at, value }) = error else {
                    panic!("{wrong} at row {row} of {job} passed")
                };
                assert_eq!((column, found, at), (column::FILL, job, row));
                assert!(value == wrong || value.is_nan() && wrong.is_nan(), "{value}");
            }
            let error = batch(BatchColumn::per_row(&drive[job * ROWS..][..ROWS]).within(limits), false);
            assert!(
                matches!(error, Err(BatchError::Range { job: 0, row: at, .. }) if at == row),
                "{error:?}"
            );
            assert!(batch(BatchColumn::constant(wrong).within(limits), false).is_err(), "{wrong}");
            assert!(batch(BatchColumn::per_job_and_row(&drive), false).is_ok(), "nothing was asked for");
        }
    }
    assert!(batch(BatchColumn::constant(-1.0).within(limits), false).is_ok());
}
