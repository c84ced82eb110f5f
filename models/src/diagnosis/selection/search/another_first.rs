//! The search again, begun with another effect.
//!
//! What takes most alone need be none of those that take most together, and where a fit ends
//! depends on where it began. Where the names leave more than noise and wander explain, all pairs
//! are screened, and the search is begun with an effect of the most promising that is not named.

use super::naming::{Named, Rules, name, p_value};
use super::pairs_afresh::from_pairs_afresh;
use super::taking_over::{ENOUGH, take_over};
use crate::diagnosis::channel::{ChannelData, share_draws};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::screening::{Pair, Trial, judge, promising_pairs};
use crate::diagnosis::selection::acceptance::{is_large, kept_total, open_rows};
use crate::diagnosis::selection::candidate::{Candidate, Starts, first_look, refit_further};
use crate::diagnosis::selection::search::{Progress, renew};
use crate::diagnosis::selection::selected::Found;
use crate::diagnosis::selection::settling::settle_finely;

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

#[cfg(test)]
mod tests;
