//! Derivatives of weighted sums by inputs, parameters and starts are those of central differences.

use pneudrive_model::board::{Arithmetic, Board, Controller, Sensor};
use pneudrive_model::model::{Linear, Model, Nonlinear, Parametric, column, nominal_values};
use pneudrive_model::rollout::{
    BatchColumn, BatchInputs, Chamber, DIFFERENTIATED, Job, System, batch_gradient, simulate_batch,
};
use rand::RngExt;

use crate::engine::support;

const ROWS: usize = 40;

/// Not a multiple of the lanes.
const JOBS: usize = 6;

/// Inputs of all jobs, by column, `[job][row]`.
fn columns() -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = (0..JOBS).map(|job| support::inputs(ROWS, job as u64)).collect();
    let mut random = support::random(3);
    let mut columns: Vec<Vec<f64>> = (0..column::COUNT)
        .map(|c| rows.iter().flat_map(|r| r.iter().skip(c).step_by(column::COUNT).copied()).collect())
        .collect();
    // Not minus the fill drive, so that each has an effect of its own; a supply that wanders.
    columns[column::VENT].iter_mut().for_each(|vent| *vent += 0.05);
    columns[column::SUPPLY_PA].iter_mut().for_each(|supply| *supply += random.random_range(-2e4..2e4));
    columns
}

struct Case<'a> {
    system: &'a dyn System,
    parameters: Vec<Vec<f64>>,
    starts: Vec<f64>,
    columns: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

impl<'a> Case<'a> {
    fn new(system: &'a dyn System, nominal: &[f64]) -> Self {
        let mut random = support::random(8);
        let parameters = (0..JOBS)
            .map(|_| nominal.iter().map(|value| value * random.random_range(0.9..1.1)).collect())
            .collect();
        Self {
            system,
            parameters,
            starts: (0..JOBS).map(|job| 1.8e5 + 2e4 * job as f64).collect(),
            columns: columns(),
            weights: (0..JOBS * ROWS).map(|_| random.random_range(-1.0..1.0)).collect(),
        }
    }

    fn with<T>(&self, then: impl FnOnce(&[Job<'_>], &BatchInputs<'_>) -> T) -> T {
        let mut columns: Vec<BatchColumn<'_>> =
            self.columns.iter().map(BatchColumn::per_job_and_row).collect();
        columns[column::INTERVAL_S] = BatchColumn::constant(0.01);
        let inputs = BatchInputs::new(columns, JOBS, ROWS).unwrap();
        let jobs: Vec<Job<'_>> =
            self.parameters.iter().zip(&self.starts).map(|(p, s)| Job { parameters: p, start: *s }).collect();
        then(&jobs, &inputs)
    }

    fn sum(&self) -> f64 {
        let outputs =
            self.with(|jobs, inputs| simulate_batch(self.system, jobs, inputs, 2, false).unwrap().outputs);
        outputs.iter().zip(&self.weights).map(|(p, w)| p * w).sum()
    }

    /// Central difference by one number of the case.
    fn difference(&mut self, at: impl Fn(&mut Self) -> &mut f64, step: f64) -> f64 {
        *at(self) += step;
        let up = self.sum();
        *at(self) -= 2.0 * step;
        let down = self.sum();
        *at(self) += step;
        (up - down) / (2.0 * step)
    }

    fn check(&mut self) {
        let found =
            self.with(|jobs, inputs| batch_gradient(self.system, jobs, inputs, 2, &self.weights).unwrap());
        let width = self.parameters[0].len();
        let near = |found: f64, expected: f64, scale: f64, what: &str| {
            assert!((found - expected).abs() <= 2e-5 * scale + 1e-9, "{what}: {found}, expected {expected}");
        };
        for job in [0, JOBS - 1] {
            let expected = self.difference(|case| &mut case.starts[job], 1.0);
            near(found.start[job], expected, 1.0, "start");
            for i in 0..width {
                let step = 1e-5 * self.parameters[job][i].abs().max(1e-2);
                let expected = self.difference(|case| &mut case.parameters[job][i], step);
                let scale = expected.abs().max(1e3);
                near(found.parameters[job * width + i], expected, scale, &format!("parameter {i}"));
            }
            for (slot, &column) in DIFFERENTIATED.iter().enumerate() {
                let slopes = &found.inputs[slot][job * ROWS..][..ROWS];
                let scale = slopes.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
                for row in [0, 1, 17, ROWS - 2, ROWS - 1] {
                    let at = job * ROWS + row;
                    let step = 1e-5 * self.columns[column][at].abs().max(1e-2);
                    let expected = self.difference(|case| &mut case.columns[column][at], step);
                    near(slopes[row], expected, scale, &format!("column {column}, row {row}"));
                }
            }
        }
    }
}

#[test]
fn of_the_nonlinear_model() {
    Case::new(&Chamber::new(Nonlinear::default()), &support::TRUTH).check();
}

#[test]
fn of_the_parametric_and_the_linear_model() {
    let parametric = Chamber::new(Parametric::default());
    Case::new(&parametric, &nominal_values(&parametric.model.parameters())).check();
    let linear = Chamber::new(Linear::default());
    Case::new(&linear, &nominal_values(&linear.model.parameters())).check();
}

/// Behind a board whose converter is so fine that differences do not see its steps, with a filter
/// and gains that do not saturate.
#[test]
fn behind_a_board() {
    for filter in [0.0, 0.5] {
        let board = Board {
            controller: Controller { rate_hz: 200.0, kp: 0.5, kd: 0.2, saturation: 4e12, filter },
            arithmetic: Arithmetic::Fine,
            sensor: Sensor { bits: 45, zero_counts: 1e6, kpa_per_count: 1e-10 },
            ambient_pa: 101_325.0,
        };
        Case::new(&Chamber::behind(Nonlinear::default(), board), &support::TRUTH).check();
    }
}
