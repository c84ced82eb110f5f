//! One channel simulated with effects, row by row.

use super::catalogue::AnyEffect;
use super::deviations::Deviations;
use super::hook::Memory;
use super::inputs::ChannelInputs;

use super::plant::Plant;
use super::run::Run;
use super::simulated::Simulated;
use super::state::StepperState;
use crate::numeric::Scalar;

/// What a simulation says about one row.
#[derive(Debug, Clone, Copy)]
pub struct Row<S: Scalar> {
    /// Row number.
    pub row: usize,
    /// What the sensor is expected to report at the row's time, gauge, Pa.
    pub reading: S,
    /// Drive over the interval that starts here (mean), -1 to 1 (fill minus vent where there are
    /// two valves).
    pub drive: S::Real,
    /// Mass flow drawn from the supply over that interval (mean), mm^2 Pa.
    pub draw: S::Real,
}

/// Lets a caller add to a simulation what no effect describes: disturbances with known derivatives.
pub trait Disturbance<S> {
    /// The supply pressure over the interval that starts at `row`, Pa.
    fn supply(&self, _row: usize, supply: S) -> S {
        supply
    }

    /// The pressure in the chamber at the start of that interval, Pa.
    fn pressure(&self, _row: usize, pressure: S) -> S {
        pressure
    }
}

/// No disturbance.
#[derive(Debug, Clone, Copy)]
pub struct Undisturbed;

impl<S> Disturbance<S> for Undisturbed {}

/// Puts effects to work: those with these numbers in the catalogue, with their values behind those
/// of the base model.
#[must_use]
pub fn install<S: Simulated>(plant: &Plant, effects: &[usize], values: &[S]) -> Vec<AnyEffect<S>> {
    S::installed(effects, &values[plant.parameters().len()..])
}

/// Runs the channel through all rows and hands each row's outcome to `each`.
///
/// `base` are the base model's parameters in the order of [`Plant::parameters`].
pub fn simulate<S: Simulated>(
    plant: &Plant,
    base: &[S],
    effects: &mut [AnyEffect<S>],
    inputs: &ChannelInputs,
    disturbance: &impl Disturbance<S>,
    mut each: impl FnMut(Row<S>),
) {
    let mut run = Stepper::new(plant, base, effects, inputs);
    let (mut next_start, mut next_anchor) = (0, 0);
    for row in 0..inputs.rows() {
        if inputs.starts.get(next_start) == Some(&row) {
            next_start += 1;
            run.start(row);
        }
        if inputs.anchors.get(next_anchor) == Some(&row) {
            next_anchor += 1;
            run.anchor(row);
        }
        run.set_pressure(disturbance.pressure(row, run.pressure()));
        run.set_supply(disturbance.supply(row, S::constant(inputs.supply_pa[row])));
        let reading = run.reading(row);
        let (drive, draw) = run.interval(row);
        each(Row { row, reading, drive, draw });
    }
}

/// A channel simulated row by row, for callers that look at its state or change it in between.
pub struct Stepper<'a, S: Simulated> {
    run: Run<'a, S>,
    effects: &'a mut [AnyEffect<S>],
}

impl<'a, S: Simulated> Stepper<'a, S> {
    /// A channel with effects, before its first row; arguments as of [`simulate`].
    pub fn new(
        plant: &'a Plant,
        base: &[S],
        effects: &'a mut [AnyEffect<S>],
        inputs: &'a ChannelInputs,
    ) -> Self {
        Self { run: S::begun(plant, base, effects, inputs), effects }
    }

    /// What it remembers beside its effects, for [`resume`](Self::resume).
    pub fn state(&self) -> StepperState<S> {
        let Run { chamber, reading, controller, spool, .. } = &self.run;
        StepperState { chamber: *chamber, reading: *reading, controller: *controller, spool: *spool }
    }

    /// Goes on where another stepper of the same channel and the same effects stood: its inputs may
    /// be others.
    pub fn resume(&mut self, state: StepperState<S>) {
        let StepperState { chamber, reading, controller, spool } = state;
        (self.run.chamber, self.run.reading, self.run.controller) = (chamber, reading, controller);
        self.run.spool = spool;
    }

    /// Begins at rest at the pressure measured in a row.
    pub fn start(&mut self, row: usize) {
        S::start(&mut self.run, row, self.effects);
    }

    /// Moves the pressure by what the reading is off in a row, before what is sampled there.
    pub fn anchor(&mut self, row: usize) {
        let Run { inputs, .. } = self.run;
        let off = (-self.run.report()).plus(inputs.measured_pa[row] - inputs.ambient_pa);
        self.set_pressure(self.pressure() + off);
    }

    /// Is there a tube between valve and chamber?
    pub fn has_tube(&self) -> bool {
        self.run.chamber.has_tube()
    }

    /// Pressure in the chamber, absolute, Pa.
    pub fn pressure(&self) -> S {
        self.run.chamber.pressure()
    }

    /// Sets the pressure in the chamber, absolute, Pa; what the sensor delivers moves with it.
    pub fn set_pressure(&mut self, pressure: S) {
        self.run.disturb(pressure);
    }

    /// Sets the supply pressure of the interval to come, before effects, absolute, Pa.
    pub fn set_supply(&mut self, supply: S) {
        self.run.supply = supply;
    }

    /// Makes variables of the inputs of the intervals to come.
    pub fn set_deviations(&mut self, deviations: Deviations<S>) {
        self.run.deviations = Some(deviations);
    }

    /// What is recorded in a row, gauge, Pa. Once a row, before its interval.
    pub fn reading(&mut self, row: usize) -> S {
        S::reading(&mut self.run, row, self.effects)
    }

    /// Advances over the interval that starts at a row. Returns the mean drive, -1 to 1, and the
    /// mean flow drawn from the supply, mm^2 Pa.
    pub fn interval(&mut self, row: usize) -> (S::Real, S::Real) {
        S::interval(&mut self.run, row, self.effects)
    }

    /// Shows everything that is remembered from row to row, in an order that stays: first the
    /// pressure in the chamber (absolute, Pa) and, if there is a tube, at its other end.
    pub fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        S::memory(&mut self.run, self.effects, visit);
    }
}
