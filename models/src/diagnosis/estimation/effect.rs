//! An effect and the model's own parameters fitted together, thresholds by looking around.

use super::frozen_jacobian::refit_with;
use super::least_squares::refit;
use super::linearization::ChannelStage;
use super::objective::{BlockObjective, Derivatives};
use crate::diagnosis::channel::{ChannelData, Extended, Role, readings_of};
use crate::diagnosis::likelihood::{block_losses, hunts, likelier, total, whitened_residuals};
use crate::effects::catalogue::CATALOGUE;

/// Distance of the thresholds that are looked at first, as a factor.
const THRESHOLD_FACTOR: f64 = 1.35;
/// Thresholds that are looked at on either side of the start.
const SCAN: i32 = 7;
/// Valleys that are followed in one direction where a loop hunts.
const VALLEYS: usize = 3;
/// Evaluations that are too few for it.
const VALLEYS_FROM: usize = 5;
/// Simulations in which the other parameters follow a threshold.
const FOLLOW: usize = 3;

/// Positions of what is free in a model with one more effect.
#[must_use]
pub fn free_with(data: &ChannelData, stage: &ChannelStage, model: &Extended, effect: usize) -> Vec<usize> {
    let Some(inserted) = model.range(&data.plant, effect) else {
        return stage.free.clone();
    };
    let mut free: Vec<usize> =
        stage.free.iter().filter_map(|&k| stage.moved(data, k, effect)).chain(inserted).collect();
    free.sort_unstable();
    free
}

/// Fits an effect on a channel from a start, with so many evaluations of the model.
#[must_use]
pub fn fit_from(
    data: &ChannelData,
    stage: &ChannelStage,
    start: &Extended,
    effect: usize,
    evaluations: usize,
) -> Extended {
    let free = free_with(data, stage, start, effect);
    if !CATALOGUE[effect].is_thresholded() {
        return refit(data, &stage.whitening, start, &free, evaluations).0;
    }
    // A threshold has no derivative: look around it, the rest following, and narrow down.
    let Some(range) = start.range(&data.plant, effect) else {
        return start.clone();
    };
    let position = range.start;
    let rest: Vec<usize> = free.iter().copied().filter(|k| *k != position).collect();
    let objective = |model: &Extended| BlockObjective {
        data,
        whitening: &stage.whitening,
        model: model.clone(),
        free: rest.clone(),
        roles: &[Role::Fit],
    };
    let bounds = (CATALOGUE[effect].parameters[0].lower, CATALOGUE[effect].parameters[0].upper);
    let at = |k: i32| {
        let mut model = start.clone();
        let value = start.values[position] * THRESHOLD_FACTOR.powi(k);
        model.values[position] = value.clamp(bounds.0, bounds.1);
        model
    };
    // The cost has many valleys: look at a whole range first, the rest as it is.
    let scanned: Vec<Extended> = (-SCAN..=SCAN).map(at).collect();
    let cost = |readings: &Vec<f64>| {
        let residuals = whitened_residuals(data, &stage.whitening, readings);
        total(data, &block_losses(data, &residuals), &[Role::Fit])
    };
    let costs: Vec<f64> = readings_of(data, &scanned).iter().map(cost).collect();
    let best = scanned.iter().zip(&costs).min_by(|a, b| a.1.total_cmp(b.1));
    let start = best.map_or_else(|| start.clone(), |(model, _)| model.clone());
    if hunts(data, &start) {
        return valley_by_valley(&objective(&start), &free, position, bounds, evaluations);
    }
    let mut best = refit(data, &stage.whitening, &start, &rest, evaluations.div_ceil(2)).0;
    let Derivatives { matrix: mut derivatives, cost: mut least, .. } = objective(&best).derivatives();
    let mut factor = THRESHOLD_FACTOR.sqrt();
    for _ in 0..evaluations {
        let centre = best.values[position];
        let mut moved = false;
        for value in [centre / factor, centre * factor] {
            let mut model = best.clone();
            model.values[position] = value.clamp(bounds.0, bounds.1);
            let (model, c) = refit_with(&objective(&model), &derivatives, FOLLOW);
            if c < least {
                derivatives = objective(&model).derivatives().matrix;
                (best, least, moved) = (model, c, true);
                break;
            }
        }
        if !moved {
            factor = factor.sqrt();
        }
    }
    refit(data, &stage.whitening, &best, &rest, evaluations.div_ceil(2)).0
}

/// Fits everything from where an objective's model stands and from thresholds next to it, as long
/// as one of them is better. The secants of a loop that hunts are slopes by the threshold too, as
/// far as the next valley.
fn valley_by_valley(
    objective: &BlockObjective<'_>,
    free: &[usize],
    position: usize,
    bounds: (f64, f64),
    evaluations: usize,
) -> Extended {
    let BlockObjective { data, whitening, .. } = *objective;
    let fit = |model: &Extended| {
        let fitted = refit(data, whitening, model, free, evaluations.div_ceil(2)).0;
        likelier(data, whitening, [model.clone(), fitted])
    };
    let mut best = fit(&objective.model);
    if evaluations < VALLEYS_FROM {
        return best.1;
    }
    for factor in [THRESHOLD_FACTOR, THRESHOLD_FACTOR.recip()] {
        for _ in 0..VALLEYS {
            let mut next = best.1.clone();
            next.values[position] = (next.values[position] * factor).clamp(bounds.0, bounds.1);
            let next = fit(&next);
            if next.0 >= best.0 {
                break;
            }
            best = next;
        }
    }
    best.1
}
