//! The search again, begun with another effect.
//!
//! What takes most alone need be none of those that take most together, and where a fit ends
//! depends on where it began. Where the names leave more than noise and wander explain, all pairs
//! are screened, and the search is begun with an effect of the most promising that is not named.

use super::naming::{Entered, Named, Rules, name, p_value};
use super::pairs_afresh::from_pairs_afresh;
use crate::diagnosis::channel::{ChannelData, OPEN, share_draws};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::likelihood::together;
use crate::diagnosis::resampling::bootstrap;
use crate::diagnosis::screening::{Asked, Pair, Trial, judge, promising_pairs, trials};
use crate::diagnosis::selection::acceptance::{is_large, kept_total, open_rows};
use crate::diagnosis::selection::candidate::{Candidate, Starts, first_look, refit_further};
use crate::diagnosis::selection::entrants::{Entrants, Field};
use crate::diagnosis::selection::racing::{is_foil, race, rivals};
use crate::diagnosis::selection::search::{Progress, renew};
use crate::diagnosis::selection::selected::Found;
use crate::diagnosis::selection::settling::{settle_finely, staged};
use crate::diagnosis::settings::SETTINGS;

/// Mean squared weighted error, in variances of the noise, up to which nothing more is looked for:
/// of sound rigs it is about 1.
const ENOUGH: f64 = 1.2;
/// Pairs of which effects are tried first, and further searches at most. Of 63 pairs that a search
/// had missed, 50 were among the ten most promising ones; three searches found 3, 2 and 1 of them.
const PROMISING: usize = 10;
/// See [`PROMISING`].
const AGAIN: usize = 3;
/// Rows of all channels that further searches may go over, together: of two channels in a minute at
/// 100 Hz three searches. A search over four channels in 220 s takes half a minute and more in
/// closed loop.
const MOST_ROWS: usize = 36_000;
/// Evaluations of the model for a first effect: of a look, and of each of two refits after it.
const EVALUATIONS: [usize; 2] = [6, 10];
/// Part of the error above the noise that names may leave where there were none.
const NEARLY_ALL: f64 = 0.02;
/// Where something outside the catalogue explained as well as a name, what is named now must leave
/// less than this part of what that left.
const BESIDE_FOIL: f64 = 0.8;

/// Searches from effects of the most promising pairs on, from the `first` stages, and takes over
/// what explains better than `named` with its `stages`.
pub fn from_another_first(
    channels: &mut [ChannelData],
    (first, stages): (&[ChannelStage], &mut Vec<ChannelStage>),
    rules: Rules<'_>,
    named: &mut Named,
    progress: &Progress<'_>,
) {
    let Some(round) = named.first_round.take() else { return };
    let tried = &round.tried;
    let first = &mut first.to_vec()[..];
    let rows: usize = channels.iter().map(|data| data.rows.len()).sum();
    let most = most_searches(rows);
    if most == 0 && !is_large(channels, stages)
        || kept_total(channels, stages) <= ENOUGH * open_rows(channels)
    {
        return;
    }
    let (pairs, gates) = (promising_pairs(channels, first, tried), judge(tried));
    let mut begun: Vec<usize> = named.causes.first().map(|cause| cause.effect).into_iter().collect();
    let mut searches = 0;
    while searches < most {
        let left = kept_total(channels, stages);
        if left <= ENOUGH * open_rows(channels) {
            return;
        }
        let Some(effect) = next_first(&pairs, &named.causes, &begun) else { break };
        begun.push(effect);
        let before = models_of(stages);
        share_draws(channels, &models_of(first));
        renew(channels, first);
        let candidate = refitted(channels, first, tried, effect);
        if !candidate.acts.contains(&true) {
            share_draws(channels, &before);
            continue;
        }
        progress("trying the catalogue from another effect on", searches as u64);
        searches += 1;
        let found =
            Found::new(channels, first, std::slice::from_ref(&candidate), 0, &[], p_value(&gates, effect));
        let mut other = settle_finely(channels, &candidate.models, false);
        let mut again = Named { causes: vec![found], ..Named::default() };
        name(channels, (first, &mut other), Rules { beating: Some(left), ..rules }, &mut again, progress);
        if !take_over(channels, (again, other), (named, stages), &[effect], (&round, rules.asked)) {
            share_draws(channels, &before);
        }
    }
    from_pairs_afresh(channels, (first, stages), (&round, &pairs, &gates), rules, named, progress);
}

/// Takes over what another search has `named`, with its stages, if it is better. Did it?
pub(super) fn take_over(
    channels: &mut [ChannelData],
    (mut again, other): (Named, Vec<ChannelStage>),
    (named, stages): (&mut Named, &mut Vec<ChannelStage>),
    begun: &[usize],
    (round, asked): (&Entered, Asked<'_>),
) -> bool {
    named.explanations.append(&mut again.explanations);
    let better = is_better(channels, (&again, &other), (named, stages))
        && begun
            .iter()
            .all(|&effect| stands_in_the_catalogue(channels, &other, &mut again.causes, effect, asked));
    if better {
        *stages = other;
        (named.causes, named.withheld) = (again.causes, None);
        let best = round.ranked.first().map(|candidate| candidate.effect);
        put_first(&mut named.causes, |cause| Some(cause.effect) == best);
    }
    better
}

/// Names what explains most alone before the others: with what a search began says nothing of it.
fn put_first(causes: &mut [Found], is_first: impl Fn(&Found) -> bool) {
    if let Some(place) = causes.iter().position(is_first) {
        causes[..=place].rotate_right(1);
    }
}

/// Further searches over so many rows of all channels, at most.
fn most_searches(rows: usize) -> usize {
    AGAIN.min(MOST_ROWS / rows.max(1))
}

/// An effect of the most promising pair that is not named, with which no search has begun.
fn next_first(pairs: &[Pair], causes: &[Found], begun: &[usize]) -> Option<usize> {
    let known = |effect: &usize| causes.iter().any(|cause| cause.is(*effect));
    let pairs = pairs.iter().take(PROMISING).map(|pair| pair.effects);
    let unnamed = pairs.filter(|effects| !effects.iter().all(known)).flatten();
    unnamed.into_iter().find(|effect| !begun.contains(effect))
}

/// An effect as a candidate beside the stages without it, with the models that a search has ended
/// with.
pub(super) fn as_candidate(
    channels: &[ChannelData],
    without: &[ChannelStage],
    stages: &[ChannelStage],
    effect: usize,
) -> Candidate {
    let acts = vec![true; stages.len()];
    let ended = Candidate { effect, models: models_of(stages), acts, losses: Vec::new() };
    refit_further(channels, without, &ended, 0)
}

/// One effect beside nothing, refitted.
fn refitted(
    channels: &[ChannelData],
    first: &[ChannelStage],
    tried: &[Vec<Trial>],
    effect: usize,
) -> Candidate {
    let [look, earnest] = EVALUATIONS;
    let looked = first_look(channels, first, tried, (effect, Starts::TrialsAndSizes), look);
    let further = |candidate: &Candidate| refit_further(channels, first, candidate, earnest);
    further(&further(&looked))
}

/// Do names that do no harm explain better than `before`: surely and by enough for each further
/// one, or as well with fewer? Where there were none they must leave no more than is enough. What
/// is outside the catalogue competes: where it explained as well as a name before, they must leave
/// less than it.
fn is_better(
    channels: &[ChannelData],
    (again, other): (&Named, &[ChannelStage]),
    (named, before): (&Named, &[ChannelStage]),
) -> bool {
    let losses = |stages: &[ChannelStage]| together(channels, stages.iter().map(|s| &s.losses), &OPEN);
    let (old, new) = (losses(before), losses(other));
    let sum = |losses: &[f64]| losses.iter().sum::<f64>();
    let beyond_foil = named.withheld.as_ref().is_none_or(|withheld| {
        sum(&new) < BESIDE_FOIL * sum(&together(channels, &withheld.foil.losses, &OPEN))
    });
    let [low, ..] = bootstrap(&old, &new, |a, b| 1.0 - (b / a).sqrt());
    let gain = 1.0 - (sum(&new) / sum(&old)).sqrt();
    let (few, many) = (named.causes.len(), again.causes.len());
    let least = if many > few { (many - few) as f64 } else { 0.5 } * SETTINGS.practical;
    let explains = if many < few { gain >= -least } else { low > 0.0 && gain >= least };
    let enough = few > 0 || sum(&new) <= next_to_nothing(sum(&old), open_rows(channels));
    let harmless = again.harmful.is_none() && again.withheld.is_none();
    many > 0 && harmless && beyond_foil && enough && explains
}

/// Error up to which names are trusted where there were none: what is [`ENOUGH`], or nearly all of
/// an error that was `before`, both in variances of the noise over so many rows.
fn next_to_nothing(before: f64, rows: f64) -> f64 {
    (ENOUGH * rows).max(rows + NEARLY_ALL * (before - rows))
}

/// Tries the catalogue in place of the effect that a search was begun with, beside what else was
/// named, and notes what explains as well. False where something outside the catalogue does: then
/// it is no name.
fn stands_in_the_catalogue(
    channels: &mut [ChannelData],
    stages: &[ChannelStage],
    causes: &mut [Found],
    begun: usize,
    asked: Asked<'_>,
) -> bool {
    let Some(cause) = causes.iter_mut().find(|cause| cause.effect == begun) else { return true };
    share_draws(channels, &cause.without);
    let without = staged(channels, cause.without.clone(), false);
    let tried = trials(channels, &without, asked, &|| {});
    let gates = judge(&tried);
    let field = Field { channels, stages: &without, tried: &tried, gates: &gates };
    let mut ranked = race(field, Entrants::Passed, &mut Vec::new());
    share_draws(channels, &models_of(stages));
    // From where the others end without it, a fit may not come as far as the search has.
    ranked.retain(|candidate| candidate.effect != begun);
    ranked.push(as_candidate(channels, &without, stages, begun));
    let own = ranked.len() - 1;
    let equivalent = rivals(channels, &without, &ranked, own);
    cause.equivalent = equivalent.iter().map(|&k| ranked[k].effect).collect();
    cause.rivals = equivalent.iter().map(|&k| ranked[k].clone()).collect();
    cause.p_value = p_value(&gates, begun);
    !cause.rivals.iter().any(is_foil)
}

#[cfg(test)]
mod tests;
