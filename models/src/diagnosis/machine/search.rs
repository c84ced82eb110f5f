//! The search: the catalogue, and beside the best of it the catalogue again.

use super::candidates::{Candidate, possible, with_effect, with_something_else};
use super::held_out::HeldOut;
use super::recordings::MachineChannel;
use super::sizes::Sizes;
use super::ties::TiedModel;
use crate::diagnosis::channel::Extended;
use crate::diagnosis::evidence::{Evidence, Missing, probabilities};
use crate::diagnosis::json::Gain;
use crate::diagnosis::screening::Asked;
use crate::diagnosis::selection::Progress;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::order::descending;

/// Causes that are looked for at most: the second is found beside the first.
const MOST_CAUSES: usize = 2;

/// A cause with what it is worth.
#[derive(Debug, Clone)]
pub struct NamedCause {
    /// Number in the catalogue.
    pub effect: usize,
    /// Where it acts.
    pub acts: Vec<bool>,
    /// Effects that explain as well.
    pub equivalent: Vec<usize>,
    /// What it gains on the held-out parts over the model without it.
    pub gain: Gain,
    /// Probability of all sets of causes with it.
    pub probability: f64,
}

/// What was found.
#[derive(Debug)]
pub struct Findings {
    /// All explanations, the likeliest first.
    pub candidates: Vec<(Candidate, f64)>,
    /// The base model.
    pub base: Candidate,
    /// What is named.
    pub causes: Vec<NamedCause>,
    /// Final models with the sizes of their effects, channel by channel.
    pub sizes: Vec<Sizes>,
    /// Errors of the base models and of the final ones on recordings that were left out.
    pub held_out: [HeldOut; 2],
    /// Is the machine known?
    pub known: bool,
}

impl Findings {
    /// The explanation that is named: the base model where nothing is.
    pub fn last(&self) -> &Candidate {
        let named: Vec<usize> = self.causes.iter().map(|cause| cause.effect).collect();
        let all = self.candidates.iter().map(|(candidate, _)| candidate);
        let mut fitting = all.filter(|c| c.missing == Missing::Effects(named.clone()));
        fitting.next().unwrap_or(&self.base)
    }
}

/// Tries the catalogue, and beside the best of it the catalogue again.
#[must_use]
pub fn find(
    channels: &[MachineChannel],
    base: Vec<TiedModel>,
    known: Option<&[Extended]>,
    asked: Asked<'_>,
    progress: &Progress<'_>,
) -> Findings {
    let tick = || progress("", 1);
    let known_of = |k: usize| known.map(|models| &models[k].effects[..]);
    let possible = possible(channels, asked);
    let base = Candidate::new(channels, Missing::Nothing, base);
    let mut candidates = vec![base.clone()];
    let mut best = base.clone();
    let mut causes: Vec<NamedCause> = Vec::new();
    let worth = |models: &[TiedModel]| {
        let of = |(k, (channel, models)): (usize, (&MachineChannel, &TiedModel))| {
            HeldOut::of(channel, models, known_of(k), &tick)
        };
        channels.iter().zip(models).enumerate().map(of).collect::<Vec<HeldOut>>()
    };
    let mut held_out = worth(&base.models);
    let before = HeldOut::together(&held_out);
    for round in 0..MOST_CAUSES {
        progress(["trying the catalogue", "trying it beside the first cause"][round.min(1)], 0);
        let taken = best.missing.effects().to_vec();
        let untried = possible.iter().filter(|e| !taken.contains(e));
        let mut tried: Vec<Candidate> =
            untried.filter_map(|&e| with_effect(channels, &best, e, known, &tick)).collect();
        descending(&mut tried, |item| item.evidence.log_density());
        let something_else = with_something_else(channels, &best, known, &tick);
        let winner = tried.first().cloned();
        let rivals: Vec<usize> = tried
            .iter()
            .skip(1)
            .filter(|c| winner.as_ref().is_some_and(|w| ties(w, c)))
            .filter_map(|c| c.missing.effects().last().copied())
            .collect();
        let smooth = something_else.evidence.clone();
        candidates.extend(tried);
        candidates.push(something_else);
        let Some(winner) = winner.filter(|w| stands_out(w, &best.evidence, &smooth)) else { break };
        // Of a known machine only the load can be missing: what moved in the machine is another
        // question.
        if known.is_some() && !is_of_load(&winner) {
            break;
        }
        let errors = worth(&winner.models);
        let gain = HeldOut::together(&held_out).gain(&HeldOut::together(&errors));
        // A second name beside the first has to be one alone: what several could be is "something
        // else".
        let alone = round == 0 || rivals.is_empty();
        if !(gain.ci95[0] > SETTINGS.practical && gain.reduction >= SETTINGS.greybox_worth && alone) {
            break;
        }
        let acts = winner.models.iter().zip(&best.models).map(|(a, b)| a != b).collect();
        let effect = winner.missing.effects().last().copied().unwrap_or_default();
        causes.push(NamedCause { effect, acts, equivalent: rivals, gain, probability: 0.0 });
        (best, held_out) = (winner, errors);
    }
    let evidences: Vec<&Evidence> = candidates.iter().map(|c| &c.evidence).collect();
    let probable = probabilities(&evidences);
    for cause in &mut causes {
        let with =
            candidates.iter().zip(&probable).filter(|(c, _)| c.missing.effects().contains(&cause.effect));
        cause.probability = with.map(|(_, p)| p).sum();
    }
    let mut candidates: Vec<(Candidate, f64)> = candidates.into_iter().zip(probable).collect();
    descending(&mut candidates, |(candidate, _)| candidate.evidence.log_density());
    descending(&mut candidates, |(_, probability)| *probability);
    progress("measuring sizes", 0);
    let size = |(k, channel): (usize, &MachineChannel)| {
        Sizes::of(channel, &best.models[k], known_of(k), &held_out[k])
    };
    let sizes = channels.iter().enumerate().map(size).collect();
    let after = HeldOut::together(&held_out);
    Findings { candidates, base, causes, sizes, held_out: [before, after], known: known.is_some() }
}

/// Is the effect that was found last one of the load's?
fn is_of_load(candidate: &Candidate) -> bool {
    let effect = candidate.missing.effects().last();
    effect.is_some_and(|&e| CATALOGUE[e].parameters.iter().any(|p| p.of_load))
}

/// Can the recordings not tell a rival from the winner? They cannot where its density is as high
/// within what units differ by, or where it simulates as closely and is nearly as likely.
fn ties(winner: &Candidate, rival: &Candidate) -> bool {
    let (gain, error) = winner.evidence.over(&rival.evidence);
    let close = SETTINGS.greybox_as_likely * rival.evidence.rmse_kpa() <= winner.evidence.rmse_kpa();
    close && gain <= 2.0 * error
}

/// Is an effect likelier than the model without it, beyond what units differ by, and than something
/// smooth without a name?
fn stands_out(winner: &Candidate, before: &Evidence, smooth: &Evidence) -> bool {
    let (gain, error) = winner.evidence.over(before);
    gain >= SETTINGS.greybox_least_nats
        && gain > 2.0 * error
        && winner.evidence.log_density() > smooth.log_density()
}
