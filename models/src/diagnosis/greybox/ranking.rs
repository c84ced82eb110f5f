//! Every effect of the catalogue fitted in earnest on a channel, by the posterior density.

use super::filter::innovations;
use super::posterior::{Posterior, log_likelihood};
use super::scoring::Estimate;
use super::starts::{Expectation, base_starts, begin, effect_starts, posterior, scales};
use super::uncertainty::Uncertainty;
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::estimation::gain_of;
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{Domain, Question};
use crate::order::descending;
use crate::parallel;

/// Starts that are followed for some rounds, of those of a base model and of an effect ...
const LOOKED_AT: [usize; 2] = [4, 8];
/// ... the part of them that is followed for some more ...
const PROMISING: usize = 3;
/// ... and the best of those, which are followed to the end.
const FOLLOWED: [usize; 2] = [3, 2];
/// Rounds of a look, of a second look, of the way to the end with a supply that is taken as it is,
/// and of the rest of it.
const ROUNDS: [usize; 4] = [3, 5, 20, 30];
/// Deviations of a base model at which its starts are tried, over those at which they begin: one
/// that forgives and one that does not.
const TRIED: [f64; 2] = [0.1, 1.0];

/// A model with one effect on one channel.
#[derive(Debug, Clone)]
pub struct Ranked {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// Where its climb ended.
    pub estimate: Estimate,
}

/// The catalogue on one channel.
#[derive(Debug, Clone)]
pub struct Ranking {
    /// The base model alone.
    pub base: Estimate,
    /// With each of the effects; without those whose simulation runs away.
    pub effects: Vec<Ranked>,
}

/// Fits the base model, and each of some effects that may act here, to the counted rows of a
/// channel; `done` is called after each.
#[must_use]
pub fn rank(
    data: &ChannelData,
    counted: &[bool],
    effects: &[usize],
    done: &(dyn Fn() + Sync),
) -> Option<Ranking> {
    let mut expectation = Expectation { gain: 1.0, scales: scales(data) };
    let start = begin(&expectation.scales);
    let tried = best_first(data, base_starts(data), &start, counted);
    let first = tried.first()?.clone();
    if let Some(gain) = gain_of(data, &first) {
        expectation.gain = gain;
    }
    let starts: Vec<(Extended, Uncertainty)> = tried
        .into_iter()
        .take(LOOKED_AT[0])
        .flat_map(|model| TRIED.map(|factor| (model.clone(), narrowed(&start, factor))))
        .collect();
    let base = race(&mut posterior(data, first, &expectation, counted), &starts, FOLLOWED[0])?;
    done();
    let acting = effects.iter().copied().filter(|&effect| may_act(data, effect));
    let fitted = parallel::map(acting, |effect| {
        let models = effect_starts(data, &base.model, effect);
        let tried = best_first(data, models, &base.uncertainty, counted);
        let mut of_effect = posterior(data, tried.first()?.clone(), &expectation, counted);
        let starts: Vec<(Extended, Uncertainty)> = tried
            .into_iter()
            .take(LOOKED_AT[1])
            .flat_map(|model| [(model.clone(), base.uncertainty), (model, start)])
            .collect();
        let estimate = race(&mut of_effect, &starts, FOLLOWED[1]);
        done();
        Some(Ranked { effect, estimate: estimate? })
    });
    let effects = fitted.into_iter().flatten().collect();
    Some(Ranking { base, effects })
}

/// A structure that the catalogue has sizes for, on a channel of this kind.
fn may_act(data: &ChannelData, effect: usize) -> bool {
    let info = CATALOGUE[effect];
    let domain = if data.plant.model.is_regulator() { Domain::Regulator } else { Domain::Valve };
    info.question == Question::Structure
        && (info.domain == domain || info.domain == Domain::Both)
        && !info.probes.is_empty()
}

fn narrowed(uncertainty: &Uncertainty, factor: f64) -> Uncertainty {
    Uncertainty { discrepancy_pa: factor * uncertainty.discrepancy_pa, ..*uncertainty }
}

/// Models by their likelihood as they stand; those whose simulation runs away are left out.
fn best_first(
    data: &ChannelData,
    models: Vec<Extended>,
    uncertainty: &Uncertainty,
    counted: &[bool],
) -> Vec<Extended> {
    let likelihood = |model: &Extended| log_likelihood(&innovations(data, model, uncertainty, counted));
    let mut tried = parallel::map(models, |model| (likelihood(&model), model));
    tried.retain(|(log, _)| log.is_finite());
    descending(&mut tried, |item| item.0);
    tried.into_iter().map(|(_, model)| model).collect()
}

/// Climbs from all starts for some rounds, from those that promise most for some more (successive
/// halving; K. Jamieson and A. Talwalkar, AISTATS 2016) and from the best to the end. The supply is
/// let wander only at the end: before, it would lead a model astray that is not yet near the
/// recording.
fn race(
    posterior: &mut Posterior<'_>,
    starts: &[(Extended, Uncertainty)],
    follow: usize,
) -> Option<Estimate> {
    posterior.stiff = true;
    let stiff = &*posterior;
    let on = |look: &Estimate, rounds: usize| stiff.climb(&look.model, &look.uncertainty, rounds);
    let looks = parallel::map(starts, |(model, uncertainty)| stiff.climb(model, uncertainty, ROUNDS[0]));
    let looks = highest_first(looks);
    let promising = &looks[..looks.len().div_ceil(PROMISING)];
    let looks = highest_first(parallel::map(promising.iter(), |look| on(look, ROUNDS[1])));
    let ends = highest_first(looks.iter().take(follow).map(|look| on(look, ROUNDS[2])).collect());
    posterior.stiff = false;
    let end = ends.first()?;
    let uncertainty = Uncertainty { supply: 0.1 * posterior.scales.supply, ..end.uncertainty };
    let mut last = posterior.climb(&end.model, &uncertainty, ROUNDS[3]);
    last.errors = posterior.standard_errors(&last);
    last.log.is_finite().then_some(last)
}

/// Without those whose simulation runs away.
fn highest_first(mut estimates: Vec<Estimate>) -> Vec<Estimate> {
    estimates.retain(|estimate| estimate.log.is_finite());
    descending(&mut estimates, |estimate| estimate.log);
    estimates
}
