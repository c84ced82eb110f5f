//! Sensitivities of a loop that hunts.
//!
//! Two simulations that differ by next to nothing soon hunt out of step. The exact derivative along one of them grows without bound and
//! says nothing about where the error falls. What does is the secant over a change that moves the readings about as far as their
//! noise: far beyond what being out of step does.

use rayon::prelude::*;

use super::channel::{ChannelData, Extended};
use crate::model::{Parameter, Scale};

/// First stride on a logarithmic scale ...
const LOGARITHMIC: f64 = 0.05;
/// ... and on a linear one as a part of the value, where it is at least a part of the bounds' distance.
const LINEAR: [f64; 2] = [0.12, 1e-4];
/// Longest stride on a logarithmic scale, and as a part of the bounds' distance on a linear one.
const LONGEST: [f64; 2] = [0.5, 0.05];
/// A stride is corrected when the change that it makes is not the wanted one within a factor ...
const NEAR: f64 = 3.0;
/// ... by no more than this factor.
const FACTOR: f64 = 10.0;

/// Readings and their secants by the free parameters, as [`ChannelData::sensitivities`] has derivatives.
#[must_use]
pub fn secants(data: &ChannelData, model: &Extended, free: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let parameters = model.parameters(&data.plant);
    let readings = data.readings(model);
    let columns: Vec<Vec<f64>> =
        free.par_iter().map(|&k| secant(data, model, &parameters[k], k, &readings)).collect();
    let mut matrix = Vec::with_capacity(readings.len() * free.len());
    for row in 0..readings.len() {
        matrix.extend(columns.iter().map(|column| column[row]));
    }
    (readings, matrix)
}

/// The change of the readings by one parameter, by its coordinate.
fn secant(data: &ChannelData, model: &Extended, p: &Parameter, k: usize, readings: &[f64]) -> Vec<f64> {
    let value = model.values[k];
    let (first, longest) = match p.scale {
        Scale::Logarithmic => (LOGARITHMIC, LONGEST[0]),
        Scale::Linear => {
            let width = p.upper - p.lower;
            ((LINEAR[0] * value.abs()).max(LINEAR[1] * width), LONGEST[1] * width)
        }
    };
    let along = |stride: f64| {
        let step = |signed: f64| match p.scale {
            Scale::Logarithmic => value * signed.exp(),
            Scale::Linear => value + signed,
        };
        let signed = if step(stride) > p.upper { -stride } else { stride };
        let mut moved = model.clone();
        moved.values[k] = step(signed).max(p.lower);
        let mut change = data.readings(&moved);
        change.iter_mut().zip(readings).for_each(|(y, y0)| *y -= y0);
        let square = change.iter().map(|d| d * d).sum::<f64>() / change.len().max(1) as f64;
        change.iter_mut().for_each(|d| *d /= signed);
        (change, square.sqrt())
    };
    let (column, moved_kpa) = along(first);
    let factor = data.noise_kpa / moved_kpa;
    let next = (first * factor.clamp(FACTOR.recip(), FACTOR)).min(longest);
    if (NEAR.recip()..NEAR).contains(&(next / first)) || !moved_kpa.is_finite() {
        return column;
    }
    along(next).0
}
