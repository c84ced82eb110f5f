//! One interval of a rollout with derivatives by everything that it depends on.

use multiversion::multiversion;

use super::Chamber;
use super::board::LoopMemory;
use super::kinds::{DIRECTIONS, SENSITIVITY_LANES};
use super::run::rk4_change;
use super::source::Steps;
use crate::model::{Model, column};
use crate::numeric::{Active, Lanes, Scalar};

/// Rollouts in lockstep with derivatives by inputs, parameters and states.
pub type ActiveLanes = Active<Lanes<SENSITIVITY_LANES>, DIRECTIONS>;

/// Where a chamber stands at a row, and what is measured there.
#[derive(Debug, Clone, Copy)]
pub struct RowState {
    /// Absolute pressure in the chamber, Pa.
    pub pressure: ActiveLanes,
    /// The board's filtered sample, counts.
    pub filtered: ActiveLanes,
    /// The command of the row before, absolute, Pa.
    pub command: ActiveLanes,
    /// What is recorded, absolute, Pa.
    pub reading: ActiveLanes,
}

/// An interval to be simulated.
#[derive(Debug, Clone)]
pub struct Interval {
    /// Inputs of its row, laid out as in [`mod@column`].
    pub row: Vec<ActiveLanes>,
    /// Where it starts; the reading is of no account.
    pub state: RowState,
    /// Is it the first of its rollout? What the board remembers then follows from the pressure.
    pub first: bool,
}

/// Simulates intervals one by one, in any order: `next` fills one in, or says that there are no
/// more; `done` gets what is measured at its start, and where it ends.
pub trait Intervals {
    /// Whether there is another one.
    fn next(&mut self, interval: &mut Interval) -> bool;

    /// Where the interval starts, with the reading there, and where it ends.
    fn done(&mut self, start: &RowState, end: &RowState);
}

/// Simulates intervals of a chamber.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn simulate_intervals<Q: Model>(
    chamber: &Chamber<Q>,
    parameters: &[ActiveLanes],
    steps: Steps,
    intervals: &mut dyn Intervals,
) {
    let coefficients = chamber.model.coefficients(parameters);
    #[allow(clippy::cast_precision_loss)] // a handful of steps
    let share = 1.0 / (steps.ticks * steps.substeps) as f64;
    let zero = ActiveLanes::constant(0.0);
    let state = RowState { pressure: zero, filtered: zero, command: zero, reading: zero };
    let mut interval = Interval { row: vec![zero; column::COUNT], state, first: false };
    while intervals.next(&mut interval) {
        let Interval { ref row, state: mut start, first } = interval;
        let mut memory = if first {
            chamber.start(row, start.pressure)
        } else {
            LoopMemory::resumed(start.filtered, start.command)
        };
        start.reading = chamber.measure(start.pressure, &memory);
        let mut pressure = start.pressure;
        let h = row[column::INTERVAL_S].times(share);
        for tick in 0..steps.ticks {
            let held = chamber.hold(&coefficients, row, tick, pressure, &mut memory);
            for _ in 0..steps.substeps {
                pressure = pressure + rk4_change(&chamber.model, &coefficients, &held, pressure, h);
            }
        }
        let [filtered, command] = memory.state();
        intervals.done(&start, &RowState { pressure, filtered, command, reading: zero });
    }
}
