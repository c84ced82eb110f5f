//! Thousands of rollouts at once.

use super::job::{BATCH_LANES, BatchError, BatchUnit, Job, SINGLE_LANES};
use super::kinds::{DIRECTIONS, DualLanes, LaneRollout, SENSITIVITY_LANES};
use super::lanes::{Lot, lanes_of};
use super::source::Steps;
use super::{BatchInputs, System};
use crate::model::column;
use crate::numeric::{Dual, Scalar};
use crate::parallel;

/// What a batch gives.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchOutput {
    /// Rows per rollout.
    pub samples: usize,
    /// Number of parameters.
    pub parameters: usize,
    /// Absolute pressures in Pa, `[rollout][sample]`.
    pub outputs: Vec<f64>,
    /// Their derivatives by the parameters, `[rollout][sample][parameter]`, in Pa per unit of the
    /// parameter; empty unless asked for.
    pub sensitivities: Vec<f64>,
}

impl BatchOutput {
    /// The outputs of one rollout, one entry per sample.
    #[must_use]
    pub fn rollout(&self, job: usize) -> &[f64] {
        &self.outputs[job * self.samples..][..self.samples]
    }

    /// The derivatives at one sample of one rollout, one entry per parameter.
    #[must_use]
    pub fn sensitivity(&self, job: usize, sample: usize) -> &[f64] {
        &self.sensitivities[(job * self.samples + sample) * self.parameters..][..self.parameters]
    }
}

/// Simulates all jobs; `substeps` Runge-Kutta steps are made per tick.
///
/// # Errors
/// Inputs for another number of jobs, a wrong number of parameters.
pub fn simulate_batch(
    system: &dyn System,
    jobs: &[Job<'_>],
    inputs: &BatchInputs<'_>,
    substeps: usize,
    sensitivities: bool,
) -> Result<BatchOutput, BatchError> {
    let (samples, parameters) = (inputs.rows(), system.parameters().len());
    let values = jobs.len() * samples;
    let mut batch = BatchOutput {
        samples,
        parameters,
        outputs: vec![0.0; values],
        sensitivities: vec![0.0; if sensitivities { values * parameters } else { 0 }],
    };
    let results = BatchResults {
        outputs: &mut batch.outputs,
        sensitivities: sensitivities.then_some(&mut batch.sensitivities),
        unit: BatchUnit::PASCAL,
    };
    simulate_batch_into(system, jobs, inputs, substeps, results)?;
    Ok(batch)
}

/// Where the results of a batch go.
#[derive(Debug)]
pub struct BatchResults<'a> {
    /// Pressures, `[rollout][sample]`.
    pub outputs: &'a mut [f64],
    /// If asked for, their derivatives by the parameters, `[rollout][sample][parameter]`.
    pub sensitivities: Option<&'a mut [f64]>,
    /// Unit of both.
    pub unit: BatchUnit,
}

/// As [`simulate_batch`], in lockstep lanes and on all threads of the current rayon pool, into
/// memory of the caller's. Each thread writes its own part of it, in the unit that is wanted:
/// another pass over so much memory would take as long as the simulation.
///
/// # Errors
/// As there, and [`BatchError::Results`] when the memory does not fit. After [`BatchError::Range`]
/// some results are written.
pub fn simulate_batch_into(
    system: &dyn System,
    jobs: &[Job<'_>],
    inputs: &BatchInputs<'_>,
    substeps: usize,
    results: BatchResults<'_>,
) -> Result<(), BatchError> {
    let parameters = system.parameters().len();
    let samples = inputs.rows();
    let BatchResults { outputs, sensitivities, unit } = results;
    check(parameters, jobs, inputs, outputs.len())?;
    if let Some(derivatives) = &sensitivities {
        let (expected, found) = (outputs.len() * parameters, derivatives.len());
        if expected != found {
            return Err(BatchError::Results { expected, found });
        }
    }
    if samples == 0 || jobs.is_empty() {
        return Ok(());
    }
    let steps = steps_of(system, inputs, substeps);
    let possible = if let Some(sensitivities) = sensitivities {
        let outputs = outputs.chunks_mut(SENSITIVITY_LANES * samples);
        let derivatives = sensitivities.chunks_mut(SENSITIVITY_LANES * samples * parameters);
        let lots = jobs.chunks(SENSITIVITY_LANES).zip(outputs).zip(derivatives).enumerate();
        parallel::map(lots, |(chunk, ((jobs, outputs), derivatives))| {
            let lot = Lot { jobs, inputs, first: chunk * SENSITIVITY_LANES, steps, unit };
            (0..parameters)
                .step_by(DIRECTIONS)
                .all(|from| sensitivities_of(system, lot, from, outputs, derivatives))
        })
    } else {
        let outputs = outputs.chunks_mut(BATCH_LANES * samples);
        parallel::map(jobs.chunks(BATCH_LANES).zip(outputs).enumerate(), |(chunk, (jobs, outputs))| {
            system.simulate_lot(Lot { jobs, inputs, first: chunk * BATCH_LANES, steps, unit }, outputs)
        })
    };
    if possible.into_iter().all(|possible| possible) { Ok(()) } else { inputs.check_late() }
}

/// The pressures of [`simulate_batch_into`] in single precision: twice as many at a time, in half
/// of the memory. Sums are compensated, so that they stay within 0.02 kPa of double precision over
/// 20,000 rows; inputs may be in either precision.
///
/// # Errors
/// As there.
pub fn simulate_batch_single_into(
    system: &dyn System,
    jobs: &[Job<'_>],
    inputs: &BatchInputs<'_>,
    substeps: usize,
    outputs: &mut [f32],
    unit: BatchUnit,
) -> Result<(), BatchError> {
    check(system.parameters().len(), jobs, inputs, outputs.len())?;
    if outputs.is_empty() {
        return Ok(());
    }
    let steps = steps_of(system, inputs, substeps);
    let outputs = outputs.chunks_mut(SINGLE_LANES * inputs.rows());
    let lots = jobs.chunks(SINGLE_LANES).zip(outputs).enumerate();
    let possible = parallel::map(lots, |(chunk, (jobs, outputs))| {
        let lot = Lot { jobs, inputs, first: chunk * SINGLE_LANES, steps, unit };
        system.simulate_lot_single(lot, outputs)
    });
    if possible.into_iter().all(|possible| possible) { Ok(()) } else { inputs.check_late() }
}

/// Whether jobs and inputs belong together, and there is room for `found` pressures.
///
/// # Errors
/// Inputs for another number of jobs, a wrong number of parameters, [`BatchError::Results`].
pub fn check(
    parameters: usize,
    jobs: &[Job<'_>],
    inputs: &BatchInputs<'_>,
    found: usize,
) -> Result<(), BatchError> {
    if jobs.len() != inputs.jobs() {
        return Err(BatchError::Jobs { jobs: jobs.len(), inputs: inputs.jobs() });
    }
    for (job, Job { parameters: given, .. }) in jobs.iter().enumerate() {
        if given.len() != parameters {
            return Err(BatchError::Parameters { job, expected: parameters, found: given.len() });
        }
    }
    let expected = jobs.len() * inputs.rows();
    if found == expected { Ok(()) } else { Err(BatchError::Results { expected, found }) }
}

pub(super) fn steps_of(system: &dyn System, inputs: &BatchInputs<'_>, substeps: usize) -> Steps {
    Steps { ticks: system.ticks(inputs.value(0, 0, column::INTERVAL_S)), substeps }
}

/// Derivatives by the parameters `from..from + DIRECTIONS`. Returns whether all inputs were
/// possible.
fn sensitivities_of(
    system: &dyn System,
    Lot { jobs, inputs, first, steps, unit }: Lot<'_>,
    from: usize,
    outputs: &mut [f64],
    derivatives: &mut [f64],
) -> bool {
    let count = jobs[0].parameters.len();
    let parameters: Vec<DualLanes> = (0..count)
        .map(|i| Dual::variable(lanes_of(jobs, |job| job.parameters[i]), i.wrapping_sub(from)))
        .collect();
    let samples = outputs.len() / jobs.len();
    let mut source = inputs.lanes::<SENSITIVITY_LANES, f64>(first);
    let directions = from..count.min(from + DIRECTIONS);
    let rollout = LaneRollout {
        parameters: &parameters,
        rows: &mut source,
        count: samples,
        pressure: DualLanes::from_real(lanes_of(jobs, |job| job.start)),
        steps,
    };
    system.simulate_lanes(rollout, &mut |rows, block| {
        for (k, number) in rows.zip(block) {
            for job in 0..jobs.len() {
                outputs[job * samples + k] = (number.value.0[job] - unit.zero_pa) * unit.per_pa;
                let row = &mut derivatives[(job * samples + k) * count..][directions.clone()];
                for (derivative, slope) in row.iter_mut().zip(&number.gradient) {
                    *derivative = slope.0[job] * unit.per_pa;
                }
            }
        }
    });
    source.possible()
}
