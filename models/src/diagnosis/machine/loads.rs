//! Whether the loads of several recordings differ, where nobody said so.

use super::evidence::evidence_of;
use super::fit::{refit, tie};
use super::recordings::MachineChannel;
use super::ties::{Freedom, TiedModel};
use crate::diagnosis::channel::Role;
use crate::diagnosis::evidence::Evidence;
use crate::diagnosis::settings::SETTINGS;

/// Evaluations that fit one load for all recordings.
const ONE_LOAD: usize = 30;

/// Do the loads differ? `models` are base models with a load of its own for each recording, channel
/// by channel.
///
/// They do when one load for all is less likely beyond what recordings differ by, and its error
/// larger by as much as a name must take.
#[must_use]
pub fn differ(channels: &[MachineChannel], models: &[TiedModel]) -> bool {
    let own: Vec<Evidence> = channels.iter().zip(models).map(|(c, m)| evidence_of(c, m)).collect();
    let one: Vec<Evidence> = channels
        .iter()
        .zip(models)
        .map(|(channel, models)| {
            let mut start = tie(channel, models);
            let first = start.models[0].clone();
            start.models.iter_mut().for_each(|model| *model = first.clone());
            let fitted = refit(channel, &start, Freedom::OneLoad, &[Role::Fit], ONE_LOAD).models;
            evidence_of(channel, &fitted)
        })
        .collect();
    let (own, one) = (Evidence::together(&own), Evidence::together(&one));
    let (gain, error) = own.over(&one);
    gain > 2.0 * error && own.rmse_kpa() < (1.0 - SETTINGS.greybox_worth) * one.rmse_kpa()
}
