//! One channel under diagnosis: its inputs, its blocks, and simulations compared with its measurements.

use std::borrow::Cow;
use std::sync::Arc;

use crate::data::ChannelId;
use crate::effects::catalogue::{AnyEffect, CATALOGUE};
use crate::effects::{ChannelInputs, Disturbance, DriveInput, Plant, Series, Undisturbed, simulate};
use crate::model::{Parameter, Scale};
use crate::numeric::{Dual, Scalar};

use super::blocks::Block;
use super::correction::{Corrected, Correction};
use super::hunting::hunts;
use super::secant::secants;
use super::steps::rougher;

/// Derivatives that are simulated at a time; more take more simulations. Each number of them would cost seconds of compilation.
pub const NARROW: usize = 8;
/// Widest overlap of a valve's edges that is believed: beyond it a fit bends the valve's corner to imitate something else.
const WIDEST_EDGE: f64 = 0.5;

/// Rows of a channel that are compared at most; of longer recordings every n-th is.
const MOST_COMPARED: usize = 60_000;

/// A channel's data, ready to be compared.
#[derive(Debug, Clone)]
pub struct ChannelData {
    /// Which one.
    pub id: ChannelId,
    /// Base model.
    pub plant: Plant,
    /// Measured inputs.
    pub inputs: ChannelInputs,
    /// Blocks in time.
    pub blocks: Vec<Block>,
    /// Compared rows.
    pub rows: Arc<[u32]>,
    /// Range of `rows` that each block covers.
    pub spans: Vec<std::ops::Range<usize>>,
    /// Measured pressure at the compared rows, kPa gauge.
    pub measured_kpa: Series,
    /// Noise of the measurement, kPa RMS, quantisation included.
    pub noise_kpa: f64,
    /// How hard the channel that the board handles before this one is driven, -1 to 1, row by row; empty when that is not known.
    pub neighbour_drive: Series,
}

/// Effects at work and their parameters' values: a model of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Extended {
    /// Numbers of the effects in the catalogue, ascending.
    pub effects: Vec<usize>,
    /// Values: the base model's parameters, then those of each effect.
    pub values: Vec<f64>,
    /// Those of the effects that are held to [what is usual on sound rigs](crate::effects::EffectParameter::usual), ascending: a part of
    /// the base model, no causes.
    pub usual: Vec<usize>,
    /// A smooth correction of what no effect explains.
    pub correction: Option<Correction>,
}

impl Extended {
    /// A base model without effects.
    #[must_use]
    pub fn base(values: Vec<f64>) -> Self {
        Self { effects: Vec::new(), values, usual: Vec::new(), correction: None }
    }

    /// The model without its correction.
    #[must_use]
    pub fn uncorrected(&self) -> Self {
        Self { correction: None, ..self.clone() }
    }

    /// Is an effect at work in any size?
    #[must_use]
    pub fn has(&self, effect: usize) -> bool {
        self.effects.contains(&effect) && !self.usual.contains(&effect)
    }

    /// The model with one more effect in any size, which takes the place of the usual one where that is there.
    #[must_use]
    pub fn with(&self, plant: &Plant, effect: usize, parameters: &[f64]) -> Self {
        if let Some(range) = self.range(plant, effect) {
            let mut next = self.clone();
            next.values[range].copy_from_slice(parameters);
            next.usual.retain(|&e| e != effect);
            return next;
        }
        let position = self.effects.partition_point(|&e| e < effect);
        let base = plant.parameters().len();
        let before: usize = self.effects[..position].iter().map(|&e| CATALOGUE[e].parameters.len()).sum();
        let mut next = self.clone();
        next.effects.insert(position, effect);
        next.values.splice(base + before..base + before, parameters.iter().copied());
        next
    }

    /// The model with an effect that is held to what is usual; it begins with nothing.
    #[must_use]
    pub fn with_usual(&self, plant: &Plant, effect: usize) -> Self {
        let nulls: Vec<f64> = CATALOGUE[effect].parameters.iter().map(|p| p.null).collect();
        let mut next = self.with(plant, effect, &nulls);
        next.usual.push(effect);
        next.usual.sort_unstable();
        next
    }

    /// The model without one of its effects; what belongs to the base model becomes usual again.
    #[must_use]
    pub fn without(&self, plant: &Plant, effect: usize) -> Self {
        if CATALOGUE[effect].in_base(plant) {
            return self.with_usual(plant, effect);
        }
        let mut next = self.clone();
        if let Some(range) = self.range(plant, effect) {
            next.values.drain(range);
            next.effects.retain(|&e| e != effect);
        }
        next
    }

    /// Where the values of one effect are.
    #[must_use]
    pub fn range(&self, plant: &Plant, effect: usize) -> Option<std::ops::Range<usize>> {
        let mut at = plant.parameters().len();
        for &e in &self.effects {
            let next = at + CATALOGUE[e].parameters.len();
            if e == effect {
                return Some(at..next);
            }
            at = next;
        }
        None
    }

    /// All parameters, in the order of the values.
    #[must_use]
    pub fn parameters(&self, plant: &Plant) -> Vec<Parameter> {
        let mut list = plant.parameters();
        for p in list.iter_mut().filter(|p| p.name.starts_with("threshold")) {
            (p.lower, p.upper) = (p.lower.max(-WIDEST_EDGE), p.upper.min(WIDEST_EDGE));
        }
        for &e in &self.effects {
            let usual = self.usual.contains(&e);
            list.extend(CATALOGUE[e].parameters.iter().map(|p| (p, p.bounds(usual))).map(|(p, bounds)| {
                Parameter {
                    name: format!("{}.{}", CATALOGUE[e].id, p.name),
                    unit: p.unit,
                    lower: bounds.0,
                    upper: bounds.1,
                    nominal: p.null,
                    scale: p.scale,
                    meaning: p.meaning,
                }
            }));
        }
        list
    }
}

/// Puts the effects to work.
pub(super) fn install<S: Scalar>(plant: &Plant, effects: &[usize], values: &[S]) -> Vec<AnyEffect<S>> {
    let mut at = plant.parameters().len();
    effects
        .iter()
        .filter_map(|&e| {
            let next = at + CATALOGUE[e].parameters.len();
            let installed = AnyEffect::install(e, &values[at..next]);
            at = next;
            installed
        })
        .collect()
}

/// Chooses the compared rows.
#[must_use]
pub fn compared_rows(inputs: &ChannelInputs, blocks: &[Block]) -> (Arc<[u32]>, Vec<std::ops::Range<usize>>) {
    let stride = inputs.rows().div_ceil(MOST_COMPARED).max(1);
    let (mut rows, mut spans) = (Vec::new(), Vec::new());
    for block in blocks {
        let from = rows.len();
        let usable = (block.compared..block.end).step_by(stride).filter(|&row| inputs.usable[row]);
        rows.extend(usable.filter_map(|row| u32::try_from(row).ok()));
        spans.push(from..rows.len());
    }
    (rows.into(), spans)
}

impl ChannelData {
    /// What drives it: `spool`, `separate` (fill and vent), `board` (the board's loop, from commands) or `command` (a regulator).
    #[must_use]
    pub fn driven_by(&self) -> &'static str {
        match &self.inputs.drive {
            DriveInput::Spool(_) => "spool",
            DriveInput::Separate { .. } => "separate",
            DriveInput::Controlled => "board",
            DriveInput::Command => "command",
        }
    }

    /// Simulated readings at the compared rows, kPa gauge.
    #[must_use]
    pub fn readings(&self, model: &Extended) -> Vec<f64> {
        self.run(model, &model.values, &Undisturbed)
    }

    /// Residuals (measured minus simulated) at the compared rows, kPa.
    #[must_use]
    pub fn residuals(&self, model: &Extended) -> Vec<f64> {
        self.readings(model).iter().zip(self.measured_kpa.iter()).map(|(y, m)| m - y).collect()
    }

    /// Readings of every row with drive and flow drawn: reading (kPa gauge), drive (-1 to 1), flow (mm^2 Pa).
    #[must_use]
    pub fn trace(&self, model: &Extended) -> Vec<[f64; 3]> {
        self.traced(model, &self.correction_rates(model))
    }

    fn traced(&self, model: &Extended, rates: &[f64]) -> Vec<[f64; 3]> {
        let shape = Corrected { inner: &Undisturbed, rates, interval_s: &self.inputs.interval_s };
        let mut effects = install(&self.plant, &model.effects, &model.values);
        let mut trace = Vec::with_capacity(self.inputs.rows());
        simulate(&self.plant, &model.values, &mut effects, &self.inputs, &shape, |row| {
            trace.push([row.reading * 1e-3, row.drive, row.draw]);
        });
        trace
    }

    /// What a model's correction adds to the rate of pressure, kPa/s, row by row; empty without one.
    fn correction_rates(&self, model: &Extended) -> Vec<f64> {
        match &model.correction {
            Some(correction) => correction.rates(self, &self.traced(model, &[])),
            None => Vec::new(),
        }
    }

    /// Readings and their derivatives by the parameters whose positions are listed, row by row. On a logarithmic scale the
    /// derivative is by the logarithm. Of a loop that hunts, secants take the place of derivatives.
    #[must_use]
    pub fn sensitivities(&self, model: &Extended, free: &[usize]) -> (Vec<f64>, Vec<f64>) {
        if hunts(self, model) {
            return secants(self, model, free);
        }
        let parameters = model.parameters(&self.plant);
        let mut readings = Vec::with_capacity(self.rows.len());
        let mut matrix = vec![0.0; self.rows.len() * free.len()];
        for (k, part) in free.chunks(NARROW).enumerate() {
            let into = Part { first: k * NARROW, of: free.len(), part };
            self.differentiate(model, &parameters, &into, &mut readings, &mut matrix);
        }
        if free.is_empty() {
            readings = self.readings(model);
        }
        (readings, matrix)
    }

    fn differentiate(
        &self,
        model: &Extended,
        parameters: &[Parameter],
        into: &Part<'_>,
        readings: &mut Vec<f64>,
        matrix: &mut [f64],
    ) {
        let mut values: Vec<Dual<f64, NARROW>> =
            model.values.iter().map(|v| Dual { value: *v, gradient: [0.0; NARROW] }).collect();
        for (k, &position) in into.part.iter().enumerate() {
            values[position].gradient[k] = match parameters[position].scale {
                Scale::Linear => 1.0,
                Scale::Logarithmic => model.values[position],
            };
        }
        let run = self.run(model, &values, &Undisturbed);
        readings.clear();
        for (row, reading) in run.iter().enumerate() {
            readings.push(reading.value);
            let at = row * into.of + into.first;
            matrix[at..at + into.part.len()].copy_from_slice(&reading.gradient[..into.part.len()]);
        }
    }

    /// The channel in coarser steps of the board's loop, where there are any.
    #[must_use]
    pub fn rough(&self) -> Cow<'_, Self> {
        rougher(self).map_or(Cow::Borrowed(self), Cow::Owned)
    }

    /// Readings over any kind of number; `values` are the model's, in its kind.
    pub(super) fn run<S: Scalar>(
        &self,
        model: &Extended,
        values: &[S],
        shape: &impl Disturbance<S>,
    ) -> Vec<S> {
        let rates = self.correction_rates(model);
        let shape = Corrected { inner: shape, rates: &rates, interval_s: &self.inputs.interval_s };
        let mut effects = install(&self.plant, &model.effects, values);
        let mut readings = Vec::with_capacity(self.rows.len());
        let mut next = 0;
        simulate(&self.plant, values, &mut effects, &self.inputs, &shape, |row| {
            if self.rows.get(next).is_some_and(|&r| r as usize == row.row) {
                readings.push(row.reading.times(1e-3));
                next += 1;
            }
        });
        readings
    }
}

/// A part of the columns of a matrix of derivatives.
struct Part<'a> {
    first: usize,
    of: usize,
    part: &'a [usize],
}
