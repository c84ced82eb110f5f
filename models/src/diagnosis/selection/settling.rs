//! Refitting all channels until it brings no more, in steps as fine as that needs.

use super::acceptance::{kept_total, open_rows};
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, halved, share_draws, simulate_finer};
use crate::diagnosis::estimation::{ChannelStage, free_of, models_of, refit};
use crate::diagnosis::likelihood::{Whitening, hunts, likelier};
use crate::diagnosis::settings::SETTINGS;
use crate::parallel;

/// Evaluations that may be spent when everything is fitted together.
pub const SETTLE: usize = 20;
/// Times that is done again at most, while what is left falls to less than this part of it.
const AGAIN: usize = 6;
/// See [`AGAIN`].
const SETTLED: f64 = 0.99;

/// As [`settle`]. A model may be stiffer than the one before: what its step leaves must not be
/// named next.
pub fn settle_finely(channels: &mut [ChannelData], models: &[Extended], fixed: bool) -> Vec<ChannelStage> {
    let mut stages = settle(channels, models, fixed);
    while halving(channels, &stages) > SETTINGS.step_error && simulate_finer(channels) {
        let models = models_of(&stages);
        stages = settle(channels, &models, fixed);
    }
    stages
}

/// Mean squared change of the whitened residuals when the integration step is halved, in variances
/// of the noise.
fn halving(channels: &[ChannelData], stages: &[ChannelStage]) -> f64 {
    let change = |(data, stage): (&ChannelData, &ChannelStage)| -> f64 {
        let mut difference = halved(data).readings(&stage.model);
        difference.iter_mut().zip(&stage.readings).for_each(|(a, b)| *a = (*a - b) / data.noise_kpa);
        stage.whitening.apply(&mut difference);
        let open = data.blocks.iter().zip(&data.spans).filter(|(b, _)| OPEN.contains(&b.role));
        open.flat_map(|(_, span)| &difference[span.clone()]).map(|d| d * d).sum()
    };
    parallel::map(channels.iter().zip(stages), change).iter().sum::<f64>() / open_rows(channels).max(1.0)
}

/// Refits models with the weights that go with them, again with those of where that ends, until it
/// brings no more.
pub fn settle(channels: &mut [ChannelData], models: &[Extended], fixed: bool) -> Vec<ChannelStage> {
    let settled = |channels: &mut [ChannelData], models: &[Extended]| {
        let fitted = fitted_by(channels, models, fixed, |data, whitening, model, free| {
            refit(data, whitening, model, free, SETTLE).0
        });
        staged(channels, fitted, fixed)
    };
    let mut stages = settled(channels, models);
    let times = if channels.iter().all(|data| data.inputs.spool_is_recorded()) { AGAIN } else { 0 };
    for _ in 0..times {
        let further = settled(channels, &models_of(&stages));
        let (before, after) = (kept_total(channels, &stages), kept_total(channels, &further));
        if after < before {
            stages = further;
        }
        if after >= SETTLED * before {
            break;
        }
    }
    stages
}

/// Where models stand, each with the weights that go with it.
pub fn staged(channels: &[ChannelData], models: Vec<Extended>, fixed: bool) -> Vec<ChannelStage> {
    parallel::map(channels.iter().zip(models), |(data, model)| {
        let free = free_of(data, &model, fixed);
        ChannelStage::new(data, model, free)
    })
}

/// Refits models with the weights of where they start.
pub fn fitted_by(
    channels: &mut [ChannelData],
    models: &[Extended],
    fixed: bool,
    fit: impl Fn(&ChannelData, &Whitening, &Extended, &[usize]) -> Extended + Sync,
) -> Vec<Extended> {
    share_draws(channels, models);
    parallel::map(channels.iter().zip(models), |(data, model)| {
        let free = free_of(data, model, fixed);
        let whitening = Whitening::new(data, &data.disturbances(model));
        let fitted = fit(data, &whitening, model, &free);
        if hunts(data, &fitted) { likelier(data, &whitening, [model.clone(), fitted]).1 } else { fitted }
    })
}
