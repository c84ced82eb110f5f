//! The search: one cause at a time, everything refitted, until nothing passes.

use super::acceptance::{a_trace_beside, forced, is_large, is_shown, kept_total, leaves_large, leaves_much};
use super::elimination::eliminate;
use super::racing::{Considered, Entrants, Raced, is_foil, is_of_the_rig_file, rivals, round};
use super::restart::explained_afresh;
use super::selected::{Found, Withheld};
use super::settling::{fitted_by, settle_finely, staged};
use super::warm_start::lend_base;
use crate::diagnosis::channel::{ChannelData, Extended, Role, share_draws};
use crate::diagnosis::estimation::{ChannelStage, fit_base, models_of, refit_near};
use crate::diagnosis::evidence::Explanation;
use crate::diagnosis::likelihood::hunts;
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::screening::{Gate, judge, trials};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::Question;
use crate::parallel;

/// Where the search ended.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Base models.
    pub base: Vec<Extended>,
    /// Causes in the order in which they were named.
    pub causes: Vec<Found>,
    /// Final stages.
    pub stages: Vec<ChannelStage>,
    /// What the gate says after the last cause.
    pub gates: Vec<Gate>,
    /// What the gate said at first.
    pub first_gates: Vec<Gate>,
    /// What was considered in every round.
    pub rounds: Vec<Vec<Considered>>,
    /// What was refitted on the way: explanations with their models.
    pub explanations: Vec<Explanation>,
    /// A name that was found and not given.
    pub withheld: Option<Withheld>,
    /// Has the likelihood fitted the models? Then they are not fitted again by weighted squares.
    pub by_likelihood: bool,
}

/// What the search tells while it runs.
pub type Progress<'a> = dyn Fn(&str, u64) + Sync + 'a;

/// Runs the search. `reference` are calibrated models, whose parameters are then kept (question of
/// change).
#[must_use]
pub fn search(
    channels: &mut [ChannelData],
    reference: Option<Vec<Extended>>,
    progress: &Progress<'_>,
) -> Outcome {
    let question = if reference.is_some() { Question::Change } else { Question::Structure };
    progress("fitting the base model", 0);
    let fixed = question == Question::Change;
    let base = reference.unwrap_or_else(|| base_models(channels));
    share_draws(channels, &base);
    let mut stages = staged(channels, base.clone(), fixed);
    let first = stages.clone();
    let mut named = Named::default();
    let rules = Rules { question, harmless: false };
    name(channels, (&first, &mut stages), rules, &mut named, progress);
    // What takes up any error, like a spool that sticks, may have been named in place of what is
    // there, and everything would be taken back. Where it leaves little, it may be what is there.
    if let Some(left) = named.harmful {
        progress("trying the catalogue again without what makes the simulation worse", 0);
        let mut again = first.clone();
        (named.causes, named.withheld) = (Vec::new(), None);
        share_draws(channels, &base);
        name(channels, (&first, &mut again), Rules { harmless: true, ..rules }, &mut named, progress);
        // What explains less only has a part of what harms and may be there.
        if kept_total(channels, &again) < left {
            stages = again;
        } else {
            (stages, named.causes) = (first.clone(), Vec::new());
            share_draws(channels, &base);
        }
    }
    // Of a name that was not given the question is only what it was, if it explains the error at
    // all.
    let withheld = named.withheld.as_ref().is_some_and(|w| !leaves_large(channels, &w.foil));
    if !withheld && !fixed && is_large(channels, &stages) {
        progress("trying the catalogue afresh", 0);
        let (left, models) = (kept_total(channels, &stages), models_of(&stages));
        share_draws(channels, &base);
        let fresh = explained_afresh(channels, &first)
            .map(|(models, found)| (settle_finely(channels, &models, fixed), found))
            .filter(|(fresh, _)| {
                named.causes.is_empty() || kept_total(channels, fresh) < SETTINGS.restarted * left
            });
        match fresh {
            Some((fresh, found)) => {
                stages = fresh;
                (named.causes, named.withheld) = (vec![found], None);
                name(channels, (&first, &mut stages), rules, &mut named, progress);
            }
            None => share_draws(channels, &models),
        }
    }
    let Named { causes, gates, first_gates, rounds, explanations, withheld, .. } = named;
    Outcome { base, causes, stages, gates, first_gates, rounds, explanations, withheld, by_likelihood: false }
}

/// Base models fitted to every channel.
fn base_models(channels: &mut [ChannelData]) -> Vec<Extended> {
    let alone = parallel::map(channels.iter(), fit_base);
    share_draws(channels, &alone);
    models_of(&lend_base(channels, staged(channels, alone, false)))
}

/// What the rounds of a search find.
#[derive(Default)]
struct Named {
    causes: Vec<Found>,
    gates: Vec<Gate>,
    first_gates: Vec<Gate>,
    rounds: Vec<Vec<Considered>>,
    explanations: Vec<Explanation>,
    withheld: Option<Withheld>,
    /// Squared whitened error on the open blocks that all names together left, before any was taken
    /// back, where they made rollouts worse and that is much.
    harmful: Option<f64>,
}

/// What may be named.
#[derive(Clone, Copy)]
struct Rules {
    question: Question,
    /// Nothing with which rollouts on the choosing blocks are worse than without any name?
    harmless: bool,
}

/// Names one cause after the other until nothing passes, and takes back what is not needed beside
/// the others, or all of it when too much of the error of the `first` stages is left.
fn name(
    channels: &mut [ChannelData],
    (first, stages): (&[ChannelStage], &mut Vec<ChannelStage>),
    Rules { question, harmless }: Rules,
    Named { causes, gates, first_gates, rounds, explanations, withheld, harmful }: &mut Named,
    progress: &Progress<'_>,
) {
    let fixed = question == Question::Change;
    let mut base_kpa = choosing_kpa(channels, &models_of(first));
    loop {
        progress("trying the catalogue", causes.len() as u64);
        let tried = trials(channels, stages, question, &|| progress("", 1));
        *gates = judge(&tried);
        if first_gates.is_empty() {
            first_gates.clone_from(gates);
        }
        if causes.len() >= usize::from(SETTINGS.most_causes) {
            break;
        }
        progress("refitting what passed", causes.len() as u64);
        let harms = |models: &[Extended]| harmless && goes_astray(channels, models, base_kpa);
        let mut raced = round(channels, stages, &tried, (gates, Entrants::Passed), rounds, harms);
        // Where the drive is recorded, a model that is far off is the likelihood's matter.
        let looped = channels.iter().all(|data| data.inputs.in_loop());
        if looped && raced.winner.is_none() && !causes.is_empty() && is_large(channels, stages) {
            progress("refitting the whole catalogue", causes.len() as u64);
            raced = round(channels, stages, &tried, (gates, Entrants::Everything), rounds, harms);
        }
        let Raced { ranked, winner, harmful: refused } = raced;
        let named: Vec<usize> = causes.iter().map(|cause| cause.effect).collect();
        // Beside another supply everything explains more: what is not named there is none.
        if withheld.is_none() {
            let acting = ranked.iter().chain(&refused).filter(|c| c.acts.contains(&true));
            explanations.extend(acting.map(|c| c.explanation(&named)));
        }
        let Some(winner) = winner else {
            break;
        };
        if !causes.is_empty() && a_trace_beside(channels, stages, &ranked[winner]) {
            break;
        }
        let equivalent = rivals(channels, stages, &ranked, winner);
        if let Some(&foil) = equivalent.iter().find(|&&k| is_foil(&ranked[k])) {
            let name = Withheld { effect: ranked[winner].effect, foil: ranked[foil].clone() };
            if withheld.is_some() || !is_of_the_rig_file(&ranked[foil]) {
                withheld.get_or_insert(name);
                break;
            }
            *withheld = Some(name);
            // Whatever it is, this part of the error is accounted for: the search goes on with the
            // supply that the recording speaks for.
            *stages = settle_finely(channels, &ranked[foil].models, fixed);
            continue;
        }
        let gate = gates.iter().find(|g| g.effect == ranked[winner].effect);
        causes.push(Found::new(
            channels,
            stages,
            &ranked,
            winner,
            &equivalent,
            gate.map_or(1.0, |g| g.p_value),
        ));
        *stages = settle_finely(channels, &ranked[winner].models, fixed);
        if is_shown(channels, ranked[winner].effect) {
            // It is there, whatever rollouts say: what comes beside it need not make up for it.
            base_kpa = choosing_kpa(channels, &models_of(stages));
        }
    }
    eliminate(channels, first, stages, causes, fixed);
    // A rival that turned out to be needed as well is no rival.
    let named: Vec<usize> = causes.iter().map(|c| c.effect).collect();
    for cause in causes.iter_mut() {
        cause.equivalent.retain(|e| !named.contains(e));
        cause.rivals.retain(|r| !named.contains(&r.effect));
    }
    let found = causes.iter().any(|c| !is_shown(channels, c.effect));
    let harmed = found && harms(channels, first, stages);
    *harmful = harmed.then(|| kept_total(channels, stages));
    if !causes.is_empty() && forced(channels, first, stages, &named) {
        keep_shown(channels, (first, stages), causes, fixed);
    }
    if causes.is_empty() {
        *stages = first.to_vec();
        share_draws(channels, &models_of(first));
    }
}

/// Do names that leave much make rollouts worse than the `first` stages do, counted in plain
/// kilopascals? The search weighs errors by what noise and wander explain; where the model is wrong
/// altogether, that can be won while the pressure is lost. Where little is left it is not: then the
/// pressure says only how the supply happened to wander.
#[must_use]
pub fn harms(channels: &[ChannelData], first: &[ChannelStage], last: &[ChannelStage]) -> bool {
    leaves_much(channels, last)
        && goes_astray(channels, &models_of(last), choosing_kpa(channels, &models_of(first)))
}

/// Do rollouts leave `base_kpa` or more? Of a loop that hunts they do not tell: none is in step
/// with the recording, and one that does not hunt at all is as close. There the likelihood judges
/// alone.
fn goes_astray(channels: &[ChannelData], models: &[Extended], base_kpa: f64) -> bool {
    let hunting = channels.iter().zip(models).any(|(data, model)| hunts(data, model));
    !hunting && choosing_kpa(channels, models) >= base_kpa
}

/// RMS error of rollouts on the choosing blocks, kPa.
fn choosing_kpa(channels: &[ChannelData], models: &[Extended]) -> f64 {
    BlockErrors::of(channels, models, Role::Select).all()
}

/// Takes all names back but those which the recording shows by itself.
fn keep_shown(
    channels: &mut [ChannelData],
    (first, stages): (&[ChannelStage], &mut Vec<ChannelStage>),
    causes: &mut Vec<Found>,
    fixed: bool,
) {
    let (shown, others): (Vec<Found>, Vec<Found>) =
        std::mem::take(causes).into_iter().partition(|cause| is_shown(channels, cause.effect));
    *causes = shown;
    if causes.is_empty() || others.is_empty() {
        return;
    }
    let without = |(data, stage): (&ChannelData, &ChannelStage)| {
        others.iter().fold(stage.model.clone(), |model, cause| model.without(&data.plant, cause.effect))
    };
    let models: Vec<Extended> = channels.iter().zip(stages.iter()).map(without).collect();
    *stages = settle_finely(channels, &models, fixed);
    causes.iter_mut().for_each(|cause| cause.adds(channels, first, stages));
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
        if self.by_likelihood {
            self.stages = staged(channels, models_of(&self.stages), change);
            return;
        }
        let again = |channels: &mut [ChannelData], models: &[Extended]| {
            fitted_by(channels, models, change, refit_near)
        };
        let coarse = self.base.clone();
        if !change {
            self.base = again(channels, &coarse);
        }
        for cause in &mut self.causes {
            cause.without =
                if cause.without == coarse { self.base.clone() } else { again(channels, &cause.without) };
        }
        let last = if self.causes.is_empty() && !change {
            self.base.clone()
        } else {
            again(channels, &models_of(&self.stages))
        };
        self.stages = staged(channels, last, change);
    }
}

#[cfg(test)]
mod tests;
