//! The search: one cause at a time, everything refitted, until nothing passes.

mod another_first;
mod naming;
mod pairs_afresh;
mod taking_over;

pub use self::naming::harms;

use self::another_first::from_another_first;
use self::naming::{Named, Rules, name};
use super::acceptance::{is_large, kept_total, leaves_large};
use super::racing::Considered;
use super::restart::explained_afresh;
use super::selected::{Found, Withheld};
use super::settling::{fitted_by, settle_finely, staged};
use super::warm_start::lend_base;
use crate::diagnosis::channel::{ChannelData, Extended, share_draws};
use crate::diagnosis::estimation::{ChannelStage, fit_base, is_astray, models_of, refit_near};
use crate::diagnosis::evidence::Explanation;
use crate::diagnosis::screening::Asked;
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
    asked: Asked<'_>,
    progress: &Progress<'_>,
) -> Outcome {
    progress("fitting the base model", 0);
    let fixed = asked.question == Question::Change;
    let base = reference.unwrap_or_else(|| base_models(channels));
    share_draws(channels, &base);
    let mut stages = staged(channels, base.clone(), fixed);
    let mut first = stages.clone();
    let mut named = Named::default();
    let rules = Rules { asked, harmless: false, beating: None };
    name(channels, (&first, &mut stages), rules, &mut named, progress);
    // What takes up any error, like a spool that sticks, may have been named in place of what is
    // there, and everything would be taken back. Where it leaves little, it may be what is there.
    if let Some(left) = named.harmful {
        progress("trying the catalogue again without what makes the simulation worse", 0);
        (named.causes, named.withheld) = (Vec::new(), None);
        share_draws(channels, &base);
        if renew(channels, &mut first) {
            named.first_round = None;
        }
        let mut again = first.clone();
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
        renew(channels, &mut first);
        let fresh = explained_afresh(channels, &first, asked)
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
    if !fixed {
        from_another_first(channels, (&first, &mut stages), rules, &mut named, progress);
    }
    let Named { causes, rounds, explanations, withheld, .. } = named;
    Outcome { base, causes, stages, rounds, explanations, withheld, by_likelihood: false }
}

/// Evaluates stages again that were evaluated in coarser steps than the channels have now. Were
/// any?
fn renew(channels: &[ChannelData], stages: &mut [ChannelStage]) -> bool {
    let renewed = parallel::map(channels.iter().zip(stages), |(data, stage)| stage.renew(data));
    renewed.contains(&true)
}

/// Base models fitted to every channel.
fn base_models(channels: &mut [ChannelData]) -> Vec<Extended> {
    let alone = parallel::map(channels.iter(), fit_base);
    share_draws(channels, &alone);
    models_of(&lend_base(channels, staged(channels, alone, false)))
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
        // Of a model that lacks something the weights that go with it may lead further from the
        // pressure, and what is named would seem to gain more than it does.
        let again = |channels: &mut [ChannelData], models: &[Extended]| {
            fitted_by(channels, models, change, |data, whitening, model, free| {
                let fitted = refit_near(data, whitening, model, free);
                if is_astray(data, &fitted, model) { model.clone() } else { fitted }
            })
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
