//! Which of two models of a loop that hunts is likelier.

use super::covariance::Whitening;
use super::deviance::{Losses, total};
use super::residuals::whitened_residuals;
use crate::diagnosis::channel::{ChannelData, Extended, Role, readings_of};

/// [Deviances](Losses::deviance) of models on the blocks for fitting.
pub fn deviances(data: &ChannelData, whitening: &Whitening, models: &[Extended]) -> Vec<f64> {
    let readings = readings_of(data, models);
    let residuals: Vec<_> = readings.iter().map(|y| whitened_residuals(data, whitening, y)).collect();
    let losses = Losses::of(data, whitening, models, &residuals);
    losses.iter().map(|losses| total(data, &losses.deviance, &[Role::Fit])).collect()
}

/// The one of two models that has less [deviance](Losses::deviance) on the blocks for fitting,
/// behind that. A fit of the squared error prefers a model that hunts less than the recording.
#[must_use]
pub fn likelier(data: &ChannelData, whitening: &Whitening, models: [Extended; 2]) -> (f64, Extended) {
    let deviances = deviances(data, whitening, &models);
    let [one, other] = models;
    if deviances[1] < deviances[0] { (deviances[1], other) } else { (deviances[0], one) }
}
