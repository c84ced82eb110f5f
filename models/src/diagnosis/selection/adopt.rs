//! What the likelihood has found takes the place of what the search has found, or has not.

use super::candidate::Candidate;
use super::search::Outcome;
use super::selected::Found;
use super::settling::staged;
use crate::diagnosis::channel::{ChannelData, Extended, share_draws};
use crate::diagnosis::estimation::{ChannelStage, plain_cost};
use crate::diagnosis::evidence::{Explanation, Missing};
use crate::diagnosis::greybox::{Named, NamedEffect};
use crate::diagnosis::likelihood::select_total;

/// Takes over base models that are closer to the recording, and the effect that stands out, if one
/// does.
pub fn adopt(outcome: &mut Outcome, channels: &mut [ChannelData], named: Named) {
    let Named { base, effect, contenders } = named;
    for ((data, known), base) in channels.iter().zip(&mut outcome.base).zip(base) {
        if plain_cost(data, &base) < plain_cost(data, known) {
            *known = base;
        }
    }
    outcome.by_likelihood = true;
    outcome.withheld = None;
    outcome.explanations.extend(
        contenders
            .into_iter()
            .map(|(effect, models)| Explanation { missing: Missing::Effects(vec![effect]), models }),
    );
    let models =
        effect.as_ref().map_or_else(|| outcome.base.clone(), |found| with_effect(&outcome.base, found));
    share_draws(channels, &models);
    outcome.stages = staged(channels, models, false);
    outcome.causes = effect.map(|found| cause(outcome, channels, found)).into_iter().collect();
}

/// Models with an effect where it acts, and the base models elsewhere.
fn with_effect(base: &[Extended], found: &NamedEffect) -> Vec<Extended> {
    let by_channel = found.models.iter().zip(&found.acts).zip(base);
    by_channel.map(|((model, acts), base)| if *acts { model } else { base }.clone()).collect()
}

fn cause(outcome: &Outcome, channels: &[ChannelData], found: NamedEffect) -> Found {
    let before = staged(channels, outcome.base.clone(), false);
    let left = |stages: &[ChannelStage]| select_total(channels, stages.iter().map(|s| &s.losses));
    let rival = |(effect, models, acts): &(usize, Vec<Extended>, Vec<bool>)| {
        let losses = staged(channels, models.clone(), false).into_iter().map(|s| s.losses).collect();
        Candidate { effect: *effect, models: models.clone(), acts: acts.clone(), losses }
    };
    Found {
        effect: found.effect,
        acts: found.acts,
        p_value: found.p_value,
        equivalent: found.equivalent.iter().map(|rival| rival.0).collect(),
        gained: left(&before) - left(&outcome.stages),
        without: outcome.base.clone(),
        rivals: found.equivalent.iter().map(rival).collect(),
        errors: Some(found.errors),
    }
}
