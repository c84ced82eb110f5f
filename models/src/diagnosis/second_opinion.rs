//! Whether the likelihood names something else than the search, from a base model that is far off.

use crate::data::Recording;
use crate::diagnosis::channel::{ChannelData, Extended, Role, simulate_coarsely};
use crate::diagnosis::discrepancy::adequacy;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::estimation::models_of;
use crate::diagnosis::evidence::evidence;
use crate::diagnosis::greybox::{self, Named};
use crate::diagnosis::preconditions::{Purpose, prepare_for};
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::screening::Asked;
use crate::diagnosis::selection::{Outcome, Progress};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::rig::Rig;

/// Rate at which the likelihood looks at a recording: what it compares lasts a tenth of a second
/// and more, and its work goes with the rows.
const LIKELIHOOD_HZ: f64 = 100.0;

/// What the likelihood names instead of the search, where it is [asked](is_asked).
#[must_use]
pub fn second_opinion(
    recording: &Recording,
    rig: &Rig,
    channels: &[ChannelData],
    outcome: &Outcome,
    asked: Asked<'_>,
    progress: &Progress<'_>,
) -> Option<Named> {
    let near = |models: &[Extended]| !adequacy::astray(channels, models);
    if !is_asked(near(&outcome.base), outcome.causes.len(), || near(&models_of(&outcome.stages))) {
        return None;
    }
    // A channel that has too few rows to be looked at slowly is looked at as it is.
    let slowly = slowly(recording, rig).ok().filter(|slowly| slowly.len() == channels.len());
    let looked_at = slowly.as_deref().unwrap_or(channels);
    progress("fitting the catalogue by likelihood", 0);
    let effects: Vec<usize> = (0..CATALOGUE.len()).filter(|&effect| asked.is_among(effect)).collect();
    let named = greybox::name(looked_at, &outcome.base, &effects, &|| progress("", 1));
    named.filter(|named| outcome.causes.is_empty() || stands_instead(channels, named, outcome))
}

/// Is the likelihood asked, after a search that has named so many causes and may have come near the
/// recording? From a base model that is far off, one cause that brings it there is the answer.
/// Several may be so many ways to imitate another one, however near they come, and which of them
/// the search comes to may hang on the last digit.
fn is_asked(base_is_near: bool, causes: usize, searched_is_near: impl FnOnce() -> bool) -> bool {
    !base_is_near && (causes > 1 || !searched_is_near())
}

/// The channels at about [`LIKELIHOOD_HZ`], as far as the likelihood looks at them.
fn slowly(recording: &Recording, rig: &Rig) -> Result<Vec<ChannelData>, DiagnosisError> {
    let factor = (recording.rate_hz() / LIKELIHOOD_HZ).floor();
    let (mut channels, _) = prepare_for(&recording.thinned(factor as usize), rig, Purpose::Compare)?;
    simulate_coarsely(&mut channels, true);
    Ok(channels)
}

/// Does the effect that stands out by likelihood take the place of what the search has named?
fn stands_instead(channels: &[ChannelData], named: &Named, outcome: &Outcome) -> bool {
    let Some(effect) = &named.effect else { return false };
    let searched = models_of(&outcome.stages);
    let causes: Vec<usize> = outcome.causes.iter().map(|cause| cause.effect).collect();
    let both = |of: &dyn Fn(&[Extended]) -> f64| Both { searched: of(&searched), likely: of(&effect.models) };
    let error = both(&|models| BlockErrors::of(channels, models, &[Role::Select]).all());
    let density = both(&|models| evidence(channels, models).log_density());
    takes_the_place(effect.effect, &causes, error, density)
}

/// A figure of the model that the search has ended with, and of the one that stands out by
/// likelihood.
#[derive(Debug, Clone, Copy)]
struct Both {
    searched: f64,
    likely: f64,
}

/// From a base model that is far off, `effect` takes the place of the search's `causes` where it
/// predicts the choosing blocks better (log `density`). Where it is one of them, and others take up
/// what is left of a large `error`, each of those must take as much of it as any name by likelihood
/// must.
fn takes_the_place(effect: usize, causes: &[usize], error: Both, density: Both) -> bool {
    let others = causes.iter().filter(|&&cause| cause != effect).count();
    let among = others > 0 && others < causes.len();
    // What is left when each of the others takes the least share of what those before it leave.
    let most_left = (0..others).fold(error.likely, |left, _| (1.0 - SETTINGS.greybox_worth) * left);
    among && error.searched > most_left || density.likely > density.searched
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_far_off_only_one_cause_that_comes_near_is_the_answer() {
        assert!(!is_asked(false, 1, || true));
        assert!(is_asked(false, 2, || true), "several may imitate another one");
        assert!(is_asked(false, 1, || false) && is_asked(false, 0, || false));
        assert!((0..3).all(|causes| !is_asked(true, causes, || false)), "there is nothing to find");
    }

    /// Of a name by likelihood that leaves an error of 1, and predicts worse than the search.
    fn place_of(causes: &[usize], searched_error: f64) -> bool {
        let error = Both { searched: searched_error, likely: 1.0 };
        takes_the_place(3, causes, error, Both { searched: 0.0, likely: -1.0 })
    }

    #[test]
    fn what_predicts_better_takes_the_place_of_anything() {
        let density = Both { searched: 0.0, likely: 1.0 };
        assert!(takes_the_place(3, &[5, 7], Both { searched: 0.1, likely: 1.0 }, density));
        assert!(!place_of(&[5, 7], 0.99), "it predicts worse, and the search has not named it");
        assert!(!place_of(&[3], 1.0), "the search has named it alone already");
    }

    #[test]
    fn those_beside_it_stay_where_each_takes_its_share() {
        let share = 1.0 - SETTINGS.greybox_worth;
        assert!(place_of(&[3, 5], share + 0.01));
        assert!(!place_of(&[3, 5], share - 0.01));
        assert!(place_of(&[3, 5, 7], share * share + 0.01), "two have to take twice as much");
        assert!(!place_of(&[3, 5, 7], share * share - 0.01));
    }
}
