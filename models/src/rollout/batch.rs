//! Thousands of rollouts at once.

use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use super::columns::{BLOCK, LINE};
use super::{BatchInputs, Steps, System, rollout};
use crate::model::column;
use crate::numeric::{Dual, Lanes, Scalar};

/// Rollouts in lockstep without sensitivities; batches of multiples of it leave no lane empty.
///
/// Four 512-bit vectors: a Runge-Kutta step is one chain of operations, and one or two vectors would wait for each result. What
/// bounds it then are the square roots (docs/performance.md).
pub const BATCH_LANES: usize = 32;

/// Rollouts in lockstep when sensitivities are computed too: a dual number is long already.
const SENSITIVITY_LANES: usize = 4;

/// Sensitivities computed in one pass; more parameters take more passes.
const DIRECTIONS: usize = 8;

/// One rollout of a batch; its inputs are in [`BatchInputs`].
#[derive(Debug, Clone, Copy)]
pub struct Job<'a, const M: usize> {
    /// Parameters in the order and units of [`System::parameters`].
    pub parameters: &'a [f64],
    /// Absolute pressures at the first row, Pa.
    pub start: [f64; M],
}

/// What a batch gives.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchOutput<const M: usize> {
    /// Rows per rollout.
    pub samples: usize,
    /// Number of parameters.
    pub parameters: usize,
    /// Absolute pressures in Pa, `[rollout][sample]`.
    pub outputs: Vec<[f64; M]>,
    /// Their derivatives by the parameters, `[rollout][sample][parameter]`, in Pa per unit of the parameter; empty unless asked for.
    pub sensitivities: Vec<[f64; M]>,
}

impl<const M: usize> BatchOutput<M> {
    /// The outputs of one rollout, one entry per sample.
    #[must_use]
    pub fn rollout(&self, job: usize) -> &[[f64; M]] {
        &self.outputs[job * self.samples..][..self.samples]
    }

    /// The derivatives at one sample of one rollout, one entry per parameter.
    #[must_use]
    pub fn sensitivity(&self, job: usize, sample: usize) -> &[[f64; M]] {
        &self.sensitivities[(job * self.samples + sample) * self.parameters..][..self.parameters]
    }
}

/// Why a batch cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// Jobs and inputs are not equally many.
    #[error("{jobs} rollouts, but inputs of {inputs}")]
    Jobs {
        /// Rollouts.
        jobs: usize,
        /// Rollouts there are inputs for.
        inputs: usize,
    },
    /// Too few columns.
    #[error("{columns} input columns; there must be {least} at least", least = column::COUNT)]
    Columns {
        /// Columns given.
        columns: usize,
    },
    /// A column of the wrong size.
    #[error("input column {column} has {found} values, expected {expected}")]
    Values {
        /// The column.
        column: usize,
        /// Values expected.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// A value that its column does not allow.
    #[error("input column {column} is {value} at row {row} of rollout {job}")]
    Range {
        /// The column.
        column: usize,
        /// The rollout; 0 if they share the column.
        job: usize,
        /// The row; 0 if they share the value.
        row: usize,
        /// The value, as given.
        value: f64,
    },
    /// Memory for the results that is too small or too large.
    #[error("room for {found} values of the results, expected {expected}")]
    Results {
        /// Values expected.
        expected: usize,
        /// Values there is room for.
        found: usize,
    },
    /// A job has the wrong number of parameters.
    #[error("job {job} has {found} parameters, the system has {expected}")]
    Parameters {
        /// The job.
        job: usize,
        /// Parameters of the system.
        expected: usize,
        /// Parameters of the job.
        found: usize,
    },
}

/// Simulates all jobs; `substeps` Runge-Kutta steps are made per tick.
///
/// # Errors
/// Inputs for another number of jobs, a wrong number of parameters.
pub fn simulate_batch<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    jobs: &[Job<'_, M>],
    inputs: &BatchInputs<'_>,
    substeps: usize,
    sensitivities: bool,
) -> Result<BatchOutput<M>, BatchError> {
    let (samples, parameters) = (inputs.rows(), system.parameters().len());
    let values = jobs.len() * samples;
    let mut batch = BatchOutput {
        samples,
        parameters,
        outputs: vec![[0.0; M]; values],
        sensitivities: vec![[0.0; M]; if sensitivities { values * parameters } else { 0 }],
    };
    let results = BatchResults {
        outputs: &mut batch.outputs,
        sensitivities: sensitivities.then_some(&mut batch.sensitivities),
        unit: BatchUnit::PASCAL,
    };
    simulate_batch_into(system, jobs, inputs, substeps, results)?;
    Ok(batch)
}

/// What pressures are counted in: `(p - zero_pa) per_pa` of an absolute pressure `p` in Pa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchUnit {
    /// Absolute pressure that counts as 0, Pa.
    pub zero_pa: f64,
    /// Units in a Pa.
    pub per_pa: f64,
}

impl BatchUnit {
    /// Absolute, Pa.
    pub const PASCAL: Self = Self { zero_pa: 0.0, per_pa: 1.0 };
}

/// Where the results of a batch go.
#[derive(Debug)]
pub struct BatchResults<'a, const M: usize> {
    /// Pressures, `[rollout][sample]`.
    pub outputs: &'a mut [[f64; M]],
    /// If asked for, their derivatives by the parameters, `[rollout][sample][parameter]`.
    pub sensitivities: Option<&'a mut [[f64; M]]>,
    /// Unit of both.
    pub unit: BatchUnit,
}

/// As [`simulate_batch`], in lockstep lanes and on all threads of the current rayon pool, into memory of the caller's. Each thread
/// writes its own part of it, in the unit that is wanted: another pass over so much memory would take as long as the simulation.
///
/// # Errors
/// As there, and [`BatchError::Results`] when the memory does not fit. After [`BatchError::Range`] some results are written.
pub fn simulate_batch_into<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    jobs: &[Job<'_, M>],
    inputs: &BatchInputs<'_>,
    substeps: usize,
    results: BatchResults<'_, M>,
) -> Result<(), BatchError> {
    let parameters = system.parameters().len();
    if jobs.len() != inputs.jobs() {
        return Err(BatchError::Jobs { jobs: jobs.len(), inputs: inputs.jobs() });
    }
    for (job, Job { parameters: given, .. }) in jobs.iter().enumerate() {
        if given.len() != parameters {
            return Err(BatchError::Parameters { job, expected: parameters, found: given.len() });
        }
    }
    let samples = inputs.rows();
    let BatchResults { outputs, sensitivities, unit } = results;
    let expected = jobs.len() * samples;
    let room = [(outputs.len(), expected)].into_iter();
    let more = sensitivities.as_ref().map(|derivatives| (derivatives.len(), expected * parameters));
    if let Some((found, expected)) = room.chain(more).find(|(found, expected)| found != expected) {
        return Err(BatchError::Results { expected, found });
    }
    if samples == 0 || jobs.is_empty() {
        return Ok(());
    }
    let steps = Steps { ticks: system.ticks(inputs.value(0, 0, column::INTERVAL_S)), substeps };
    let possible = if let Some(sensitivities) = sensitivities {
        let outputs = outputs.par_chunks_mut(SENSITIVITY_LANES * samples);
        let derivatives = sensitivities.par_chunks_mut(SENSITIVITY_LANES * samples * parameters);
        jobs.par_chunks(SENSITIVITY_LANES).zip(outputs).zip(derivatives).enumerate().all(
            |(chunk, ((jobs, outputs), derivatives))| {
                let lot = Lot { jobs, inputs, first: chunk * SENSITIVITY_LANES, steps, unit };
                (0..parameters)
                    .step_by(DIRECTIONS)
                    .all(|from| roll_duals(system, lot, from, outputs, derivatives))
            },
        )
    } else {
        let outputs = outputs.par_chunks_mut(BATCH_LANES * samples);
        jobs.par_chunks(BATCH_LANES).zip(outputs).enumerate().all(|(chunk, (jobs, outputs))| {
            roll_lanes(system, Lot { jobs, inputs, first: chunk * BATCH_LANES, steps, unit }, outputs)
        })
    };
    if possible { Ok(()) } else { inputs.check_late() }
}

/// Jobs that are rolled out side by side.
#[derive(Clone, Copy)]
struct Lot<'a, const M: usize> {
    jobs: &'a [Job<'a, M>],
    inputs: &'a BatchInputs<'a>,
    /// Number of the first job.
    first: usize,
    steps: Steps,
    unit: BatchUnit,
}

#[inline(always)]
fn lanes_of<const L: usize, const M: usize>(
    jobs: &[Job<'_, M>],
    value: impl Fn(&Job<'_, M>) -> f64,
) -> Lanes<L> {
    Lanes(std::array::from_fn(|lane| value(&jobs[lane.min(jobs.len() - 1)])))
}

/// Returns whether all inputs were possible.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn roll_lanes<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    Lot { jobs, inputs, first, steps, unit }: Lot<'_, M>,
    outputs: &mut [[f64; M]],
) -> bool {
    let count = jobs[0].parameters.len();
    let parameters: Vec<Lanes<BATCH_LANES>> =
        (0..count).map(|i| lanes_of(jobs, |job| job.parameters[i])).collect();
    let start = std::array::from_fn(|i| lanes_of(jobs, |job| job.start[i]));
    let samples = outputs.len() / jobs.len();
    let mut source = inputs.lanes::<BATCH_LANES>(first);
    let mut block = [[Lanes([0.0; BATCH_LANES]); M]; BLOCK];
    rollout(
        system,
        &system.coefficients(&parameters),
        (&mut source, samples),
        start,
        steps,
        #[inline(always)]
        |k, y| {
            for (kept, read) in block[k % BLOCK].iter_mut().zip(y) {
                *kept = read.plus(-unit.zero_pa).times(unit.per_pa);
            }
            if k % BLOCK == BLOCK - 1 || k + 1 == samples {
                write_block(&block, outputs, samples, k - k % BLOCK..k + 1);
            }
        },
    );
    source.possible()
}

/// Writes some rows of all lanes, at most a block, to the rollouts, of `samples` rows each.
///
/// Rows of all lanes become rows of each lane block by block: single values, each to a rollout of its own, would meet in the same few
/// sets of the cache. Plain loops, since `array::map` is left as a function of its own, compiled for the oldest processor.
#[inline(always)]
fn write_block<const L: usize, const M: usize>(
    block: &[[Lanes<L>; M]; BLOCK],
    outputs: &mut [[f64; M]],
    samples: usize,
    rows: Range<usize>,
) {
    for (lane, rollout) in outputs.chunks_exact_mut(samples).enumerate() {
        let (lines, rest) = rollout[rows.clone()].as_chunks_mut::<LINE>();
        let (blocks, last) = block[..rows.len()].as_chunks::<LINE>();
        for (line, rows) in lines.iter_mut().zip(blocks) {
            for i in 0..LINE {
                for j in 0..M {
                    line[i][j] = rows[i][j].0[lane];
                }
            }
        }
        for (value, row) in rest.iter_mut().zip(last) {
            for j in 0..M {
                value[j] = row[j].0[lane];
            }
        }
    }
}

/// Derivatives by the parameters `from..from + DIRECTIONS`. Returns whether all inputs were possible.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn roll_duals<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    Lot { jobs, inputs, first, steps, unit }: Lot<'_, M>,
    from: usize,
    outputs: &mut [[f64; M]],
    derivatives: &mut [[f64; M]],
) -> bool {
    type Number = Dual<Lanes<SENSITIVITY_LANES>, DIRECTIONS>;
    let count = jobs[0].parameters.len();
    let parameters: Vec<Number> = (0..count)
        .map(|i| Dual::variable(lanes_of(jobs, |job| job.parameters[i]), i.wrapping_sub(from)))
        .collect();
    let start = std::array::from_fn(|i| Number::from_real(lanes_of(jobs, |job| job.start[i])));
    let samples = outputs.len() / jobs.len();
    let mut source = inputs.lanes::<SENSITIVITY_LANES>(first);
    let directions = from..count.min(from + DIRECTIONS);
    rollout(
        system,
        &system.coefficients(&parameters),
        (&mut source, samples),
        start,
        steps,
        #[inline(always)]
        |k, y| {
            for job in 0..jobs.len() {
                outputs[job * samples + k] =
                    y.map(|number| (number.value.0[job] - unit.zero_pa) * unit.per_pa);
                for i in directions.clone() {
                    derivatives[(job * samples + k) * count + i] =
                        y.map(|number| number.gradient[i - from].0[job] * unit.per_pa);
                }
            }
        },
    );
    source.possible()
}
