//! One model set up for one channel, behind one interface whatever the model.

use crate::fit::{Control, Fit, FitError, FitOptions, Problem, Space, fit_rates, fit_rollouts};
use crate::model::{FlowForm, Parameter, column};
use crate::rig::{Rig, RigError};
use crate::rollout::{
    BatchError, BatchGradient, BatchInputs, BatchResults, BatchUnit, Job, RowStepper, Rows, Series, Start,
    Steps, System, batch_gradient, simulate, simulate_batch_into, simulate_batch_single_into,
};

use super::Setup;

/// What a fit minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Objective {
    /// Simulated minus measured pressure.
    #[default]
    Rollout,
    /// Rate of the model minus derivative of the measured pressure, smoothed over this many samples
    /// to either side.
    Rate {
        /// Samples to either side.
        half_width: usize,
    },
}

/// A model ready to be fitted and simulated on inputs of one chamber.
#[derive(Debug)]
pub struct Subject(Box<dyn System>);

impl Subject {
    /// The model's parameters.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        self.0.parameters()
    }

    /// Fits each series on its own.
    ///
    /// # Errors
    /// One [`FitError`] per series that cannot be fitted.
    #[must_use]
    pub fn fit(
        &self,
        series: &[&Series],
        objective: Objective,
        options: &FitOptions,
        control: Control<'_>,
    ) -> Vec<Result<Fit, FitError>> {
        let problems = self.problems(series);
        match objective {
            Objective::Rate { half_width } if self.has_rates() => {
                fit_rates(&problems, half_width, options, control)
            }
            Objective::Rollout | Objective::Rate { .. } => fit_rollouts(&problems, options, control),
        }
    }

    /// Whether [`Objective::Rate`] is possible: not with the board's loop in front, whose drive is
    /// a result.
    #[must_use]
    pub fn has_rates(&self) -> bool {
        self.0.has_rates()
    }

    /// Simulated absolute pressures, Pa, one per row; `NaN` outside the segments.
    #[must_use]
    pub fn simulate(
        &self,
        parameters: &[f64],
        series: &Series,
        starts: Start<'_>,
        substeps: usize,
    ) -> Vec<f64> {
        simulate(&*self.0, parameters, series, starts, substeps)
    }

    /// Ticks of an interval of this length, s: see [`System::ticks`].
    #[must_use]
    pub fn ticks(&self, interval_s: f64) -> usize {
        self.0.ticks(interval_s)
    }

    /// The model with its parameters, to be simulated row by row: see [`System::stepper`].
    #[must_use]
    pub fn stepper(
        &self,
        parameters: &[f64],
        substeps: usize,
        row: &[f64],
        pressure_pa: f64,
    ) -> Box<dyn RowStepper> {
        self.0.stepper(parameters, substeps, row, pressure_pa)
    }

    /// Many rollouts at once, in lockstep and on all threads: see [`simulate_batch_into`].
    ///
    /// # Errors
    /// [`BatchError`] when inputs or results are for another number of jobs, or a job has a wrong
    /// number of parameters.
    pub fn batch(
        &self,
        jobs: &[Job<'_>],
        inputs: &BatchInputs<'_>,
        substeps: usize,
        results: BatchResults<'_>,
    ) -> Result<(), BatchError> {
        simulate_batch_into(&*self.0, jobs, inputs, substeps, results)
    }

    /// The pressures of a batch in single precision.
    ///
    /// # Errors
    /// As there.
    pub fn batch_single(
        &self,
        jobs: &[Job<'_>],
        inputs: &BatchInputs<'_>,
        substeps: usize,
        outputs: &mut [f32],
        unit: BatchUnit,
    ) -> Result<(), BatchError> {
        simulate_batch_single_into(&*self.0, jobs, inputs, substeps, outputs, unit)
    }

    /// Derivatives of the weighted sum of a batch's pressures.
    ///
    /// # Errors
    /// As there.
    pub fn batch_gradient(
        &self,
        jobs: &[Job<'_>],
        inputs: &BatchInputs<'_>,
        substeps: usize,
        weights: &[f64],
    ) -> Result<BatchGradient, BatchError> {
        batch_gradient(&*self.0, jobs, inputs, substeps, weights)
    }

    /// For each row, the absolute pressure in Pa that is predicted for it from the measurement of
    /// the row before; `NaN` where there is none.
    #[must_use]
    pub fn one_step(&self, parameters: &[f64], series: &Series, substeps: usize) -> Vec<f64> {
        let steps = Steps { ticks: self.0.ticks(series.interval_s()), substeps };
        let mut predicted = vec![f64::NAN; series.len()];
        for range in series.segments() {
            for row in range.start..range.end - 1 {
                if series.weights()[row] > 0.0 {
                    let rows = Rows { inputs: series.inputs(row..row + 2), width: series.width() };
                    let mut pressures = [0.0; 2];
                    self.0.simulate(parameters, rows, series.measured()[row], steps, &mut pressures);
                    predicted[row + 1] = pressures[1];
                }
            }
        }
        predicted
    }

    /// Evaluates the right-hand side once at every measured row and returns the sum, so that it can
    /// be timed.
    #[must_use]
    pub fn evaluate_all(&self, parameters: &[f64], series: &Series) -> f64 {
        let of = |range: &std::ops::Range<usize>| {
            let rows = Rows { inputs: series.inputs(range.clone()), width: series.width() };
            self.0.sum_of_rates(parameters, rows, &series.measured()[range.clone()])
        };
        series.segments().iter().map(of).sum()
    }

    fn problems<'a>(&'a self, series: &[&'a Series]) -> Vec<Problem<'a>> {
        let space = Space::new(self.0.parameters());
        let of = |series: &'a Series| {
            let mut space = space.clone();
            if !volume_changes(series) {
                for (name, value) in TOLD_BY_VOLUME {
                    // A model without this parameter has nothing to fix.
                    let _ = space.fix(name, value);
                }
            }
            Problem { system: &*self.0, series, space }
        };
        series.iter().map(|series| of(series)).collect()
    }
}

/// Builds the model of `setup` with the constants of `rig`, a channel's ([`Rig::at`]).
///
/// # Errors
/// [`RigError::MissingTable`] when the board's loop is asked for and not described.
pub fn subject(setup: Setup, rig: &Rig, form: FlowForm) -> Result<Subject, RigError> {
    // A regulator's model describes the loop along with the valve.
    let behind_board = setup.controller && !setup.model.is_regulator();
    let board = if behind_board { Some(rig.board()?) } else { None };
    Ok(Subject(setup.model.chamber(&rig.constants(setup.valve_drive(), form), board)))
}

/// Parameters that only a changing volume can tell, and the values that leave them out: the rate of
/// a volume that does not change weighs nothing, and its dependence on the volume is part of the
/// other factors.
const TOLD_BY_VOLUME: [(&str, f64); 4] = [("volume_weight", 1.0), ("c4", 0.0), ("c5", 0.0), ("c6", 0.0)];

/// Whether the volume changes at all within the segments.
fn volume_changes(series: &Series) -> bool {
    let mut rows = series.segments().iter().flat_map(Clone::clone);
    rows.any(|row| series.row(row)[column::VOLUME_RATE_M3_S].abs() > 0.0)
}
