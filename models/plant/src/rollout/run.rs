//! Fixed-step Runge-Kutta rollouts.

use super::Chamber;
use super::board::LoopMemory;
use super::source::{RowSource, Steps};
use crate::model::{Model, column};
use crate::numeric::Scalar;

/// Stages of a Runge-Kutta step.
const STAGES: usize = 4;

/// The change of the pressure over one classical fourth-order Runge-Kutta step of length `h` (s).
///
/// A loop, so that the model's rate is compiled once and not once a stage: with derivatives or in
/// lanes it is thousands of instructions.
#[inline(always)]
pub(super) fn rk4_change<S: Scalar, Q: Model>(
    model: &Q,
    coefficients: &Q::Coefficients<S>,
    held: &Q::Held<S>,
    pressure: S,
    h: S::Real,
) -> S {
    let half = h.times(0.5);
    let mut slopes = [S::zero(); STAGES];
    let mut point = pressure;
    for stage in 0..STAGES {
        slopes[stage] = model.rate(coefficients, held, point);
        point = pressure + slopes[stage].scale(if stage < 2 { half } else { h });
    }
    let [k1, k2, k3, k4] = slopes;
    ((k1 + k4) + (k2 + k3).times(2.0)).scale(h.times(1.0 / 6.0))
}

/// Advances a chamber over the interval of `row` from a pressure (absolute, Pa), beside which
/// stands what its sum has lost.
///
/// The interval is divided into the chamber's [`ticks`](Chamber::ticks); at the start of each the
/// board, if there is one, sees the pressure and holds a drive.
#[inline(always)]
pub(super) fn advance<S: Scalar, Q: Model>(
    chamber: &Chamber<Q>,
    coefficients: &Q::Coefficients<S>,
    row: &[S::Real],
    steps: Steps,
    (pressure, lost): (&mut S, &mut S),
    memory: &mut LoopMemory<S>,
) {
    #[allow(clippy::cast_precision_loss)] // a handful of steps
    let share = 1.0 / (steps.ticks * steps.substeps) as f64;
    let h = row[column::INTERVAL_S].times(share);
    for tick in 0..steps.ticks {
        let held = chamber.hold(coefficients, row, tick, *pressure, memory);
        for _ in 0..steps.substeps {
            let change = rk4_change(&chamber.model, coefficients, &held, *pressure, h);
            *pressure = pressure.accumulate(change, lost);
        }
    }
}

/// Rolls a chamber out over `count` rows, starting from `pressure` (absolute, Pa); `sink` gets each
/// row's number and what is recorded there.
///
/// This is the one loop behind every simulation and fit; the [`System`](super::System) chooses the
/// numbers it runs over. It is compiled for each of them and for each model: call it through that.
#[inline(always)]
pub fn rollout<S: Scalar, Q: Model>(
    chamber: &Chamber<Q>,
    coefficients: &Q::Coefficients<S>,
    (mut source, count): (impl RowSource<S::Real>, usize),
    pressure: S,
    steps: Steps,
    mut sink: impl FnMut(usize, S),
) {
    if count == 0 {
        return;
    }
    let mut memory = chamber.start(source.row(0), pressure);
    let mut pressure = pressure;
    let mut lost = S::zero();
    for k in 0..count {
        let row = source.row(k);
        sink(k, chamber.measure(pressure, &memory));
        if k + 1 < count {
            advance(chamber, coefficients, row, steps, (&mut pressure, &mut lost), &mut memory);
        }
    }
}
