//! Derivatives of a weighted sum of a batch's pressures by everything that they follow from.

use super::batch::{check, steps_of};
use super::interval::{ActiveLanes, Interval, Intervals, RowState};
use super::kinds::{DIRECTIONS, SENSITIVITY_LANES};
use super::lanes::lanes_of;
use super::{BatchError, BatchInputs, Job, Steps, System};
use crate::model::column;
use crate::numeric::{Active, Dual, Lanes, Scalar};
use crate::parallel;

/// Inputs that have an effect, in the order of [`BatchGradient::inputs`].
pub const DIFFERENTIATED: [usize; 6] = [
    column::FILL,
    column::VENT,
    column::COMMAND_PA,
    column::SUPPLY_PA,
    column::INVERSE_VOLUME_PER_M3,
    column::VOLUME_RATE_M3_S,
];

/// Derivatives of `sum(weight * pressure)` over a batch's rows, pressures absolute in Pa.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchGradient {
    /// By the parameters, `[rollout][parameter]`.
    pub parameters: Vec<f64>,
    /// By the pressures at the first rows, `[rollout]`.
    pub start: Vec<f64>,
    /// By the inputs of [`DIFFERENTIATED`], each `[rollout][row]`.
    pub inputs: [Vec<f64>; DIFFERENTIATED.len()],
}

/// What an interval is differentiated by.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Direction {
    Pressure,
    Filtered,
    /// The command of the row before, which the first loop of an interval still has.
    Command,
    Input(usize),
    Parameter(usize),
}

/// Derivatives of `sum(weight * pressure)` by reverse accumulation, exact for the discretised
/// model: one pass over the rows backwards for every [`DIRECTIONS`] things. `weights` has an entry
/// `[rollout][row]`.
///
/// Rounding in a board's loop passes derivatives through; where drives are clipped they are zero.
///
/// # Errors
/// As [`simulate_batch`](super::simulate_batch).
pub fn batch_gradient(
    system: &dyn System,
    jobs: &[Job<'_>],
    inputs: &BatchInputs<'_>,
    substeps: usize,
    weights: &[f64],
) -> Result<BatchGradient, BatchError> {
    let parameters = system.parameters().len();
    check(parameters, jobs, inputs, weights.len())?;
    inputs.check_late()?;
    let rows = inputs.rows();
    let mut gradient = BatchGradient {
        parameters: vec![0.0; jobs.len() * parameters],
        start: vec![0.0; jobs.len()],
        inputs: std::array::from_fn(|_| vec![0.0; weights.len()]),
    };
    if weights.is_empty() {
        return Ok(gradient);
    }
    let steps = steps_of(system, inputs, substeps);
    let lots: Vec<Lot<'_>> = jobs
        .chunks(SENSITIVITY_LANES)
        .enumerate()
        .map(|(chunk, jobs)| Lot { system, jobs, inputs, first: chunk * SENSITIVITY_LANES, steps, weights })
        .collect();
    let found: Vec<(usize, Vec<Vec<f64>>, Vec<Direction>)> =
        parallel::map(lots.iter(), |lot| (lot.first, lot.gradient(), lot.directions()));
    for (first, slopes, directions) in found {
        for (direction, slopes) in directions.into_iter().zip(slopes) {
            let lanes = SENSITIVITY_LANES.min(jobs.len() - first);
            for lane in 0..lanes {
                let job = first + lane;
                let by_row = slopes.iter().skip(lane).step_by(SENSITIVITY_LANES);
                match direction {
                    Direction::Pressure => gradient.start[job] = slopes[lane],
                    Direction::Filtered => {}
                    Direction::Parameter(i) => gradient.parameters[job * parameters + i] = by_row.sum(),
                    Direction::Input(i) => {
                        let all = &mut gradient.inputs[i][job * rows..][..rows];
                        all.iter_mut().zip(by_row).for_each(|(sum, slope)| *sum += slope);
                    }
                    Direction::Command => {
                        let all = &mut gradient.inputs[COMMAND][job * rows..][..rows];
                        for (row, slope) in by_row.enumerate() {
                            all[row.saturating_sub(1)] += slope;
                        }
                    }
                }
            }
        }
    }
    Ok(gradient)
}

/// Where the command is in [`DIFFERENTIATED`].
const COMMAND: usize = 2;

/// Some rollouts side by side.
#[derive(Clone, Copy)]
struct Lot<'a> {
    system: &'a dyn System,
    jobs: &'a [Job<'a>],
    inputs: &'a BatchInputs<'a>,
    first: usize,
    steps: Steps,
    weights: &'a [f64],
}

type Numbers = Lanes<SENSITIVITY_LANES>;

impl Lot<'_> {
    /// What the pressures follow from.
    fn directions(&self) -> Vec<Direction> {
        let mut all = vec![Direction::Pressure];
        if !self.system.has_rates() {
            all.extend([Direction::Filtered, Direction::Command]);
        }
        all.extend((0..DIFFERENTIATED.len()).map(Direction::Input));
        all.extend((0..self.jobs[0].parameters.len()).map(Direction::Parameter));
        all
    }

    /// One lane's place in the batch; spare lanes repeat the last.
    fn job(&self, lane: usize) -> usize {
        self.first + lane.min(self.jobs.len() - 1)
    }

    fn row(&self, lane: usize, k: usize) -> Vec<f64> {
        (0..column::COUNT).map(|column| self.inputs.value(self.job(lane), k, column)).collect()
    }

    /// Pressure, filtered sample and last command of each lane at each row.
    fn states(&self) -> Vec<[Numbers; 3]> {
        let mut states = vec![[Numbers::constant(0.0); 3]; self.inputs.rows()];
        for lane in 0..self.jobs.len() {
            let job = &self.jobs[lane];
            let first = self.row(lane, 0);
            let mut stepper = self.system.stepper(job.parameters, self.steps.substeps, &first, job.start);
            for (k, state) in states.iter_mut().enumerate() {
                let mut at = 0;
                stepper.values(&mut |value| {
                    if let Some(numbers) = state.get_mut(at) {
                        numbers.0[lane..].fill(*value);
                    }
                    at += 1;
                });
                stepper.advance(&self.row(lane, k));
            }
        }
        states
    }

    /// For each of the directions, one slope a row and lane; of the pressure that at the first row.
    fn gradient(&self) -> Vec<Vec<f64>> {
        let states = self.states();
        let directions = self.directions();
        // Those of the state are part of every pass.
        let (of_state, others) = directions.split_at(if self.system.has_rates() { 1 } else { 2 });
        let rows = self.inputs.rows();
        let mut slopes = vec![vec![0.0; rows * SENSITIVITY_LANES]; of_state.len()];
        for part in others.chunks(DIRECTIONS - of_state.len()) {
            let directions: Vec<Direction> = of_state.iter().chain(part).copied().collect();
            let seed = |i: usize| {
                let at = directions.iter().position(|d| *d == Direction::Parameter(i));
                let value = lanes_of(self.jobs, |job| job.parameters[i]);
                Active(Dual::variable(value, at.unwrap_or(DIRECTIONS)))
            };
            let parameters: Vec<ActiveLanes> = (0..self.jobs[0].parameters.len()).map(seed).collect();
            let mut pass = Pass {
                lot: self,
                states: &states,
                directions: &directions,
                left: rows,
                after: [Numbers::constant(0.0); 2],
                slopes: vec![vec![0.0; rows * SENSITIVITY_LANES]; directions.len()],
            };
            self.system.simulate_intervals(&parameters, self.steps, &mut pass);
            let mut found = pass.slopes.into_iter();
            for known in &mut slopes[..of_state.len()] {
                *known = found.next().unwrap_or_default();
            }
            slopes.extend(found);
        }
        slopes
    }
}

/// One pass over the rows, backwards.
struct Pass<'a> {
    lot: &'a Lot<'a>,
    states: &'a [[Numbers; 3]],
    directions: &'a [Direction],
    /// Rows that are not done.
    left: usize,
    /// Derivatives of the sum over later rows by pressure and filtered sample at the end of the
    /// interval.
    after: [Numbers; 2],
    /// `[direction][row][lane]`.
    slopes: Vec<Vec<f64>>,
}

impl Pass<'_> {
    fn seeded(&self, value: Numbers, direction: Direction) -> ActiveLanes {
        let at = self.directions.iter().position(|d| *d == direction);
        Active(Dual::variable(value, at.unwrap_or(DIRECTIONS)))
    }
}

impl Intervals for Pass<'_> {
    fn next(&mut self, interval: &mut Interval) -> bool {
        if self.left == 0 {
            return false;
        }
        let k = self.left - 1;
        for (column, value) in interval.row.iter_mut().enumerate() {
            let numbers =
                Lanes(std::array::from_fn(|lane| self.lot.inputs.value(self.lot.job(lane), k, column)));
            let at = DIFFERENTIATED.iter().position(|known| *known == column);
            *value = self.seeded(numbers, Direction::Input(at.unwrap_or(DIFFERENTIATED.len())));
        }
        let [pressure, filtered, command] = self.states[k];
        interval.first = k == 0;
        interval.state.pressure = self.seeded(pressure, Direction::Pressure);
        interval.state.filtered = self.seeded(filtered, Direction::Filtered);
        interval.state.command = self.seeded(command, Direction::Command);
        true
    }

    fn done(&mut self, start: &RowState, end: &RowState) {
        self.left -= 1;
        let k = self.left;
        let rows = self.states.len();
        let weight = Lanes(std::array::from_fn(|lane| self.lot.weights[self.lot.job(lane) * rows + k]));
        let [by_pressure, by_filtered] = self.after;
        let last = k + 1 == rows;
        let mut before = [Numbers::constant(0.0); 2];
        for (i, direction) in self.directions.iter().enumerate() {
            let mut slope = weight * start.reading.0.gradient[i];
            // What follows the last row is of no account.
            if !last {
                slope = slope + by_pressure * end.pressure.0.gradient[i];
                slope = slope + by_filtered * end.filtered.0.gradient[i];
            }
            match direction {
                Direction::Pressure => before[0] = slope,
                Direction::Filtered => before[1] = slope,
                _ => {}
            }
            self.slopes[i][k * SENSITIVITY_LANES..][..SENSITIVITY_LANES].copy_from_slice(&slope.0);
        }
        self.after = before;
    }
}
