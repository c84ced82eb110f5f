//! Explanations of what a machine's base model lacks: nothing, something smooth without a name,
//! single effects, pairs.

use super::evidence::evidence_of;
use super::fit::{cost, effect_starts, race, refit};
use super::recordings::MachineChannel;
use super::ties::{Freedom, TiedModel};
use crate::diagnosis::channel::{Correction, Extended, HATS, Role, Variable};
use crate::diagnosis::discrepancy::knots;
use crate::diagnosis::evidence::{Evidence, Missing};
use crate::diagnosis::screening::Asked;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::Domain;
use crate::effects::catalogue::CATALOGUE;

/// Evaluations in which a correction along one variable is looked at, and in which the best is
/// fitted.
const CORRECTION: (usize, usize) = (5, 15);

/// An explanation, fitted.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// What it holds to be missing.
    pub missing: Missing,
    /// Models of every channel.
    pub models: Vec<TiedModel>,
    /// What they are worth, channel by channel.
    pub by_channel: Vec<Evidence>,
    /// What they are worth together.
    pub evidence: Evidence,
}

impl Candidate {
    /// From fitted models.
    #[must_use]
    pub fn new(channels: &[MachineChannel], missing: Missing, models: Vec<TiedModel>) -> Self {
        let by_channel: Vec<Evidence> =
            channels.iter().zip(&models).map(|(channel, models)| evidence_of(channel, models)).collect();
        let evidence = Evidence::together(&by_channel);
        Self { missing, models, by_channel, evidence }
    }

    /// Takes over `before` on channels where this gains next to nothing of what it gains elsewhere:
    /// there it does not act.
    #[must_use]
    fn where_it_acts(mut self, before: &Self) -> Self {
        let gain = |k: usize| self.by_channel[k].log_density() - before.by_channel[k].log_density();
        let gains: Vec<f64> = (0..self.models.len()).map(gain).collect();
        let most = gains.iter().copied().fold(0.0, f64::max);
        for (k, gain) in gains.into_iter().enumerate() {
            if gain < SETTINGS.greybox_acts * most {
                self.models[k] = before.models[k].clone();
                self.by_channel[k] = before.by_channel[k].clone();
            }
        }
        self.evidence = Evidence::together(&self.by_channel);
        self
    }
}

/// Effects of the catalogue that may be missing on all channels of a machine.
#[must_use]
pub fn possible(channels: &[MachineChannel], asked: Asked<'_>) -> Vec<usize> {
    let recorded = || channels.iter().flat_map(|channel| &channel.recorded);
    let may = |&e: &usize| {
        let info = CATALOGUE[e];
        asked.is_among(e)
            && info.question == asked.question
            && info.domain != Domain::Regulator
            && !info.probes.is_empty()
            && recorded().all(|data| info.is_known(&data.inputs))
    };
    (0..CATALOGUE.len()).filter(may).collect()
}

/// `before` with one more effect. Nothing where no simulation with it runs.
#[must_use]
pub fn with_effect(
    channels: &[MachineChannel],
    before: &Candidate,
    effect: usize,
    known: Option<&[Extended]>,
    tick: &(dyn Fn() + Sync),
) -> Option<Candidate> {
    let fitted = |(k, channel): (usize, &MachineChannel)| {
        let known = known.map(|models| &models[k]);
        let groups = effect_starts(channel, &before.models[k], effect, known);
        race(channel, &groups, known.map(|model| &model.effects[..]), tick)
    };
    let models: Option<Vec<TiedModel>> = channels.iter().enumerate().map(fitted).collect();
    let mut effects = before.missing.effects().to_vec();
    effects.push(effect);
    Some(Candidate::new(channels, Missing::Effects(effects), models?).where_it_acts(before))
}

/// `before` with a smooth term in the rate of pressure along the variable that makes most of it.
#[must_use]
pub fn with_something_else(
    channels: &[MachineChannel],
    before: &Candidate,
    known: Option<&[Extended]>,
    tick: &(dyn Fn() + Sync),
) -> Candidate {
    let fitted = |(k, channel): (usize, &MachineChannel)| {
        let known = known.map(|models| &models[k].effects[..]);
        let freedom = known.map_or(Freedom::Machine, Freedom::Known);
        let along = |&variable: &Variable| {
            tick();
            let start = corrected(channel, &before.models[k], variable)?;
            let fitted = refit(channel, &start, freedom, &[Role::Fit], CORRECTION.0).models;
            Some((cost(channel, &fitted), fitted))
        };
        let best = Variable::ALL.iter().filter_map(along).min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(
            || before.models[k].clone(),
            |(_, start)| refit(channel, &start, freedom, &[Role::Fit], CORRECTION.1).models,
        )
    };
    let models = channels.iter().enumerate().map(fitted).collect();
    let missing = Missing::SomethingElse(before.missing.effects().to_vec());
    Candidate::new(channels, missing, models)
}

/// Models with a correction along a variable that is nothing yet.
fn corrected(channel: &MachineChannel, models: &TiedModel, variable: Variable) -> Option<TiedModel> {
    let mut values = Vec::new();
    for (data, model) in channel.recorded.iter().zip(&models.models) {
        values.extend_from_slice(&data.series(&data.trace(model), variable)?);
    }
    let knots = knots(&values);
    let correction = Correction { variable, knots, heights: vec![0.0; HATS] };
    if !correction.is_usable() {
        return None;
    }
    Some(models.each(|model| Extended { correction: Some(correction.clone()), ..model.clone() }))
}
