//! Sensitivities of a loop that hunts.
//!
//! Two simulations that differ by next to nothing soon hunt out of step. The exact derivative along
//! one of them grows without bound and says nothing about where the error falls. What does is the
//! secant over a change that moves the readings about as far as their noise: far beyond what being
//! out of step does.

use crate::diagnosis::channel::{ChannelData, Extended, readings_of};
use crate::model::{Parameter, Scale};

/// First stride on a logarithmic scale ...
const LOGARITHMIC: f64 = 0.05;
/// ... and on a linear one as a part of the value, where it is at least a part of the bounds'
/// distance.
const LINEAR: [f64; 2] = [0.12, 1e-4];
/// Longest stride on a logarithmic scale, and as a part of the bounds' distance on a linear one.
const LONGEST: [f64; 2] = [0.5, 0.05];
/// A stride is corrected when the change that it makes is not the wanted one within a factor ...
const NEAR: f64 = 3.0;
/// ... by no more than this factor.
const FACTOR: f64 = 10.0;

/// Readings and their secants by the free parameters, as [`ChannelData::sensitivities`] has
/// derivatives.
#[must_use]
pub fn secants(data: &ChannelData, model: &Extended, free: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let parameters = model.parameters(&data.plant);
    let secants: Vec<Secant> = free.iter().map(|&k| Secant::new(model, &parameters[k], k)).collect();
    let first = secants.iter().map(|secant| secant.moved(model, secant.first));
    let mut all = readings_of(data, &first.chain([model.clone()]).collect::<Vec<_>>());
    let readings = all.pop().unwrap_or_default();
    let mut columns: Vec<Vec<f64>> = secants
        .iter()
        .zip(&all)
        .map(|(secant, moved)| secant.slope(secant.first, moved, &readings))
        .collect();
    // Once more where the first stride was much too short or too long.
    let again: Vec<(usize, f64)> = secants
        .iter()
        .zip(&all)
        .enumerate()
        .filter_map(|(k, (secant, moved))| {
            Some((k, secant.next(distance(moved, &readings), data.noise_kpa)?))
        })
        .collect();
    let models: Vec<Extended> = again.iter().map(|&(k, stride)| secants[k].moved(model, stride)).collect();
    for (&(k, stride), moved) in again.iter().zip(readings_of(data, &models)) {
        columns[k] = secants[k].slope(stride, &moved, &readings);
    }
    let mut matrix = Vec::with_capacity(readings.len() * free.len());
    for row in 0..readings.len() {
        matrix.extend(columns.iter().map(|column| column[row]));
    }
    (readings, matrix)
}

/// Root of the mean squared difference.
fn distance(moved: &[f64], readings: &[f64]) -> f64 {
    let square: f64 = moved.iter().zip(readings).map(|(y, y0)| (y - y0) * (y - y0)).sum();
    (square / readings.len().max(1) as f64).sqrt()
}

/// The change of one parameter.
struct Secant {
    /// Position of the parameter.
    position: usize,
    value: f64,
    bounds: (f64, f64),
    scale: Scale,
    /// First and longest stride.
    first: f64,
    longest: f64,
}

impl Secant {
    fn new(model: &Extended, p: &Parameter, position: usize) -> Self {
        let value = model.values[position];
        let (first, longest) = match p.scale {
            Scale::Logarithmic => (LOGARITHMIC, LONGEST[0]),
            Scale::Linear => {
                let width = p.upper - p.lower;
                ((LINEAR[0] * value.abs()).max(LINEAR[1] * width), LONGEST[1] * width)
            }
        };
        Self { position, value, bounds: (p.lower, p.upper), scale: p.scale, first, longest }
    }

    /// The value a signed stride away.
    fn at(&self, signed: f64) -> f64 {
        self.scale.moved(self.value, signed)
    }

    /// A stride's sign: backwards where there is no room.
    fn signed(&self, stride: f64) -> f64 {
        if self.at(stride) > self.bounds.1 { -stride } else { stride }
    }

    fn moved(&self, model: &Extended, stride: f64) -> Extended {
        let mut moved = model.clone();
        moved.values[self.position] = self.at(self.signed(stride)).max(self.bounds.0);
        moved
    }

    /// Change of the readings by the parameter's coordinate.
    fn slope(&self, stride: f64, moved: &[f64], readings: &[f64]) -> Vec<f64> {
        let signed = self.signed(stride);
        moved.iter().zip(readings).map(|(y, y0)| (y - y0) / signed).collect()
    }

    /// A better stride than the first, which moved the readings so far.
    fn next(&self, moved_kpa: f64, noise_kpa: f64) -> Option<f64> {
        let factor = noise_kpa / moved_kpa;
        let next = (self.first * factor.clamp(FACTOR.recip(), FACTOR)).min(self.longest);
        let near = (NEAR.recip()..NEAR).contains(&(next / self.first));
        (!near && moved_kpa.is_finite()).then_some(next)
    }
}
