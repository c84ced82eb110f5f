//! A smooth [`Correction`] of what no name fits, fitted along a dependence of the residual (Kennedy
//! and O'Hagan, Journal of the Royal Statistical Society B 63, 2001, with a handful of hat
//! functions in the place of their Gaussian process).

use crate::diagnosis::channel::hats;
use nalgebra::{DMatrix, DVector};

use super::residual_test::Dependence;
use crate::diagnosis::channel::{ChannelData, Correction, Extended, HATS, Role, rows_of};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::{block_losses, whitened_residuals};
use crate::diagnosis::resampling::bootstrap;

/// Steps of the fit at most.
const STEPS: usize = 4;
/// Weight of the heights' own size against the data, as a part of the data's mean weight.
const RIDGE: f64 = 1e-3;

/// Fits a correction along a dependence, the model's own parameters giving way. `None` when it does
/// not make the blocks better that were neither fitted nor are to measure the gain.
#[must_use]
pub fn fit_correction(data: &ChannelData, stage: &ChannelStage, along: &Dependence) -> Option<Extended> {
    let mut model = stage.model.clone();
    model.correction =
        Some(Correction { variable: along.variable, knots: along.knots.clone(), heights: vec![0.0; HATS] });
    let losses = |model: &Extended| {
        block_losses(data, &whitened_residuals(data, &stage.whitening, &data.readings(model)))
    };
    let of = |losses: &[f64], role: Role| -> Vec<f64> {
        data.blocks.iter().zip(losses).filter(|(b, _)| b.role == role).map(|(_, l)| *l).collect()
    };
    let before = losses(&model);
    let mut now = before.clone();
    for _ in 0..STEPS {
        let step = gauss_newton(data, stage, &model)?;
        let fit: f64 = of(&now, Role::Fit).iter().sum();
        let next = [1.0, 0.5, 0.25].into_iter().find_map(|part| {
            let tried = moved(data, stage, &model, &step, part);
            let losses = losses(&tried);
            let better = of(&losses, Role::Fit).iter().sum::<f64>() < fit;
            better.then_some((tried, losses))
        });
        let Some((tried, losses)) = next else { break };
        let gained = 1.0 - of(&losses, Role::Fit).iter().sum::<f64>() / fit;
        (model, now) = (tried, losses);
        if gained < 1e-3 {
            break;
        }
    }
    let (a, b) = (of(&before, Role::Select), of(&now, Role::Select));
    let [_, low, ..] = bootstrap(&a, &b, |a, b| a - b);
    (low > 0.0).then_some(model)
}

/// The full step of free parameters (in their coordinates) and heights on the fit blocks.
fn gauss_newton(data: &ChannelData, stage: &ChannelStage, model: &Extended) -> Option<Vec<f64>> {
    let own = stage.free.len();
    let width = own + HATS;
    let (readings, mut parameters) = data.sensitivities(model, &stage.free);
    let correction = model.correction.as_ref()?;
    let plain = data.trace(&model.uncorrected());
    let values = data.series(&plain, correction.variable)?;
    let weights: Vec<[f64; HATS]> = values.iter().map(|v| hats(&correction.knots, *v)).collect();
    let mut heights: Vec<f64> = data.rate_derivatives(model, &weights).into_iter().flatten().collect();
    stage.whitening.apply_columns(&mut parameters, own);
    stage.whitening.apply_columns(&mut heights, HATS);
    let residuals = whitened_residuals(data, &stage.whitening, &readings);
    let mut gram = DMatrix::<f64>::zeros(width, width);
    let mut right = DVector::<f64>::zeros(width);
    for row in rows_of(data, &[Role::Fit]) {
        let of_parameters = &parameters[row * own..(row + 1) * own];
        let of_heights = &heights[row * HATS..(row + 1) * HATS];
        let j: Vec<f64> = of_parameters.iter().chain(of_heights).map(|v| v / data.noise_kpa).collect();
        for a in 0..width {
            right[a] += j[a] * residuals[row];
            for b in 0..width {
                gram[(a, b)] += j[a] * j[b];
            }
        }
    }
    let mean = (own..width).map(|k| gram[(k, k)]).sum::<f64>() / HATS as f64;
    for k in 0..width {
        if k < own {
            gram[(k, k)] = gram[(k, k)] * (1.0 + 1e-6) + 1e-12;
        } else {
            gram[(k, k)] += RIDGE * mean + 1e-9;
            right[k] -= RIDGE * mean * correction.heights[k - own];
        }
    }
    Some(gram.cholesky()?.solve(&right).as_slice().to_vec())
}

fn moved(data: &ChannelData, stage: &ChannelStage, model: &Extended, step: &[f64], part: f64) -> Extended {
    let mut next = model.clone();
    let parameters = model.parameters(&data.plant);
    for (&position, change) in stage.free.iter().zip(step) {
        let p = &parameters[position];
        let value = p.scale.moved(model.values[position], part * change);
        next.values[position] = value.clamp(p.lower, p.upper);
    }
    if let Some(correction) = &mut next.correction {
        for (height, change) in correction.heights.iter_mut().zip(&step[stage.free.len()..]) {
            *height += part * change;
        }
    }
    next
}
