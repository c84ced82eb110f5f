//! One model set up for one channel, behind one interface whatever the model.

use crate::fit::{Control, Fit, FitError, FitOptions, Problem, Space, fit_rates, fit_rollouts};
use crate::model::{
    Drive, FlowForm, FlowFunction, Gas, Linear, Model, Nonlinear, Parameter, Parametric, column,
};
use crate::rig::{Rig, RigError};
use crate::rollout::{
    BatchError, BatchInputs, BatchResults, Board, Chamber, Controller, Job, RowStepper, Rows, Sensor, Series,
    Start, Steps, System, SystemStepper, rollout, simulate, simulate_batch_into,
};

use super::{ModelKind, Setup};

/// What a fit minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Objective {
    /// Simulated minus measured pressure.
    #[default]
    Rollout,
    /// Rate of the model minus derivative of the measured pressure, smoothed over this many samples to either side.
    Rate {
        /// Samples to either side.
        half_width: usize,
    },
}

/// A model ready to be fitted and simulated on inputs of one chamber.
pub trait Subject: Send + Sync {
    /// The model's parameters.
    fn parameters(&self) -> Vec<Parameter>;

    /// Fits each series on its own.
    ///
    /// # Errors
    /// One [`FitError`] per series that cannot be fitted.
    fn fit(
        &self,
        series: &[&Series<1>],
        objective: Objective,
        options: &FitOptions,
        control: Control<'_>,
    ) -> Vec<Result<Fit, FitError>>;

    /// Whether [`Objective::Rate`] is possible: not with the board's loop in front, whose drive is a result.
    fn has_rates(&self) -> bool;

    /// Simulated absolute pressures, Pa, one per row; `NaN` outside the segments.
    fn simulate(
        &self,
        parameters: &[f64],
        series: &Series<1>,
        starts: Start<'_, 1>,
        substeps: usize,
    ) -> Vec<f64>;

    /// Ticks of an interval of this length, s: see [`System::ticks`].
    fn ticks(&self, interval_s: f64) -> usize;

    /// The model with its parameters, to be simulated row by row: see [`SystemStepper::new`].
    fn stepper(
        self: Box<Self>,
        parameters: &[f64],
        substeps: usize,
        row: &[f64],
        pressure_pa: f64,
    ) -> Box<dyn RowStepper>;

    /// Many rollouts at once, in lockstep and on all threads: see [`simulate_batch_into`].
    ///
    /// # Errors
    /// [`BatchError`] when inputs or results are for another number of jobs, or a job has a wrong number of parameters.
    fn batch(
        &self,
        jobs: &[Job<'_, 1>],
        inputs: &BatchInputs<'_>,
        substeps: usize,
        results: BatchResults<'_, 1>,
    ) -> Result<(), BatchError>;

    /// For each row, the absolute pressure in Pa that is predicted for it from the measurement of the row before; `NaN`
    /// where there is none.
    fn one_step(&self, parameters: &[f64], series: &Series<1>, substeps: usize) -> Vec<f64>;

    /// Evaluates the right-hand side once at every measured row and returns the sum, so that it can be timed.
    fn evaluate_all(&self, parameters: &[f64], series: &Series<1>) -> f64;
}

/// Builds the model of `setup` with the constants of `rig`.
///
/// # Errors
/// [`RigError::MissingTable`] when the board's loop is asked for and not described.
pub fn subject(setup: Setup, rig: &Rig, form: FlowForm) -> Result<Box<dyn Subject>, RigError> {
    let ambient = rig.ambient_or_standard();
    let gas = Gas {
        temperature_k: ambient.temperature_k,
        ambient_pa: ambient.pressure_kpa_abs * 1e3,
        ..Gas::default()
    };
    let valve = rig.valve.clone().unwrap_or_default();
    let drive = setup.valve_drive();
    match setup.model {
        ModelKind::Linear => Ok(Box::new(Chamber(Linear { gas }))),
        ModelKind::Nonlinear => {
            let model = Nonlinear {
                gas,
                flow: FlowFunction::new(valve.critical_ratio, form),
                discharge_coefficient: valve.discharge_coefficient,
                drive,
            };
            behind_board(model, setup, rig, gas)
        }
        ModelKind::Parametric => behind_board(Parametric { gas, drive }, setup, rig, gas),
    }
}

fn behind_board<Q: Model + Copy + 'static>(
    model: Q,
    setup: Setup,
    rig: &Rig,
    gas: Gas,
) -> Result<Box<dyn Subject>, RigError> {
    if !setup.controller {
        return Ok(Box::new(Chamber(model)));
    }
    let missing = |table| RigError::MissingTable { table, purpose: "the simulation of the board's loop" };
    let controller = rig.controller.as_ref().ok_or_else(|| missing("controller"))?;
    let sensor = rig.sensor.as_ref().ok_or_else(|| missing("sensor"))?;
    Ok(Box::new(Board {
        chamber: model,
        controller: Controller {
            rate_hz: controller.rate_hz,
            kp: controller.kp,
            kd: controller.kd,
            saturation: controller.saturation,
            filter: controller.filter,
            arithmetic: crate::rollout::Arithmetic::default(),
        },
        sensor: Sensor {
            bits: sensor.bits,
            zero_counts: sensor.zero_counts,
            kpa_per_count: sensor.kpa_per_count,
        },
        ambient_pa: gas.ambient_pa,
    }))
}

impl<Q: Model + 'static> Subject for Chamber<Q> {
    fn parameters(&self) -> Vec<Parameter> {
        self.0.parameters()
    }

    fn fit(
        &self,
        series: &[&Series<1>],
        objective: Objective,
        options: &FitOptions,
        control: Control<'_>,
    ) -> Vec<Result<Fit, FitError>> {
        match objective {
            Objective::Rollout => {
                fit_rollouts(&problems(self, series, self.0.parameters()), options, control)
            }
            Objective::Rate { half_width } => {
                fit_rates(&problems(&self.0, series, self.0.parameters()), half_width, options, control)
            }
        }
    }

    fn has_rates(&self) -> bool {
        true
    }

    fn simulate(
        &self,
        parameters: &[f64],
        series: &Series<1>,
        starts: Start<'_, 1>,
        substeps: usize,
    ) -> Vec<f64> {
        pressures(simulate(self, parameters, series, starts, substeps))
    }

    fn ticks(&self, interval_s: f64) -> usize {
        System::ticks(self, interval_s)
    }

    fn stepper(
        self: Box<Self>,
        parameters: &[f64],
        substeps: usize,
        row: &[f64],
        pressure_pa: f64,
    ) -> Box<dyn RowStepper> {
        Box::new(SystemStepper::new(*self, parameters, substeps, row, pressure_pa))
    }

    fn batch(
        &self,
        jobs: &[Job<'_, 1>],
        inputs: &BatchInputs<'_>,
        substeps: usize,
        results: BatchResults<'_, 1>,
    ) -> Result<(), BatchError> {
        simulate_batch_into(self, jobs, inputs, substeps, results)
    }

    fn one_step(&self, parameters: &[f64], series: &Series<1>, substeps: usize) -> Vec<f64> {
        one_step(self, parameters, series, substeps)
    }

    fn evaluate_all(&self, parameters: &[f64], series: &Series<1>) -> f64 {
        evaluate_all(&self.0, parameters, series)
    }
}

impl<Q: Model + 'static> Subject for Board<Q> {
    fn parameters(&self) -> Vec<Parameter> {
        self.chamber.parameters()
    }

    fn fit(
        &self,
        series: &[&Series<1>],
        _: Objective,
        options: &FitOptions,
        control: Control<'_>,
    ) -> Vec<Result<Fit, FitError>> {
        fit_rollouts(&problems(self, series, self.chamber.parameters()), options, control)
    }

    fn has_rates(&self) -> bool {
        false
    }

    fn simulate(
        &self,
        parameters: &[f64],
        series: &Series<1>,
        starts: Start<'_, 1>,
        substeps: usize,
    ) -> Vec<f64> {
        pressures(simulate(self, parameters, series, starts, substeps))
    }

    fn ticks(&self, interval_s: f64) -> usize {
        System::ticks(self, interval_s)
    }

    fn stepper(
        self: Box<Self>,
        parameters: &[f64],
        substeps: usize,
        row: &[f64],
        pressure_pa: f64,
    ) -> Box<dyn RowStepper> {
        Box::new(SystemStepper::new(*self, parameters, substeps, row, pressure_pa))
    }

    fn batch(
        &self,
        jobs: &[Job<'_, 1>],
        inputs: &BatchInputs<'_>,
        substeps: usize,
        results: BatchResults<'_, 1>,
    ) -> Result<(), BatchError> {
        simulate_batch_into(self, jobs, inputs, substeps, results)
    }

    fn one_step(&self, parameters: &[f64], series: &Series<1>, substeps: usize) -> Vec<f64> {
        one_step(self, parameters, series, substeps)
    }

    fn evaluate_all(&self, parameters: &[f64], series: &Series<1>) -> f64 {
        evaluate_all(&self.chamber, parameters, series)
    }
}

/// Parameters that only a changing volume can tell, and the values that leave them out: the rate of a volume that does not
/// change weighs nothing, and its dependence on the volume is part of the other factors.
const TOLD_BY_VOLUME: [(&str, f64); 4] = [("volume_weight", 1.0), ("c4", 0.0), ("c5", 0.0), ("c6", 0.0)];

fn problems<'a, Y>(
    system: &'a Y,
    series: &[&'a Series<1>],
    parameters: Vec<Parameter>,
) -> Vec<Problem<'a, Y, 1>> {
    let space = Space::new(parameters);
    let of = |series: &'a Series<1>| {
        let mut space = space.clone();
        if !volume_changes(series) {
            for (name, value) in TOLD_BY_VOLUME {
                // A model without this parameter has nothing to fix.
                let _ = space.fix(name, value);
            }
        }
        Problem { system, series, space }
    };
    series.iter().map(|series| of(series)).collect()
}

/// Whether the volume changes at all within the segments.
fn volume_changes(series: &Series<1>) -> bool {
    let mut rows = series.segments().iter().flat_map(Clone::clone);
    rows.any(|row| series.row(row)[column::VOLUME_RATE_M3_S].abs() > 0.0)
}

fn pressures(outputs: Vec<[f64; 1]>) -> Vec<f64> {
    outputs.into_iter().map(|[p]| p).collect()
}

fn one_step<Y: System<1, 1>>(
    system: &Y,
    parameters: &[f64],
    series: &Series<1>,
    substeps: usize,
) -> Vec<f64> {
    let coefficients = system.coefficients(parameters);
    let steps = Steps { ticks: system.ticks(series.interval_s()), substeps };
    let mut predicted = vec![f64::NAN; series.len()];
    for range in series.segments() {
        for row in range.start..range.end - 1 {
            if series.weights()[row][0] > 0.0 {
                let rows = Rows { inputs: series.inputs(row..row + 2), width: series.width() };
                let start: [f64; 1] = series.measured()[row];
                rollout(system, &coefficients, (rows, 2), start, steps, |k, y| {
                    if k == 1 {
                        predicted[row + 1] = y[0];
                    }
                });
            }
        }
    }
    predicted
}

fn evaluate_all<Q: Model>(model: &Q, parameters: &[f64], series: &Series<1>) -> f64 {
    let coefficients = model.coefficients(parameters);
    let mut sum = 0.0;
    for row in series.segments().iter().flat_map(Clone::clone) {
        let inputs = series.row(row);
        let held = model.hold(&coefficients, inputs, Drive::recorded(inputs));
        let pressure: f64 = series.measured()[row][0];
        sum += model.rate(&coefficients, &held, pressure);
    }
    sum
}
