//! The search: one cause at a time, everything refitted, until nothing passes.

use rayon::prelude::*;

use super::base::{fit_base, free_base};
use super::blocks::Role;
use super::candidate::{Candidate, bootstrap, borrow, refit_effect, together};
use super::channel::{ChannelData, Extended};
use super::fit::refit;
use super::gate::{Gate, Trial, judge, trials};
use super::stage::{ChannelStage, OPEN, share_draws};
use super::whiten::Whitening;
use crate::effects::Question;
use crate::effects::catalogue::CATALOGUE;

/// Causes that are looked for at most.
const MOST_CAUSES: usize = 4;
/// Candidates that are looked at in a round at most.
const MOST_LOOKS: usize = 10;
/// Candidates that promise less than this part of the best promise are not looked at.
const PROMISE: f64 = 0.2;
/// Evaluations of the model that a first look may spend on each start.
const LOOK: usize = 4;
/// Rounds of refits in earnest: candidates that miss more than a part of the best gain so far drop out, the others may spend some more
/// evaluations.
const EARNEST: [(f64, usize); 3] = [(0.6, 5), (0.4, 6), (0.25, 10)];
/// Evaluations that may be spent when everything is fitted together.
const SETTLE: usize = 20;
/// Times that the best candidate is fitted further where much is left ...
const MORE: usize = 3;
/// ... unless that leaves more than this part of it.
const STUCK: f64 = 0.95;
/// Level of the gate.
pub const LEVEL: f64 = 0.05;
/// Smallest reduction of the whitened error on blocks not fitted that is worth a name.
pub const PRACTICAL: f64 = 0.01;
/// Mean squared whitened error, in variances of the noise, that is plainly not explained.
const LARGE_ERROR: f64 = 2.0;
/// Names that leave more than this part of it are withdrawn.
const FORCED: f64 = 0.5;
/// A rival explains as well when its squared error is larger by no more than this part of the winner's ...
pub const TIE_SHARE: f64 = 0.01;
/// ... or when differences between blocks could account for what it leaves, and that is no more than this part of the gain.
const TIE_GAIN: f64 = 0.25;

/// A cause as the search found it.
#[derive(Debug, Clone)]
pub struct Found {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// Where it acts, channel by channel.
    pub acts: Vec<bool>,
    /// p-value of its gate.
    pub p_value: f64,
    /// Numbers of the effects that explain as well.
    pub equivalent: Vec<usize>,
    /// Models before it was added.
    pub before: Vec<Extended>,
    /// Models of the rivals, for the next experiment.
    pub rivals: Vec<Candidate>,
}

/// An effect in one round of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct Considered {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// Its statistic.
    pub statistic: f64,
    /// Its p-value over the whole catalogue.
    pub p_value: f64,
    /// Squared whitened error on the open blocks without it.
    pub kept: f64,
    /// The same with it, where it was refitted.
    pub loss: Option<f64>,
}

/// Where the search ended.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Base models.
    pub base: Vec<Extended>,
    /// Causes in the order of their gain.
    pub causes: Vec<Found>,
    /// Final stages.
    pub stages: Vec<ChannelStage>,
    /// What the gate says after the last cause.
    pub gates: Vec<Gate>,
    /// What the gate said at first.
    pub first_gates: Vec<Gate>,
    /// What was considered in every round.
    pub rounds: Vec<Vec<Considered>>,
}

/// What the search tells while it runs.
pub type Progress<'a> = dyn Fn(&str, u64) + Sync + 'a;

/// Runs the search. `reference` are calibrated models, whose parameters are then kept (question of change).
#[must_use]
pub fn search(
    channels: &mut [ChannelData],
    reference: Option<Vec<Extended>>,
    progress: &Progress<'_>,
) -> Outcome {
    let question = if reference.is_some() { Question::Change } else { Question::Structure };
    progress("fitting the base model", 0);
    let base: Vec<Extended> = match reference {
        Some(models) => models,
        None => channels.par_iter().map(fit_base).collect(),
    };
    let fixed = question == Question::Change;
    share_draws(channels, &base);
    let mut stages: Vec<ChannelStage> = channels
        .par_iter()
        .zip(&base)
        .map(|(data, model)| {
            ChannelStage::new(data, model.clone(), if fixed { Vec::new() } else { free_base(data) })
        })
        .collect();
    let first = stages.clone();
    let mut causes: Vec<Found> = Vec::new();
    let mut first_gates = Vec::new();
    let mut rounds = Vec::new();
    let mut gates;
    loop {
        progress("trying the catalogue", causes.len() as u64);
        let tried = trials(channels, &stages, question, &|| progress("", 1));
        gates = judge(&tried);
        if causes.is_empty() {
            first_gates.clone_from(&gates);
        }
        if causes.len() >= MOST_CAUSES {
            break;
        }
        progress("refitting what passed", causes.len() as u64);
        let Some((winner, ranked)) = round(channels, &stages, &tried, &gates, &mut rounds) else {
            break;
        };
        let equivalent = rivals(channels, &stages, &ranked, winner);
        let gate = gates.iter().find(|g| g.effect == ranked[winner].effect);
        let found = Found {
            effect: ranked[winner].effect,
            acts: ranked[winner].acts.clone(),
            p_value: gate.map_or(1.0, |g| g.p_value),
            equivalent: equivalent.iter().map(|&k| ranked[k].effect).collect(),
            before: stages.iter().map(|s| s.model.clone()).collect(),
            rivals: equivalent.iter().map(|&k| ranked[k].clone()).collect(),
        };
        let models = ranked[winner].models.clone();
        causes.push(found);
        stages = settle(channels, &models, fixed);
    }
    eliminate(channels, &mut stages, &mut causes, fixed);
    if !causes.is_empty() && forced(channels, &first, &stages) {
        causes.clear();
        stages = first;
        share_draws(channels, &base);
    }
    Outcome { base, causes, stages, gates, first_gates, rounds }
}

/// Do names that explain less than half of a large error only imitate what is not in the catalogue?
fn forced(channels: &[ChannelData], first: &[ChannelStage], last: &[ChannelStage]) -> bool {
    let rows = open_rows(channels);
    let (before, after) = (kept_total(channels, first) / rows, kept_total(channels, last) / rows);
    after > LARGE_ERROR && after - 1.0 > FORCED * (before - 1.0)
}

/// Number of compared rows in the open blocks of all channels.
fn open_rows(channels: &[ChannelData]) -> f64 {
    let blocks = channels.iter().flat_map(|d| d.blocks.iter().zip(&d.spans));
    blocks.filter(|(b, _)| OPEN.contains(&b.role)).map(|(_, span)| span.len() as f64).sum()
}

/// Positions of a model's free parameters.
fn free_of(data: &ChannelData, model: &Extended, fixed: bool) -> Vec<usize> {
    let base = data.plant.parameters().len();
    let own = if fixed { Vec::new() } else { free_base(data) };
    own.into_iter().chain(base..model.values.len()).collect()
}

/// Refits models with the weights that go with them.
fn settle(channels: &mut [ChannelData], models: &[Extended], fixed: bool) -> Vec<ChannelStage> {
    share_draws(channels, models);
    channels
        .par_iter()
        .zip(models)
        .map(|(data, model)| {
            let free = free_of(data, model, fixed);
            let whitening = Whitening::new(data, &data.disturbances(model));
            let (model, _) = refit(data, &whitening, model, &free, SETTLE);
            ChannelStage::new(data, model, free)
        })
        .collect()
}

impl Outcome {
    /// Takes all names back.
    pub fn withdraw(&mut self, channels: &mut [ChannelData], base: &[ChannelStage]) {
        self.causes.clear();
        self.stages = base.to_vec();
        share_draws(channels, &self.base);
    }

    /// Fits all models again, after the channels' simulation has become finer.
    pub fn refine(&mut self, channels: &mut [ChannelData], change: bool) {
        let again = |channels: &mut [ChannelData], models: &[Extended]| settle(channels, models, change);
        let models = |stages: &[ChannelStage]| stages.iter().map(|s| s.model.clone()).collect::<Vec<_>>();
        let coarse = self.base.clone();
        if !change {
            self.base = models(&again(channels, &coarse));
        }
        for cause in &mut self.causes {
            cause.before = if cause.before == coarse {
                self.base.clone()
            } else {
                models(&again(channels, &cause.before))
            };
        }
        self.stages = again(channels, &models(&self.stages));
    }
}

/// Refits what passed the gate; returns the winner and all candidates, best first, when one is worth naming.
fn round(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    tried: &[Vec<Trial>],
    gates: &[Gate],
    rounds: &mut Vec<Vec<Considered>>,
) -> Option<(usize, Vec<Candidate>)> {
    let mut passed: Vec<(f64, usize)> = gates
        .iter()
        .filter(|g| g.p_value <= LEVEL)
        .map(|g| (promise(channels, stages, tried, g.effect), g.effect))
        .collect();
    passed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = kept_total(channels, stages);
    let promised = passed.first().map_or(0.0, |p| whole - p.0);
    passed.retain(|p| whole - p.0 >= PROMISE * promised);
    passed.truncate(MOST_LOOKS);
    let look = |effect: usize, before: Option<&Candidate>, evaluations: usize| {
        let candidate = refit_effect(channels, stages, tried, effect, before, evaluations);
        let loss: f64 = together(channels, &candidate.losses, &OPEN).iter().sum();
        (loss, candidate)
    };
    // A first look at all, then in earnest at the best.
    let mut ranked: Vec<(f64, Candidate)> =
        passed.par_iter().map(|&(_, effect)| look(effect, None, LOOK)).collect();
    for (near, evaluations) in EARNEST {
        let least = ranked.iter().map(|c| c.0).fold(f64::INFINITY, f64::min);
        ranked = ranked
            .into_par_iter()
            .map(|(loss, candidate)| {
                if loss - least > near * (whole - least) {
                    (loss, candidate)
                } else {
                    let (_, candidate) = look(candidate.effect, Some(&candidate), evaluations);
                    let candidate = borrow(channels, stages, &candidate, evaluations);
                    let loss: f64 = together(channels, &candidate.losses, &OPEN).iter().sum();
                    (loss, candidate)
                }
            })
            .collect();
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Where much is left the best may not have arrived yet.
    if let Some((loss, best)) = ranked.first_mut() {
        for _ in 0..MORE {
            if *loss <= LARGE_ERROR * open_rows(channels) {
                break;
            }
            let (_, further) = look(best.effect, Some(best), SETTLE);
            let further = borrow(channels, stages, &further, SETTLE);
            let next: f64 = together(channels, &further.losses, &OPEN).iter().sum();
            let stuck = next > STUCK * *loss;
            if next < *loss {
                (*loss, *best) = (next, further);
            }
            if stuck {
                break;
            }
        }
    }
    let ranked: Vec<Candidate> = ranked.into_iter().map(|(_, c)| c).collect();
    let kept: Vec<Vec<f64>> = channels.iter().zip(stages).map(|(d, s)| s.losses(d)).collect();
    let before = together(channels, &kept, &[Role::Select]);
    let considered = gates
        .iter()
        .map(|gate| {
            let refitted = ranked.iter().find(|c| c.effect == gate.effect);
            let loss = refitted.map(|c| together(channels, &c.losses, &OPEN).iter().sum());
            Considered {
                effect: gate.effect,
                statistic: gate.statistic,
                p_value: gate.p_value,
                kept: whole,
                loss,
            }
        })
        .collect();
    rounds.push(considered);
    let winner = ranked.iter().position(|candidate| worth_naming(channels, candidate, &before))?;
    Some((winner, ranked))
}

fn kept_total(channels: &[ChannelData], stages: &[ChannelStage]) -> f64 {
    let kept: Vec<Vec<f64>> = channels.iter().zip(stages).map(|(d, s)| s.losses(d)).collect();
    together(channels, &kept, &OPEN).iter().sum()
}

/// Sum over the channels of the least loss that a probe promises.
fn promise(channels: &[ChannelData], stages: &[ChannelStage], tried: &[Vec<Trial>], effect: usize) -> f64 {
    let mut sum = 0.0;
    for ((data, stage), trials) in channels.iter().zip(stages).zip(tried) {
        let kept = super::candidate::total(data, &stage.losses(data), &OPEN);
        let least =
            trials.iter().filter(|t| t.effect == effect).map(|t| t.loss).fold(f64::INFINITY, f64::min);
        sum += least.min(kept);
    }
    sum
}

fn worth_naming(channels: &[ChannelData], candidate: &Candidate, before: &[f64]) -> bool {
    if !candidate.acts.iter().any(|a| *a) {
        return false;
    }
    let after = together(channels, &candidate.losses, &[Role::Select]);
    let [low, ..] = bootstrap(before, &after, 1, |a, b| 1.0 - (b / a).sqrt());
    let gain = 1.0 - (after.iter().sum::<f64>() / before.iter().sum::<f64>()).sqrt();
    low > 0.0 && gain >= PRACTICAL && large_enough(channels, candidate)
}

/// Is the effect's size beyond what timing and rounding can look like?
fn large_enough(channels: &[ChannelData], candidate: &Candidate) -> bool {
    let info = CATALOGUE[candidate.effect];
    let sizes = candidate.models.iter().zip(channels).zip(&candidate.acts).filter(|(_, acts)| **acts);
    sizes
        .filter_map(|((model, data), _)| {
            model.range(&data.plant, candidate.effect).map(|r| model.values[r.start])
        })
        .any(|value| (value - info.parameters[0].null).abs() >= info.smallest)
}

/// Candidates that explain the open blocks as well as the winner: a paired bootstrap over blocks cannot tell them apart, or what
/// they leave is negligible against the gain.
fn rivals(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    ranked: &[Candidate],
    winner: usize,
) -> Vec<usize> {
    let kept: Vec<Vec<f64>> = channels.iter().zip(stages).map(|(d, s)| s.losses(d)).collect();
    let before: f64 = together(channels, &kept, &OPEN).iter().sum();
    let best = together(channels, &ranked[winner].losses, &OPEN);
    let gain = before - best.iter().sum::<f64>();
    (0..ranked.len())
        .filter(|&k| k != winner)
        .filter(|&k| {
            let other = together(channels, &ranked[k].losses, &OPEN);
            let left = other.iter().sum::<f64>() - best.iter().sum::<f64>();
            let [_, low, ..] = bootstrap(&other, &best, 1, |a, b| a - b);
            left < TIE_SHARE * best.iter().sum::<f64>() || (low <= 0.0 && left < TIE_GAIN * gain)
        })
        .collect()
}

/// Drops causes that are no longer needed once the others are there.
fn eliminate(
    channels: &mut [ChannelData],
    stages: &mut Vec<ChannelStage>,
    causes: &mut Vec<Found>,
    fixed: bool,
) {
    let mut k = 0;
    while causes.len() > 1 && k < causes.len() {
        let effect = causes[k].effect;
        let models: Vec<Extended> =
            channels.iter().zip(stages.iter()).map(|(d, s)| s.model.without(&d.plant, effect)).collect();
        let reduced = settle(channels, &models, fixed);
        let losses = |channels: &[ChannelData], stages: &[ChannelStage]| {
            let all: Vec<Vec<f64>> = channels.iter().zip(stages).map(|(d, s)| s.losses(d)).collect();
            together(channels, &all, &OPEN)
        };
        let (with, without) = (losses(channels, stages), losses(channels, &reduced));
        let [low, ..] = bootstrap(&without, &with, 1, |a, b| 1.0 - (b / a).sqrt());
        let gain = 1.0 - (with.iter().sum::<f64>() / without.iter().sum::<f64>()).sqrt();
        if low <= 0.0 || gain < 0.5 * PRACTICAL {
            causes.remove(k);
            *stages = reduced;
        } else {
            k += 1;
        }
    }
    let models: Vec<Extended> = stages.iter().map(|s| s.model.clone()).collect();
    share_draws(channels, &models);
}
