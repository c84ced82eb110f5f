//! One channel under diagnosis: its inputs, its blocks, and simulations compared with its
//! measurements.

use std::sync::Arc;

use crate::data::ChannelId;
use crate::effects::{
    ChannelInputs, Disturbance, DriveInput, Plant, Series, Simulated, Undisturbed, install, simulate,
};

use super::correction::Corrected;
use super::model::Extended;
use super::split::{Block, Role};
use super::variable::{Variable, series};

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
    /// What drives it: `spool`, `separate` (fill and vent), `board` (the board's loop, from
    /// commands) or `command` (a regulator).
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

    /// Readings of every row with drive and flow drawn: reading (kPa gauge), drive (-1 to 1), flow
    /// (mm^2 Pa).
    #[must_use]
    pub fn trace(&self, model: &Extended) -> Vec<[f64; 3]> {
        self.traced(model, &self.correction_rates(model))
    }

    fn traced(&self, model: &Extended, rates: &[f64]) -> Vec<[f64; 3]> {
        let shape = Corrected { inner: &Undisturbed, rates, interval_s: &self.inputs.interval_s };
        let plant = self.plant_with(&model.effects);
        let mut effects = install(&plant, &model.effects, &model.values);
        let mut trace = Vec::with_capacity(self.inputs.rows());
        simulate(&plant, &model.values, &mut effects, &self.inputs, &shape, |row| {
            trace.push([row.reading * 1e-3, row.drive, row.draw]);
        });
        trace
    }

    /// What a model's correction adds to the rate of pressure, kPa/s, row by row; empty without
    /// one.
    fn correction_rates(&self, model: &Extended) -> Vec<f64> {
        match &model.correction {
            Some(correction) => {
                let trace = self.traced(model, &[]);
                // A variable that does not change has no correction.
                self.series(&trace, correction.variable)
                    .map_or_else(|| vec![0.0; trace.len()], |values| correction.rates(&values))
            }
            None => Vec::new(),
        }
    }

    /// A variable that the residual may depend on, at every row of a [trace](Self::trace); `None`
    /// where the recording does not have it or it never changes.
    #[must_use]
    pub fn series(&self, trace: &[[f64; 3]], variable: Variable) -> Option<Series> {
        series(&self.inputs, trace, variable)
    }

    /// Readings over any kind of number; `values` are the model's, in its kind.
    pub fn run<S: Simulated>(&self, model: &Extended, values: &[S], shape: &impl Disturbance<S>) -> Vec<S> {
        let rates = self.correction_rates(model);
        let shape = Corrected { inner: shape, rates: &rates, interval_s: &self.inputs.interval_s };
        let plant = self.plant_with(&model.effects);
        let mut effects = install(&plant, &model.effects, values);
        let mut readings = Vec::with_capacity(self.rows.len());
        let mut next = 0;
        simulate(&plant, values, &mut effects, &self.inputs, &shape, |row| {
            if self.rows.get(next).is_some_and(|&r| r as usize == row.row) {
                readings.push(row.reading.times(1e-3));
                next += 1;
            }
        });
        readings
    }
}

/// Compared rows in the blocks of some roles.
#[must_use]
pub fn rows_of(data: &ChannelData, roles: &[Role]) -> Vec<usize> {
    let chosen = data.blocks.iter().zip(&data.spans).filter(|(b, _)| roles.contains(&b.role));
    chosen.flat_map(|(_, span)| span.clone()).collect()
}
