//! The search: one cause at a time, everything refitted, until nothing passes.

use super::racing::SETTLE;
use crate::diagnosis::settings::SETTINGS;

use super::acceptance::{forced, kept_total, large_in_loop, open_rows};
use super::racing::{Considered, is_foil, rivals, round};
use super::restart::explained_afresh;
use super::selected::{Found, Withheld};
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, halved, share_draws, simulate_finer};
use crate::diagnosis::estimation::{ChannelStage, fit_base, free_of, models_of, refit, refit_near};
use crate::diagnosis::evidence::Explanation;
use crate::diagnosis::likelihood::{Whitening, hunts, likelier, together};
use crate::diagnosis::resampling::bootstrap;
use crate::diagnosis::screening::{Gate, judge, trials};
use crate::effects::Question;
use crate::parallel;

/// Times that is done again at most, while what is left falls to less than this part of it.
const AGAIN: usize = 6;
/// See [`AGAIN`].
const SETTLED: f64 = 0.99;

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
    /// What was refitted on the way: explanations with their models.
    pub explanations: Vec<Explanation>,
    /// A name that was found and not given.
    pub withheld: Option<Withheld>,
    /// Has the likelihood fitted the models? Then they are not fitted again by weighted squares.
    pub by_likelihood: bool,
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
        None => parallel::map(channels.iter(), fit_base),
    };
    let fixed = question == Question::Change;
    share_draws(channels, &base);
    let mut stages: Vec<ChannelStage> = parallel::map(channels.iter().zip(&base), |(data, model)| {
        let free = if fixed { Vec::new() } else { free_of(data, model, false) };
        ChannelStage::new(data, model.clone(), free)
    });
    let first = stages.clone();
    let mut named = Named::default();
    name(channels, (&first, &mut stages), question, &mut named, progress);
    if named.withheld.is_none() && !fixed && large_in_loop(channels, &stages) {
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
                named.causes = vec![found];
                name(channels, (&first, &mut stages), question, &mut named, progress);
            }
            None => share_draws(channels, &models),
        }
    }
    let Named { causes, gates, first_gates, rounds, explanations, withheld } = named;
    Outcome { base, causes, stages, gates, first_gates, rounds, explanations, withheld, by_likelihood: false }
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
}

/// Names one cause after the other until nothing passes, and takes back what is not needed beside the others, or all of it when too
/// much of the error of the `first` stages is left.
fn name(
    channels: &mut [ChannelData],
    (first, stages): (&[ChannelStage], &mut Vec<ChannelStage>),
    question: Question,
    Named { causes, gates, first_gates, rounds, explanations, withheld }: &mut Named,
    progress: &Progress<'_>,
) {
    let fixed = question == Question::Change;
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
        let (winner, ranked) = round(channels, stages, &tried, gates, rounds);
        let named: Vec<usize> = causes.iter().map(|cause| cause.effect).collect();
        explanations.extend(ranked.iter().filter(|c| c.acts.contains(&true)).map(|c| c.explanation(&named)));
        let Some(winner) = winner else {
            break;
        };
        let equivalent = rivals(channels, stages, &ranked, winner);
        if let Some(&foil) = equivalent.iter().find(|&&k| is_foil(&ranked[k])) {
            *withheld = Some(Withheld { effect: ranked[winner].effect, foil: ranked[foil].clone() });
            break;
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
    }
    eliminate(channels, first, stages, causes, fixed);
    // A rival that turned out to be needed as well is no rival.
    let named: Vec<usize> = causes.iter().map(|c| c.effect).collect();
    for cause in causes.iter_mut() {
        cause.equivalent.retain(|e| !named.contains(e));
        cause.rivals.retain(|r| !named.contains(&r.effect));
    }
    if !causes.is_empty() && forced(channels, first, stages, &named) {
        causes.clear();
        *stages = first.to_vec();
        share_draws(channels, &models_of(first));
    }
}

/// As [`settle`]. A model may be stiffer than the one before: what its step leaves must not be named next.
fn settle_finely(channels: &mut [ChannelData], models: &[Extended], fixed: bool) -> Vec<ChannelStage> {
    let mut stages = settle(channels, models, fixed);
    while halving(channels, &stages) > SETTINGS.step_error && simulate_finer(channels) {
        let models = models_of(&stages);
        stages = settle(channels, &models, fixed);
    }
    stages
}

/// Mean squared change of the whitened residuals when the integration step is halved, in variances of the noise.
fn halving(channels: &[ChannelData], stages: &[ChannelStage]) -> f64 {
    let change = |(data, stage): (&ChannelData, &ChannelStage)| -> f64 {
        let mut difference = halved(data).readings(&stage.model);
        difference.iter_mut().zip(&stage.readings).for_each(|(a, b)| *a = (*a - b) / data.noise_kpa);
        stage.whitening.apply(&mut difference);
        let open = data.blocks.iter().zip(&data.spans).filter(|(b, _)| OPEN.contains(&b.role));
        open.flat_map(|(_, span)| &difference[span.clone()]).map(|d| d * d).sum()
    };
    parallel::map(channels.iter().zip(stages), change).iter().sum::<f64>() / open_rows(channels).max(1.0)
}

/// Refits models with the weights that go with them, again with those of where that ends, until it brings no more.
fn settle(channels: &mut [ChannelData], models: &[Extended], fixed: bool) -> Vec<ChannelStage> {
    let settled = |channels: &mut [ChannelData], models: &[Extended]| {
        let fitted = fitted_by(channels, models, fixed, |data, whitening, model, free| {
            refit(data, whitening, model, free, SETTLE).0
        });
        staged(channels, fitted, fixed)
    };
    let mut stages = settled(channels, models);
    let times = if channels.iter().all(|data| data.inputs.spool_is_recorded()) { AGAIN } else { 0 };
    for _ in 0..times {
        let further = settled(channels, &models_of(&stages));
        let (before, after) = (kept_total(channels, &stages), kept_total(channels, &further));
        if after < before {
            stages = further;
        }
        if after >= SETTLED * before {
            break;
        }
    }
    stages
}

/// Where models stand, each with the weights that go with it.
pub fn staged(channels: &[ChannelData], models: Vec<Extended>, fixed: bool) -> Vec<ChannelStage> {
    parallel::map(channels.iter().zip(models), |(data, model)| {
        let free = free_of(data, &model, fixed);
        ChannelStage::new(data, model, free)
    })
}

/// Refits models with the weights of where they start.
fn fitted_by(
    channels: &mut [ChannelData],
    models: &[Extended],
    fixed: bool,
    fit: impl Fn(&ChannelData, &Whitening, &Extended, &[usize]) -> Extended + Sync,
) -> Vec<Extended> {
    share_draws(channels, models);
    parallel::map(channels.iter().zip(models), |(data, model)| {
        let free = free_of(data, model, fixed);
        let whitening = Whitening::new(data, &data.disturbances(model));
        let fitted = fit(data, &whitening, model, &free);
        if hunts(data, &fitted) { likelier(data, &whitening, [model.clone(), fitted]).1 } else { fitted }
    })
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

/// Drops causes that are no longer needed once the others are there, and sees what each that stays adds to the others: whatever was
/// added first would otherwise have what several describe in part.
fn eliminate(
    channels: &mut [ChannelData],
    first: &[ChannelStage],
    stages: &mut Vec<ChannelStage>,
    causes: &mut Vec<Found>,
    fixed: bool,
) {
    while let Some((needless, reduced)) = without_each(channels, first, stages, causes, fixed) {
        causes.remove(needless);
        *stages = reduced;
    }
    share_draws(channels, &models_of(stages));
}

/// Refits the models without each cause in turn, and notes what it adds. Ends with the first that is not needed, and the stages without it.
fn without_each(
    channels: &mut [ChannelData],
    first: &[ChannelStage],
    stages: &[ChannelStage],
    causes: &mut [Found],
    fixed: bool,
) -> Option<(usize, Vec<ChannelStage>)> {
    if let [only] = causes {
        only.adds(channels, first, stages);
        return None;
    }
    for (k, cause) in causes.iter_mut().enumerate() {
        let without = channels.iter().zip(stages).map(|(d, s)| s.model.without(&d.plant, cause.effect));
        let models: Vec<Extended> = without.collect();
        let reduced = settle(channels, &models, fixed);
        if !is_needed(channels, stages, &reduced) {
            return Some((k, reduced));
        }
        cause.adds(channels, &reduced, stages);
    }
    None
}

/// Is the error with all causes clearly smaller, and by enough, than that with one less?
fn is_needed(channels: &[ChannelData], stages: &[ChannelStage], reduced: &[ChannelStage]) -> bool {
    let losses = |stages: &[ChannelStage]| together(channels, stages.iter().map(|s| &s.losses), &OPEN);
    let (with, without) = (losses(stages), losses(reduced));
    let [low, ..] = bootstrap(&without, &with, 1, |a, b| 1.0 - (b / a).sqrt());
    let gain = 1.0 - (with.iter().sum::<f64>() / without.iter().sum::<f64>()).sqrt();
    low > 0.0 && gain >= 0.5 * SETTINGS.practical
}

#[cfg(test)]
mod tests;
