//! Whether one effect stands out from the catalogue.

use crate::diagnosis::settings::SETTINGS;
use crate::order::descending;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::filter::innovations;
use super::posterior::log_likelihood;
use super::ranking::{Ranked, Ranking, rank};
use super::scoring::Estimate;
use super::starts::scales;
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, Role};
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::effects::Reach;
use crate::effects::catalogue::CATALOGUE;

/// Rows of a channel that are looked at, at most.
const MOST_ROWS: usize = 2400;
/// Where the catalogue has been tried on one channel, the others try what gained this part of the
/// best there.
const ELSEWHERE: f64 = 0.3;

/// What stands out.
#[derive(Debug, Clone)]
pub struct Named {
    /// Base models, which the likelihood has fitted.
    pub base: Vec<Extended>,
    /// The effect that explains most and what cannot be told from it; nothing where likelihood and
    /// simulation do not agree.
    pub effect: Option<NamedEffect>,
    /// Effects that gain enough on the blocks for fitting and something on those for selecting,
    /// likeliest first: number in the catalogue, models channel by channel.
    pub contenders: Vec<(usize, Vec<Extended>)>,
}

/// An effect with its models.
#[derive(Debug, Clone)]
pub struct NamedEffect {
    /// Number in the catalogue.
    pub effect: usize,
    /// Where it acts.
    pub acts: Vec<bool>,
    /// The models with it, and the base models where it does not act.
    pub models: Vec<Extended>,
    /// Standard errors of its parameters on their scales, channel by channel; empty where it does
    /// not act.
    pub errors: Vec<Vec<f64>>,
    /// Probability that an effect that is not there gains as much somewhere in the catalogue (S. S.
    /// Wilks, Ann. Math. Statist. 9, 1938).
    pub p_value: f64,
    /// Effects that explain as well, with their models and where they act.
    pub equivalent: Vec<(usize, Vec<Extended>, Vec<bool>)>,
}

/// One effect over all channels.
struct Contender {
    effect: usize,
    acts: Vec<bool>,
    models: Vec<Extended>,
    /// Gain of the logarithm of the density on the blocks for fitting, and of the likelihood on
    /// those for selecting.
    gain: f64,
    held_out: f64,
    /// RMS error of the simulation alone on both, kPa.
    error_kpa: f64,
}

/// Fits some effects of the catalogue to some thousand rows of every channel, and names the one
/// that is both the likeliest and the closest, if that is closer by far than the base models, its
/// own and the `known` ones.
#[must_use]
pub fn name(
    channels: &[ChannelData],
    known: &[Extended],
    effects: &[usize],
    progress: &(dyn Fn() + Sync),
) -> Option<Named> {
    let looked_at: Vec<ChannelData> = channels.iter().map(shortened).collect();
    let fit: Vec<Vec<bool>> = looked_at.iter().map(|data| rows_of(data, Role::Fit)).collect();
    let rankings = rankings(&looked_at, &fit, effects, progress)?;
    let base: Vec<Extended> = rankings.iter().map(|ranking| ranking.base.model.clone()).collect();
    let mut contenders: Vec<Contender> = effects
        .iter()
        .filter_map(|effect| contender(&looked_at, &rankings, *effect))
        .filter(|c| c.gain >= SETTINGS.greybox_least_nats && c.held_out > 0.0)
        .collect();
    descending(&mut contenders, |item| item.gain);
    let closest = contenders.iter().map(|c| c.error_kpa).fold(f64::INFINITY, f64::min);
    let errors = |models: &[Extended]| BlockErrors::of(channels, models, &[Role::Select]).all();
    let least_kpa = (1.0 - SETTINGS.greybox_worth) * errors(&base).min(errors(known));
    let stands_out = |c: &&Contender| {
        SETTINGS.greybox_as_likely * c.error_kpa <= closest && errors(&c.models) <= least_kpa
    };
    let effect = contenders.first().filter(stands_out).map(|winner| {
        let as_good = |c: &&Contender| {
            c.gain >= SETTINGS.greybox_as_likely * winner.gain
                && SETTINGS.greybox_as_likely * c.error_kpa <= winner.error_kpa
        };
        NamedEffect {
            effect: winner.effect,
            acts: winner.acts.clone(),
            models: winner.models.clone(),
            errors: rankings
                .iter()
                .zip(&winner.acts)
                .map(|(r, acts)| errors_of(r, winner.effect, *acts))
                .collect(),
            p_value: p_value(winner, contenders.len()),
            equivalent: contenders[1..]
                .iter()
                .filter(as_good)
                .map(|c| (c.effect, c.models.clone(), c.acts.clone()))
                .collect(),
        }
    });
    let contenders = contenders.into_iter().map(|c| (c.effect, c.models)).collect();
    Some(Named { base, effect, contenders })
}

/// The effects on the channel whose pressure moves most over its noise, and what gained most there
/// on the others.
fn rankings(
    channels: &[ChannelData],
    fit: &[Vec<bool>],
    effects: &[usize],
    progress: &(dyn Fn() + Sync),
) -> Option<Vec<Ranking>> {
    let scale = |data: &ChannelData| scales(data).discrepancy_pa / data.noise_kpa;
    let liveliest =
        (0..channels.len()).max_by(|&a, &b| scale(&channels[a]).total_cmp(&scale(&channels[b])))?;
    let first = rank(&channels[liveliest], &fit[liveliest], effects, progress)?;
    let gain = |ranked: &Ranked| ranked.estimate.log - first.base.log;
    let most = first.effects.iter().map(gain).fold(0.0, f64::max);
    let promising: Vec<usize> =
        first.effects.iter().filter(|r| gain(r) >= ELSEWHERE * most).map(|r| r.effect).collect();
    let ranked = channels.iter().zip(fit).enumerate().map(|(k, (data, rows))| {
        if k == liveliest { Some(first.clone()) } else { rank(data, rows, &promising, progress) }
    });
    ranked.collect()
}

fn p_value(winner: &Contender, tried: usize) -> f64 {
    let parameters = CATALOGUE[winner.effect].parameters.len() * winner.acts.iter().filter(|a| **a).count();
    let tail = ChiSquared::new(parameters as f64).map_or(1.0, |d| d.sf(2.0 * winner.gain));
    (tried as f64 * tail).min(1.0)
}

/// The first blocks of a channel.
fn shortened(data: &ChannelData) -> ChannelData {
    let mut short = data.clone();
    short.blocks.retain(|block| block.end <= MOST_ROWS);
    if short.blocks.is_empty() {
        return data.clone();
    }
    short.spans.truncate(short.blocks.len());
    short
}

/// Rows that are compared in blocks of a role.
fn rows_of(data: &ChannelData, role: Role) -> Vec<bool> {
    let mut rows = vec![false; data.inputs.rows()];
    for block in data.blocks.iter().filter(|block| block.role == role) {
        rows[block.compared..block.end].fill(true);
    }
    rows
}

fn of_effect(ranking: &Ranking, effect: usize) -> Option<&Ranked> {
    ranking.effects.iter().find(|ranked| ranked.effect == effect)
}

/// Standard errors of an effect's parameters, which are the last that are free.
fn errors_of(ranking: &Ranking, effect: usize, acts: bool) -> Vec<f64> {
    let found = of_effect(ranking, effect).filter(|_| acts);
    found.map_or(Vec::new(), |ranked| {
        let count = CATALOGUE[effect].parameters.len();
        let errors = &ranked.estimate.errors;
        errors[errors.len().saturating_sub(count)..].to_vec()
    })
}

fn contender(channels: &[ChannelData], rankings: &[Ranking], effect: usize) -> Option<Contender> {
    let found: Vec<Option<&Ranked>> = rankings.iter().map(|ranking| of_effect(ranking, effect)).collect();
    let gains: Vec<f64> = found
        .iter()
        .zip(rankings)
        .map(|(found, ranking)| found.map_or(0.0, |f| f.estimate.log - ranking.base.log))
        .collect();
    let most = gains.iter().copied().fold(0.0, f64::max);
    let shared = CATALOGUE[effect].reach == Reach::Rig;
    let acts: Vec<bool> = gains
        .iter()
        .zip(&found)
        .map(|(gain, found)| found.is_some() && (shared || *gain > SETTINGS.greybox_acts * most))
        .collect();
    if most <= 0.0 || !acts.contains(&true) {
        return None;
    }
    let chosen: Vec<&Estimate> = found
        .iter()
        .zip(rankings)
        .zip(&acts)
        .map(|((found, ranking), acts)| found.filter(|_| *acts).map_or(&ranking.base, |f| &f.estimate))
        .collect();
    let held_out = |data: &ChannelData, estimate: &Estimate| {
        let rows = rows_of(data, Role::Select);
        log_likelihood(&innovations(data, &estimate.model, &estimate.uncertainty, &rows))
    };
    let by_channel = channels.iter().zip(&chosen).zip(rankings);
    let models: Vec<Extended> = chosen.iter().map(|estimate| estimate.model.clone()).collect();
    Some(Contender {
        effect,
        gain: gains.iter().zip(&acts).filter(|(_, acts)| **acts).map(|(gain, _)| gain).sum(),
        held_out: by_channel.map(|((data, with), r)| held_out(data, with) - held_out(data, &r.base)).sum(),
        error_kpa: error_kpa(channels, &models),
        acts,
        models,
    })
}

/// RMS error of the simulation, from the inputs alone, over the blocks that may be looked at.
fn error_kpa(channels: &[ChannelData], models: &[Extended]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (data, model) in channels.iter().zip(models) {
        let residuals = data.residuals(model);
        for (_, span) in data.blocks.iter().zip(&data.spans).filter(|(block, _)| OPEN.contains(&block.role)) {
            sum += residuals[span.clone()].iter().map(|r| r * r).sum::<f64>();
            count += span.len() as f64;
        }
    }
    (sum / count.max(1.0)).sqrt()
}
