//! Derivatives of a weighted sum of a channel's readings by everything that is recorded of its
//! inputs.
//!
//! Reverse accumulation from interval to interval: over each, forward derivatives say how what is
//! remembered at its end, and the reading there, follow from what was remembered at its start and
//! from the inputs. The cost does not grow with the number of inputs.

use std::ops::Range;

use super::catalogue::AnyEffect;
use super::deviations::Deviations;
use super::inputs::{ChannelInputs, DriveInput};
use super::plant::Plant;
use super::simulate::Stepper;
use super::simulated::NARROW;
use super::state::StepperState;
use crate::numeric::{Dual, Scalar};

/// Intervals whose derivatives are held at a time. Where a stretch of them begins, the simulation
/// is kept.
const STRETCH: usize = 256;

type Slopes = Dual<f64, NARROW>;

/// Derivatives by a channel's inputs, each with one value per row; those that do not drive it
/// are 0.
#[derive(Debug, Clone, PartialEq)]
pub struct InputSlopes {
    /// By the drive of the spool or the fill valve.
    pub fill: Vec<f64>,
    /// By the drive of the vent valve.
    pub vent: Vec<f64>,
    /// By the command, 1/Pa.
    pub command: Vec<f64>,
    /// By the supply pressure, 1/Pa.
    pub supply: Vec<f64>,
    /// By the volume, 1/m^3.
    pub volume: Vec<f64>,
    /// By its rate, s/m^3.
    pub volume_rate: Vec<f64>,
}

/// What an interval's inputs are.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Input {
    Fill,
    Vent,
    Command,
    CommandBefore,
    Supply,
    Volume,
    VolumeRate,
}

/// Derivatives of `sum(weight * reading)` (readings gauge, Pa; a weight per row) by the inputs of a
/// channel that starts once, at row 0: exact for the discretised model. `base` and `effects` are as
/// of [`simulate`](super::simulate()), not yet begun. Commands that the board's converter cannot
/// read have no derivatives.
#[must_use]
pub fn input_slopes(
    plant: &Plant,
    base: &[Slopes],
    effects: &[AnyEffect<Slopes>],
    inputs: &ChannelInputs,
    weights: &[f64],
) -> InputSlopes {
    let known: &[Input] = match &inputs.drive {
        DriveInput::Spool(_) => &[Input::Fill, Input::Supply, Input::Volume, Input::VolumeRate],
        DriveInput::Separate { .. } => {
            &[Input::Fill, Input::Vent, Input::Supply, Input::Volume, Input::VolumeRate]
        }
        DriveInput::Controlled => {
            &[Input::Command, Input::CommandBefore, Input::Supply, Input::Volume, Input::VolumeRate]
        }
        DriveInput::Command => &[Input::Command, Input::Supply, Input::Volume, Input::VolumeRate],
    };
    let channel = Channel { plant, base, inputs, known };
    let zeros = || vec![0.0; inputs.rows()];
    let mut slopes = InputSlopes {
        fill: zeros(),
        vent: zeros(),
        command: zeros(),
        supply: zeros(),
        volume: zeros(),
        volume_rate: zeros(),
    };
    // Derivatives of the sum over later rows by what is remembered at the end of an interval.
    let mut after = Vec::new();
    for place in channel.places(effects).into_iter().rev() {
        let rows = channel.stretch(place.row);
        for (row, interval) in rows.clone().zip(channel.intervals(&place)).rev() {
            let before = interval.before(&after, weights[row + 1]);
            let (of_inputs, of_state) = before.split_at(known.len());
            for (input, slope) in known.iter().zip(of_inputs) {
                let (column, at) = match input {
                    Input::Fill => (&mut slopes.fill, row),
                    Input::Vent => (&mut slopes.vent, row),
                    Input::Command => (&mut slopes.command, row),
                    Input::CommandBefore => (&mut slopes.command, row.saturating_sub(1)),
                    Input::Supply => (&mut slopes.supply, row),
                    Input::Volume => (&mut slopes.volume, row),
                    Input::VolumeRate => (&mut slopes.volume_rate, row),
                };
                column[at] += slope;
            }
            after = of_state.to_vec();
        }
    }
    slopes
}

/// How the end of an interval follows from its start.
#[derive(Debug, Default)]
struct Interval {
    /// Numbers that are remembered at its end.
    remembered: usize,
    /// For each input and each number that is remembered at its start: the derivatives of those
    /// numbers, and of the reading there.
    slopes: Vec<f64>,
}

impl Interval {
    /// Derivatives by its inputs and by what is remembered at its start, where those by what is
    /// remembered at its end are `after`, and the reading there has this weight. Nothing follows
    /// the last one: `after` is empty.
    fn before(&self, after: &[f64], weight: f64) -> Vec<f64> {
        let of = |column: &[f64]| {
            let later: f64 = column.iter().zip(after).map(|(slope, after)| slope * after).sum();
            later + weight * column[self.remembered]
        };
        self.slopes.chunks_exact(self.remembered + 1).map(of).collect()
    }
}

/// A simulation at the row where a stretch begins.
struct Place {
    row: usize,
    /// `None` before the first row.
    state: Option<StepperState<Slopes>>,
    effects: Vec<AnyEffect<Slopes>>,
}

struct Channel<'a> {
    plant: &'a Plant,
    base: &'a [Slopes],
    inputs: &'a ChannelInputs,
    known: &'a [Input],
}

impl Channel<'_> {
    /// The intervals of the stretch from a row on.
    fn stretch(&self, row: usize) -> Range<usize> {
        row..(row + STRETCH).min(self.inputs.rows() - 1)
    }

    /// Simulates a stretch. Before each interval `before` gets the simulation, behind it `after`
    /// too, with its number in the stretch and the reading. Returns where the next stretch begins.
    fn run(
        &self,
        place: &Place,
        mut before: impl FnMut(&mut Stepper<'_, Slopes>, usize),
        mut after: impl FnMut(&mut Stepper<'_, Slopes>, usize, Slopes),
    ) -> Place {
        let mut effects = place.effects.clone();
        let mut stepper = Stepper::new(self.plant, self.base, &mut effects, self.inputs);
        match place.state {
            Some(state) => stepper.resume(state),
            None => {
                stepper.start(place.row);
                stepper.reading(place.row);
            }
        }
        let rows = self.stretch(place.row);
        for (k, row) in rows.clone().enumerate() {
            stepper.set_supply(Dual::from_real(self.inputs.supply_pa[row]));
            before(&mut stepper, row);
            stepper.interval(row);
            let reading = stepper.reading(row + 1);
            after(&mut stepper, k, reading);
        }
        let state = Some(stepper.state());
        Place { row: rows.end, state, effects }
    }

    /// Where the stretches begin.
    fn places(&self, effects: &[AnyEffect<Slopes>]) -> Vec<Place> {
        let mut places = Vec::new();
        let mut place = Place { row: 0, state: None, effects: effects.to_vec() };
        while !self.stretch(place.row).is_empty() {
            let next = self.run(&place, |_, _| {}, |_, _, _| {});
            places.push(std::mem::replace(&mut place, next));
        }
        places
    }

    /// The intervals of a stretch: [`NARROW`] of the things that they are differentiated by at a
    /// time.
    fn intervals(&self, place: &Place) -> Vec<Interval> {
        let count = self.stretch(place.row).len();
        let mut intervals: Vec<Interval> = (0..count).map(|_| Interval::default()).collect();
        // Things that the intervals are differentiated by.
        let mut widths = vec![self.known.len(); count];
        let mut first = 0;
        while widths.iter().any(|width| first < *width) {
            let mut seeded = widths.iter_mut();
            let before = |stepper: &mut Stepper<'_, Slopes>, row: usize| {
                let width = self.seed(stepper, row, first);
                if let Some(known) = seeded.next() {
                    *known = width;
                }
            };
            let mut ends = Vec::with_capacity(count);
            self.run(place, before, |stepper, _, reading| {
                let mut end = Vec::new();
                stepper.memory(&mut |_, value| end.push(value.gradient));
                end.push(reading.gradient);
                ends.push(end);
            });
            for ((interval, end), width) in intervals.iter_mut().zip(ends).zip(&widths) {
                interval.remembered = end.len() - 1;
                for direction in 0..NARROW.min(width.saturating_sub(first)) {
                    interval.slopes.extend(end.iter().map(|gradient| gradient[direction]));
                }
            }
            first += NARROW;
        }
        intervals
    }

    /// Makes variables of the inputs and of what is remembered, those from number `first` on.
    /// Returns how many there are.
    fn seed(&self, stepper: &mut Stepper<'_, Slopes>, row: usize, first: usize) -> usize {
        let variable = |value: f64, number: usize| Dual::variable(value, number.wrapping_sub(first));
        let input = |input: Input| match self.known.iter().position(|known| *known == input) {
            Some(number) => variable(0.0, number),
            None => Dual::from_real(0.0),
        };
        stepper.set_deviations(Deviations {
            drive: [input(Input::Fill), input(Input::Vent)],
            command: input(Input::Command),
            command_before: input(Input::CommandBefore),
            volume: input(Input::Volume),
            volume_rate: input(Input::VolumeRate),
        });
        stepper.set_supply(input(Input::Supply).plus(self.inputs.supply_pa[row]));
        let mut number = self.known.len();
        stepper.memory(&mut |_, value| {
            *value = variable(value.value, number);
            number += 1;
        });
        number
    }
}
