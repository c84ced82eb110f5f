//! Effects that passed the gate, refitted in earnest.

use rayon::prelude::*;

use super::beside::readings_of;
use super::blocks::Role;
use super::channel::{ChannelData, Extended};
use super::chord::refit_with;
use super::fit::{BlockObjective, refit};
use super::hunting::{hunts, likelier};
use super::losses::{Losses, least_gain, row_count, total};
use super::probe::Trial;
use super::random::{generator, quantile, runs};
use super::stage::{ChannelStage, OPEN, block_losses, whitened_residuals};
use crate::effects::Reach;
use crate::effects::catalogue::CATALOGUE;

/// A second start is looked at when what it promises is not worse by more than this factor.
const SECOND: f64 = 1.5;
/// A channel whose mean squared residual is larger by this factor than the best one's is tried from that one's model.
const WORSE: f64 = 1.5;
/// Effects whose first parameter is a threshold: where it is passed a little later, everything after it is different.
const STEPPED: [&str; 2] = ["valve_stiction", "dead_band"];
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
/// Smaller than this part of another channel's size, and smaller than what is worth a name, an effect does not act on a channel, however
/// sure the difference is: something else is not described to the last digit.
const TRACES: f64 = 0.2;
/// Resamples of blocks.
const RESAMPLES: usize = 999;
/// A channel belongs to a cause when its improvement over the blocks is this many standard errors.
const CHANNEL_ERRORS: f64 = 2.0;

/// One effect refitted on every channel.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Number of the effect.
    pub effect: usize,
    /// Models with it, channel by channel; the stage's where it does not act.
    pub models: Vec<Extended>,
    /// Where it acts.
    pub acts: Vec<bool>,
    /// What they leave, channel by channel.
    pub losses: Vec<Losses>,
}

/// Refits one effect on every channel with some evaluations of the model, from where an earlier refit ended or, without one, from
/// the best trials.
#[must_use]
pub fn refit_effect(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    trials: &[Vec<Trial>],
    effect: usize,
    before: Option<&Candidate>,
    evaluations: usize,
) -> Candidate {
    let fitted: Vec<(Extended, Losses, bool)> = channels
        .par_iter()
        .zip(stages)
        .zip(trials)
        .enumerate()
        .map(|(k, ((data, stage), trials))| {
            let kept = stage.losses.clone();
            if let Some(look) = before {
                if !look.models[k].effects.contains(&effect) {
                    return (stage.model.clone(), kept, false);
                }
                let model = fit_from(data, stage, &look.models[k], effect, evaluations);
                let losses = losses_of(data, stage, &model);
                let acts = acts(data, stage, &model, &losses);
                return (model, losses, acts);
            }
            let mut starts: Vec<&Trial> = trials.iter().filter(|t| t.effect == effect).collect();
            starts.sort_by(|a, b| a.loss.total_cmp(&b.loss));
            let limit = starts.first().map_or(0.0, |t| t.loss * SECOND);
            let mut best: Option<(f64, Extended, Losses)> = None;
            for start in starts.into_iter().take(2).filter(|t| t.loss <= limit) {
                let model = fit_from(data, stage, &start.start, effect, evaluations);
                let losses = losses_of(data, stage, &model);
                let fit = total(data, &losses.deviance, &[Role::Fit]);
                if fit.is_finite() && best.as_ref().is_none_or(|(c, _, _)| fit < *c) {
                    best = Some((fit, model, losses));
                }
            }
            match best {
                Some((_, model, losses)) => {
                    let acts = acts(data, stage, &model, &losses);
                    (model, losses, acts)
                }
                None => (stage.model.clone(), kept, false),
            }
        })
        .collect();
    assemble(channels, stages, effect, fitted)
}

/// Channels of one rig resemble each other: where one is fitted much worse than the best one, starts it from that one's model and
/// keeps what is better.
#[must_use]
pub fn borrow(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    candidate: &Candidate,
    evaluations: usize,
) -> Candidate {
    let effect = candidate.effect;
    let mean = |k: usize, losses: &[f64]| {
        let data = &channels[k];
        total(data, losses, &OPEN) / row_count(data, &OPEN).max(1.0)
    };
    let means: Vec<f64> = (0..channels.len()).map(|k| mean(k, &candidate.losses[k].deviance)).collect();
    let acting = (0..channels.len()).filter(|&k| candidate.acts[k]);
    let Some(best) = acting.min_by(|&a, &b| means[a].total_cmp(&means[b])) else {
        return candidate.clone();
    };
    let lender = &candidate.models[best];
    let fitted = channels
        .par_iter()
        .zip(stages)
        .enumerate()
        .map(|(k, (data, stage))| {
            let own = (candidate.models[k].clone(), candidate.losses[k].clone(), candidate.acts[k]);
            let same = lender.without(&channels[best].plant, effect).effects == stage.model.effects;
            if !same || means[k] < WORSE * means[best] {
                return own;
            }
            let model = fit_from(data, stage, lender, effect, evaluations);
            let losses = losses_of(data, stage, &model);
            if total(data, &losses.deviance, &[Role::Fit]) < total(data, &own.1.deviance, &[Role::Fit]) {
                let acts = acts(data, stage, &model, &losses);
                (model, losses, acts)
            } else {
                own
            }
        })
        .collect();
    assemble(channels, stages, effect, fitted)
}

/// Decides on which channels an effect acts.
fn assemble(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    effect: usize,
    fitted: Vec<(Extended, Losses, bool)>,
) -> Candidate {
    let shared = CATALOGUE[effect].reach == Reach::Rig;
    let clear = fitted.iter().filter(|(_, _, acts)| *acts).count();
    let any = clear > 0;
    // Where most channels show it clearly, a channel that shows it faintly has it too.
    let common = 2 * clear >= fitted.len().max(2);
    let sizes: Vec<f64> =
        fitted.iter().zip(channels).map(|((model, ..), data)| size(data, model, effect)).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let mut candidate = Candidate { effect, models: Vec::new(), acts: Vec::new(), losses: Vec::new() };
    for (k, (model, losses, acts)) in fitted.into_iter().enumerate() {
        let faint = common && {
            let falls = |before: &[f64], after: &[f64]| {
                total(&channels[k], after, &OPEN) < total(&channels[k], before, &OPEN)
            };
            let before = &stages[k].losses;
            falls(&before.deviance, &losses.deviance) && falls(&before.beside_error, &losses.beside_error)
        };
        let traces = sizes[k] < CATALOGUE[effect].smallest.min(TRACES * largest);
        let acts = (acts || faint) && !traces || shared && any;
        let acts = acts && model.effects.contains(&effect);
        candidate.models.push(if acts { model } else { stages[k].model.clone() });
        candidate.losses.push(if acts { losses } else { stages[k].losses.clone() });
        candidate.acts.push(acts);
    }
    candidate
}

/// Distance of an effect's size from none, 0 where it does not act.
#[must_use]
pub fn size(data: &ChannelData, model: &Extended, effect: usize) -> f64 {
    let null = CATALOGUE[effect].parameters[0].null;
    model.range(&data.plant, effect).map_or(0.0, |range| (model.values[range.start] - null).abs())
}

fn losses_of(data: &ChannelData, stage: &ChannelStage, model: &Extended) -> Losses {
    let residuals = whitened_residuals(data, &stage.whitening, &data.readings(model));
    Losses::of_one(data, &stage.whitening, model, &residuals)
}

/// Positions of what is free in a model with one more effect.
#[must_use]
pub fn free_with(data: &ChannelData, stage: &ChannelStage, model: &Extended, effect: usize) -> Vec<usize> {
    let Some(inserted) = model.range(&data.plant, effect) else {
        return stage.free.clone();
    };
    let shifted = stage.free.iter().map(|&k| if k < inserted.start { k } else { k + inserted.len() });
    let mut free: Vec<usize> = shifted.chain(inserted.clone()).collect();
    free.sort_unstable();
    free
}

fn fit_from(
    data: &ChannelData,
    stage: &ChannelStage,
    start: &Extended,
    effect: usize,
    evaluations: usize,
) -> Extended {
    let free = free_with(data, stage, start, effect);
    if !STEPPED.contains(&CATALOGUE[effect].id) {
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
    let (mut derivatives, mut least) = objective(&best).derivatives();
    let mut factor = THRESHOLD_FACTOR.sqrt();
    for _ in 0..evaluations {
        let centre = best.values[position];
        let mut moved = false;
        for value in [centre / factor, centre * factor] {
            let mut model = best.clone();
            model.values[position] = value.clamp(bounds.0, bounds.1);
            let (model, c) = refit_with(&objective(&model), &derivatives, FOLLOW);
            if c < least {
                (derivatives, _) = objective(&model).derivatives();
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

/// Fits everything from where an objective's model stands and from thresholds next to it, as long as one of them is better. The secants
/// of a loop that hunts are slopes by the threshold too, as far as the next valley.
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

/// Does the effect improve this channel beyond what differences between blocks explain? Hunting must explain more than a trace of the error:
/// next to a channel that hunts, others do too in the tiniest way.
fn acts(data: &ChannelData, stage: &ChannelStage, model: &Extended, after: &Losses) -> bool {
    let gains = |before: &[f64], after: &[f64]| -> Vec<f64> {
        let pairs = data.blocks.iter().zip(before.iter().zip(after));
        pairs.filter(|(b, _)| OPEN.contains(&b.role)).map(|(_, (before, after))| before - after).collect()
    };
    let surely = |gains: &[f64]| {
        let n = gains.len() as f64;
        let mean = gains.iter().sum::<f64>() / n;
        let variance = gains.iter().map(|g| (g - mean) * (g - mean)).sum::<f64>() / (n * (n - 1.0)).max(1.0);
        mean > CHANNEL_ERRORS * variance.sqrt()
    };
    let before = &stage.losses;
    if !surely(&gains(&before.deviance, &after.deviance)) {
        return false;
    }
    if !hunts(data, model) || hunts(data, &stage.model) {
        return true;
    }
    let gains = gains(&before.beside_error, &after.beside_error);
    surely(&gains) && gains.iter().sum::<f64>() >= least_gain(row_count(data, &OPEN))
}

/// Quantiles (2.5 %, 5 %, 50 %, 95 %, 97.5 %) of a statistic of paired block sums under a moving-block bootstrap.
#[must_use]
pub fn bootstrap(a: &[f64], b: &[f64], run: usize, statistic: impl Fn(f64, f64) -> f64) -> [f64; 5] {
    let mut rng = generator(2);
    let mut values: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn = runs(&mut rng, a.len(), run);
            let sum = |x: &[f64]| drawn.iter().map(|&k| x[k]).sum::<f64>();
            statistic(sum(a), sum(b))
        })
        .collect();
    values.sort_by(f64::total_cmp);
    [0.025, 0.05, 0.5, 0.95, 0.975].map(|q| quantile(&values, q))
}
