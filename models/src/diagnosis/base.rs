//! The base model, fitted to each channel before anything is named.

use rayon::prelude::*;

use super::blocks::Role;
use super::channel::{ChannelData, Extended};
use super::fit::refit;
use super::whiten::Whitening;
use crate::effects::Kind;

/// Areas at which the search for the valve's gain begins, mm^2 per 1e-4 m^3 of volume: fills that take from minutes to milliseconds.
const GAINS: [f64; 7] = [0.02, 0.07, 0.2, 0.7, 2.0, 7.0, 20.0];
/// Drives at which the search for the edges begins.
const EDGES: [f64; 3] = [0.0, 0.06, 0.2];

/// Starts that are looked at.
const LEAST_LOOKS: usize = 2;
/// Starts that are looked at in a recording of fewer than [`SHORT`] compared rows.
const MOST_LOOKS: usize = 12;
/// See [`MOST_LOOKS`].
const SHORT: usize = 4000;
/// Evaluations spent on each of the best starts.
const LOOK: usize = 6;
/// Evaluations spent, twice, on the better one.
const EARNEST: usize = 12;

/// Positions of the base model's free parameters.
#[must_use]
pub fn free_base(data: &ChannelData) -> Vec<usize> {
    let count = data.plant.parameters().len();
    let still = data.inputs.volume_rate_m3_s.iter().all(|v| v.abs() <= 0.0);
    (0..count)
        .filter(|&k| !(data.plant.kind != Kind::Linear && still && k == data.plant.volume_weight()))
        .collect()
}

/// Fits the base model to a channel from a grid of starts.
#[must_use]
pub fn fit_base(data: &ChannelData) -> Extended {
    let nominal: Vec<f64> = data.plant.parameters().iter().map(|p| p.nominal).collect();
    let volume = data.inputs.volume_m3.first().copied().unwrap_or(1e-4);
    let mut starts = Vec::new();
    match data.plant.kind {
        Kind::Linear => starts.extend([0.3, 1.0, 3.0, 10.0, 30.0].map(|rate| vec![rate, rate])),
        Kind::Nonlinear(_) => {
            let gains = GAINS.map(|g| g * volume / 1e-4 / data.plant.discharge_coefficient);
            for edge in EDGES {
                for gain in gains {
                    let mut values = nominal.clone();
                    (values[0], values[1]) = (0.003 * gain, 0.003 * gain);
                    if !data.plant.separate() {
                        values[2] = gain;
                        (values[3], values[4], values[5]) = (edge, -edge, 0.03 * gain);
                        starts.push(values);
                        continue;
                    }
                    // Two valves may be of very different size: one from a high supply, one to the air.
                    for vent in gains {
                        let mut values = values.clone();
                        values[1] = 0.003 * vent;
                        (values[2], values[3]) = (gain, vent);
                        (values[4], values[5], values[6]) = (edge, edge, 0.03 * gain.min(vent));
                        starts.push(values);
                    }
                }
            }
        }
    }
    let parameters = data.plant.parameters();
    let mut ranked: Vec<(f64, Extended)> = starts
        .into_par_iter()
        .map(|mut values| {
            for (value, p) in values.iter_mut().zip(&parameters) {
                *value = value.clamp(p.lower, p.upper);
            }
            let model = Extended::base(values);
            (plain_cost(data, &model), model)
        })
        .filter(|(cost, _)| cost.is_finite())
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let free = free_base(data);
    // A few steps from the best starts, then in earnest from the better; the weights depend on the model.
    let step = |model: Extended, evaluations: usize| {
        let whitening = Whitening::new(data, &data.disturbances(&model));
        refit(data, &whitening, &model, &free, evaluations).0
    };
    // A short recording has more valleys, and looking costs less.
    let looks = if data.rows.len() < SHORT { MOST_LOOKS } else { LEAST_LOOKS };
    ranked.truncate(looks);
    let looked: Vec<(f64, Extended)> = ranked
        .into_par_iter()
        .map(|(_, start)| {
            let model = step(start, LOOK);
            (plain_cost(data, &model), model)
        })
        .collect();
    let best = looked.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((_, model)) => step(step(model, EARNEST), EARNEST),
        None => Extended::base(nominal),
    }
}

/// Mean squared residual on the fit blocks, kPa^2.
fn plain_cost(data: &ChannelData, model: &Extended) -> f64 {
    let r = data.residuals(model);
    let fit = data.blocks.iter().zip(&data.spans).filter(|(b, _)| b.role == Role::Fit);
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (_, span) in fit {
        sum += r[span.clone()].iter().map(|v| v * v).sum::<f64>();
        count += span.len() as f64;
    }
    sum / count.max(1.0)
}
