//! What another search finds, beside what was named before: is it better?

use super::naming::{Entered, Named, p_value};
use crate::diagnosis::channel::{ChannelData, OPEN, share_draws};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::likelihood::together;
use crate::diagnosis::resampling::bootstrap;
use crate::diagnosis::screening::{Asked, judge, trials};
use crate::diagnosis::selection::acceptance::open_rows;
use crate::diagnosis::selection::candidate::{Candidate, refit_further};
use crate::diagnosis::selection::entrants::{Entrants, Field};
use crate::diagnosis::selection::racing::{is_foil, race, rivals};
use crate::diagnosis::selection::selected::Found;
use crate::diagnosis::selection::settling::staged;
use crate::diagnosis::settings::SETTINGS;

/// Mean squared weighted error, in variances of the noise, up to which nothing more is looked for:
/// of sound rigs it is about 1.
pub const ENOUGH: f64 = 1.2;
/// Part of the error above the noise that names may leave of a loop where there were none.
const NEARLY_ALL: f64 = 0.02;
/// Where something outside the catalogue explained as well as a name, what is named now must leave
/// less than this part of what that left.
const BESIDE_FOIL: f64 = 0.8;

/// Takes over what another search has `named`, with its stages, if it is better. Did it?
pub fn take_over(
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
pub fn put_first(causes: &mut [Found], is_first: impl Fn(&Found) -> bool) {
    if let Some(place) = causes.iter().position(is_first) {
        causes[..=place].rotate_right(1);
    }
}

/// An effect as a candidate beside the stages without it, with the models that a search has ended
/// with.
pub fn as_candidate(
    channels: &[ChannelData],
    without: &[ChannelStage],
    stages: &[ChannelStage],
    effect: usize,
) -> Candidate {
    let acts = vec![true; stages.len()];
    let ended = Candidate { effect, models: models_of(stages), acts, losses: Vec::new() };
    refit_further(channels, without, &ended, 0)
}

/// Do names that do no harm explain better than `before`: surely and by enough for each further
/// one, or as well with fewer? Where there were none they must leave no more than is enough. What
/// is outside the catalogue competes: where it explained as well as a name before, they must leave
/// less than it.
pub fn is_better(
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
    let looped = channels.iter().all(|data| data.inputs.in_loop());
    let enough = few > 0 || sum(&new) <= next_to_nothing(sum(&old), open_rows(channels), looped);
    many > 0 && again.harmful.is_none() && beyond_foil && enough && explains
}

/// Error up to which names are trusted where there were none: what is [`ENOUGH`], or of a loop,
/// which makes more of every small error, nearly all of an error that was `before`; both in
/// variances of the noise over so many rows.
pub fn next_to_nothing(before: f64, rows: f64, looped: bool) -> f64 {
    let nearly_all = if looped { NEARLY_ALL * (before - rows) } else { 0.0 };
    (ENOUGH * rows).max(rows + nearly_all)
}

/// Tries the catalogue in place of the effect that a search was begun with, beside what else was
/// named, and notes what explains as well. False where something outside the catalogue does: then
/// it is no name.
pub fn stands_in_the_catalogue(
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
