//! Rollouts in lockstep: compiled for processors with wide vectors, and chosen when the program
//! runs.

use std::ops::Range;

use multiversion::multiversion;
use multiversion::target::match_target;

use super::fetch::{BLOCK, LINE};
use super::job::{BATCH_LANES, BatchUnit, Job, SINGLE_LANES};
use super::run::rollout;
use super::source::{RowSource, Steps};
use super::{BatchInputs, Chamber};
use crate::model::Model;
use crate::numeric::{Float, Lanes, Scalar};

/// Jobs of a batch that are rolled out side by side.
#[derive(Debug, Clone, Copy)]
pub struct Lot<'a> {
    pub(super) jobs: &'a [Job<'a>],
    pub(super) inputs: &'a BatchInputs<'a>,
    /// Number of the first job.
    pub(super) first: usize,
    pub(super) steps: Steps,
    pub(super) unit: BatchUnit,
}

/// One value of each job; spare lanes repeat the last.
#[inline(always)]
pub(super) fn lanes_of<const L: usize, T: Float>(
    jobs: &[Job<'_>],
    value: impl Fn(&Job<'_>) -> f64,
) -> Lanes<L, T> {
    Lanes(std::array::from_fn(|lane| T::from_f64(value(&jobs[lane.min(jobs.len() - 1)]))))
}

/// Simulates a lot. Returns whether all inputs were possible.
///
/// Without wide vectors lanes gain little, so that there is no such version for the oldest
/// processors.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn roll_lot<Q: Model>(chamber: &Chamber<Q>, lot: Lot<'_>, outputs: &mut [f64]) -> bool {
    match_target! {
        "x86_64+avx512f" => side_by_side::<_, BATCH_LANES, _>(chamber, lot, outputs),
        "x86_64+avx2" => side_by_side::<_, BATCH_LANES, _>(chamber, lot, outputs),
        "x86_64" => one_by_one(chamber, lot, outputs),
        _ => side_by_side::<_, BATCH_LANES, _>(chamber, lot, outputs),
    }
}

/// The same in single precision; on the oldest processors in double, and rounded.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn roll_lot_single<Q: Model>(chamber: &Chamber<Q>, lot: Lot<'_>, outputs: &mut [f32]) -> bool {
    match_target! {
        "x86_64+avx512f" => side_by_side::<_, SINGLE_LANES, _>(chamber, lot, outputs),
        "x86_64+avx2" => side_by_side::<_, SINGLE_LANES, _>(chamber, lot, outputs),
        "x86_64" => one_by_one_rounded(chamber, lot, outputs),
        _ => side_by_side::<_, SINGLE_LANES, _>(chamber, lot, outputs),
    }
}

#[inline(always)]
fn side_by_side<Q: Model, const L: usize, T: Float>(
    chamber: &Chamber<Q>,
    Lot { jobs, inputs, first, steps, unit }: Lot<'_>,
    outputs: &mut [T],
) -> bool {
    let count = jobs[0].parameters.len();
    let parameters: Vec<Lanes<L, T>> = (0..count).map(|i| lanes_of(jobs, |job| job.parameters[i])).collect();
    let samples = outputs.len() / jobs.len();
    let mut source = inputs.lanes::<L, T>(first);
    let mut block = [Lanes([T::ZERO; L]); BLOCK];
    rollout(
        chamber,
        &chamber.model.coefficients(&parameters),
        (&mut source, samples),
        lanes_of(jobs, |job| job.start),
        steps,
        #[inline(always)]
        |k, y| {
            block[k % BLOCK] = y.plus(-unit.zero_pa).times(unit.per_pa);
            if k % BLOCK == BLOCK - 1 || k + 1 == samples {
                write_block(&block, outputs, samples, k - k % BLOCK..k + 1);
            }
        },
    );
    source.possible()
}

#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))] // other processors have vectors
fn one_by_one<Q: Model>(
    chamber: &Chamber<Q>,
    Lot { jobs, inputs, first, steps, unit }: Lot<'_>,
    outputs: &mut [f64],
) -> bool {
    let samples = outputs.len() / jobs.len();
    for (lane, (job, outputs)) in jobs.iter().zip(outputs.chunks_exact_mut(samples)).enumerate() {
        let mut source = inputs.job(first + lane);
        plain(chamber, job.parameters, (&mut source, samples), job.start, steps, outputs);
        for pressure in outputs {
            *pressure = (*pressure - unit.zero_pa) * unit.per_pa;
        }
    }
    inputs.check_late().is_ok()
}

#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))] // other processors have vectors
#[allow(clippy::cast_possible_truncation)] // what is asked for
fn one_by_one_rounded<Q: Model>(chamber: &Chamber<Q>, lot: Lot<'_>, outputs: &mut [f32]) -> bool {
    let mut double = vec![0.0; outputs.len()];
    let possible = one_by_one(chamber, lot, &mut double);
    for (rounded, pressure) in outputs.iter_mut().zip(double) {
        *rounded = pressure as f32;
    }
    possible
}

/// Writes some rows of all lanes, at most a block, to the rollouts, of `samples` rows each.
///
/// Rows of all lanes become rows of each lane block by block: single values, each to a rollout of
/// its own, would meet in the same few sets of the cache. Plain loops, since `array::map` is left
/// as a function of its own, compiled for the oldest processor.
#[inline(always)]
fn write_block<const L: usize, T: Float>(
    block: &[Lanes<L, T>; BLOCK],
    outputs: &mut [T],
    samples: usize,
    rows: Range<usize>,
) {
    for (lane, rollout) in outputs.chunks_exact_mut(samples).enumerate() {
        let (lines, rest) = rollout[rows.clone()].as_chunks_mut::<LINE>();
        let (blocks, last) = block[..rows.len()].as_chunks::<LINE>();
        for (line, rows) in lines.iter_mut().zip(blocks) {
            for i in 0..LINE {
                line[i] = rows[i].0[lane];
            }
        }
        for (value, row) in rest.iter_mut().zip(last) {
            *value = row.0[lane];
        }
    }
}

/// One rollout over plain numbers.
#[inline(never)]
pub(super) fn plain<Q: Model>(
    chamber: &Chamber<Q>,
    parameters: &[f64],
    source: (impl RowSource<f64>, usize),
    pressure: f64,
    steps: Steps,
    outputs: &mut [f64],
) {
    let coefficients = chamber.model.coefficients(parameters);
    rollout(chamber, &coefficients, source, pressure, steps, |k, y| outputs[k] = y);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Nonlinear, column, nominal_values};
    use crate::rollout::BatchColumn;

    const ROWS: usize = 50;
    const JOBS: usize = 5;

    /// What old processors do is what wide vectors do, to the bit, in any unit.
    #[test]
    fn one_by_one_jobs_give_what_they_give_side_by_side() {
        let chamber = Chamber::new(Nonlinear::default());
        let nominal = nominal_values(&chamber.model.parameters());
        let drive: Vec<f64> = (0..JOBS * ROWS).map(|k| 0.5 * (0.3 * k as f64).sin()).collect();
        let supply_kpa: Vec<f64> = (0..JOBS).map(|job| 400.0 + job as f64).collect();
        let mut columns = vec![BatchColumn::constant(0.0); column::COUNT];
        columns[column::INTERVAL_S] = BatchColumn::constant(0.01);
        columns[column::INVERSE_VOLUME_PER_M3] = BatchColumn::constant(1.0 / 3.6e-4);
        columns[column::SUPPLY_PA] = BatchColumn::per_job(&supply_kpa).scaled(1e3, 101_325.0);
        columns[column::FILL] = BatchColumn::per_job_and_row(&drive).within([-1.0, 1.0]);
        columns[column::VENT] = BatchColumn::per_job_and_row(&drive).scaled(-1.0, 0.0);
        let inputs = BatchInputs::new(columns, JOBS, ROWS).unwrap();
        let jobs = vec![Job { parameters: &nominal, start: 2e5 }; JOBS];
        let lot = Lot {
            jobs: &jobs,
            inputs: &inputs,
            first: 0,
            steps: Steps { ticks: 1, substeps: 2 },
            unit: BatchUnit { zero_pa: 101_325.0, per_pa: 1e-3 },
        };
        let (mut together, mut alone) = (vec![0.0_f64; JOBS * ROWS], vec![0.0; JOBS * ROWS]);
        assert!(
            side_by_side::<_, BATCH_LANES, _>(&chamber, lot, &mut together)
                && one_by_one(&chamber, lot, &mut alone)
        );
        assert!(together.iter().any(|kpa| (kpa - together[0]).abs() > 10.0), "nothing moves");
        assert_eq!(together, alone);
    }

    #[test]
    fn one_by_one_an_impossible_input_is_seen_too() {
        let chamber = Chamber::new(Nonlinear::default());
        let nominal = nominal_values(&chamber.model.parameters());
        let mut drive = vec![0.5; ROWS];
        drive[7] = 1.5;
        let mut columns = vec![BatchColumn::constant(1.0); column::COUNT];
        columns[column::FILL] = BatchColumn::per_job_and_row(&drive).within([-1.0, 1.0]);
        let inputs = BatchInputs::new(columns, 1, ROWS).unwrap();
        let jobs = [Job { parameters: &nominal, start: 2e5 }];
        let steps = Steps { ticks: 1, substeps: 1 };
        let lot = Lot { jobs: &jobs, inputs: &inputs, first: 0, steps, unit: BatchUnit::PASCAL };
        assert!(!one_by_one(&chamber, lot, &mut vec![0.0; ROWS]));
    }
}
