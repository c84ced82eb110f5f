//! Causes that others have made needless are dropped.

use super::selected::Found;
use super::settling::settle;
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, share_draws};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::likelihood::together;
use crate::diagnosis::resampling::bootstrap;
use crate::diagnosis::settings::SETTINGS;

/// Drops causes that are no longer needed once the others are there, and sees what each that stays
/// adds to the others: whatever was added first would otherwise have what several describe in part.
pub fn eliminate(
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

/// Refits the models without each cause in turn, and notes what it adds. Ends with the first that
/// is not needed, and the stages without it.
fn without_each(
    channels: &mut [ChannelData],
    first: &[ChannelStage],
    stages: &[ChannelStage],
    causes: &mut [Found],
    fixed: bool,
) -> Option<(usize, Vec<ChannelStage>)> {
    // A supply that the rig file states wrongly stays.
    let corrected = stages.iter().any(|stage| stage.model.has_foil());
    if let [only] = causes
        && !corrected
    {
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
    let [low, ..] = bootstrap(&without, &with, |a, b| 1.0 - (b / a).sqrt());
    let gain = 1.0 - (with.iter().sum::<f64>() / without.iter().sum::<f64>()).sqrt();
    low > 0.0 && gain >= 0.5 * SETTINGS.practical
}
