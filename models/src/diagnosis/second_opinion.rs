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
use crate::diagnosis::selection::{Outcome, Progress};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::rig::Rig;

/// Rate at which the likelihood looks at a recording: what it compares lasts a tenth of a second and more, and its work goes with the rows.
const LIKELIHOOD_HZ: f64 = 100.0;

/// What the likelihood names instead of the search, from a base model that is far off. Where the search's causes bring the model near the
/// recording, the question is only whether one of several does it alone, and the rest of the catalogue is fitted if it does.
#[must_use]
pub fn second_opinion(
    recording: &Recording,
    rig: &Rig,
    channels: &[ChannelData],
    outcome: &Outcome,
    progress: &Progress<'_>,
) -> Option<Named> {
    let near = |models: &[Extended]| !adequacy::astray(channels, models);
    let found: Vec<usize> = outcome.causes.iter().map(|cause| cause.effect).collect();
    let explained = near(&models_of(&outcome.stages));
    if near(&outcome.base) || (explained && found.len() < 2) {
        return None;
    }
    // A channel that has too few rows to be looked at slowly is looked at as it is.
    let slowly = slowly(recording, rig).ok().filter(|slowly| slowly.len() == channels.len());
    let looked_at = slowly.as_deref().unwrap_or(channels);
    let name = |effects: &[usize]| {
        let named = greybox::name(looked_at, &outcome.base, effects, &|| progress("", 1));
        named.filter(|named| outcome.causes.is_empty() || stands_instead(channels, named, outcome))
    };
    if explained {
        progress("fitting each of the causes alone by likelihood", 0);
        name(&found)?;
    }
    progress("fitting the catalogue by likelihood", 0);
    name(&(0..CATALOGUE.len()).collect::<Vec<_>>())
}

/// The channels at about [`LIKELIHOOD_HZ`], as far as the likelihood looks at them.
fn slowly(recording: &Recording, rig: &Rig) -> Result<Vec<ChannelData>, DiagnosisError> {
    let factor = (recording.rate_hz() / LIKELIHOOD_HZ).floor();
    let (mut channels, _) = prepare_for(&recording.thinned(factor as usize), rig, Purpose::Compare)?;
    simulate_coarsely(&mut channels, true);
    Ok(channels)
}

/// Does the effect that stands out by likelihood take the place of what the search has named from a base model that is far off? It does
/// where it predicts the choosing blocks better. Where the search has named it among others, which take up what is left of a large error,
/// each of them must take as much of it as any name by likelihood must.
fn stands_instead(channels: &[ChannelData], named: &Named, outcome: &Outcome) -> bool {
    let Some(effect) = &named.effect else { return false };
    let searched = models_of(&outcome.stages);
    let density = |models: &[Extended]| evidence(channels, models).log_density();
    let error = |models: &[Extended]| BlockErrors::of(channels, models, Role::Select).all();
    let others = outcome.causes.iter().filter(|cause| cause.effect != effect.effect).count();
    let among = others > 0 && others < outcome.causes.len();
    // What is left when each of the others takes the least share of what those before it leave.
    let most_left = (0..others).fold(error(&effect.models), |left, _| (1.0 - SETTINGS.greybox_worth) * left);
    among && error(&searched) > most_left || density(&effect.models) > density(&searched)
}
