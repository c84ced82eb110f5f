//! The base model, fitted to each channel before anything is named.

use super::least_squares::refit;
use crate::diagnosis::channel::{ChannelData, Extended, Role, readings_of};
use crate::diagnosis::likelihood::{Whitening, block_losses, row_count, total, whitened_residuals};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::Question;
use crate::effects::catalogue::CATALOGUE;
use crate::model::Parameter;
use crate::order::ascending;

/// Areas at which the search for the valve's gain begins, mm^2 per 1e-4 m^3 of volume: fills that
/// take from minutes to milliseconds.
pub const GAINS: [f64; 7] = [0.02, 0.07, 0.2, 0.7, 2.0, 7.0, 20.0];
/// Drives at which the search for the edges begins.
pub const EDGES: [f64; 3] = [0.0, 0.06, 0.2];
/// Leaks and width of the corner where a search begins, over the gain.
pub const LEAK: f64 = 0.003;
/// See [`LEAK`].
pub const CORNER: f64 = 0.03;
/// A corner of this width, mm^2, is sharp: the smallest drives open as much.
const SHARP_MM2: f64 = 1e-3;

/// A fit that multiplies the plain error of the first look by this has gone astray.
const ASTRAY: f64 = 1.5;
/// Evaluations spent on each of the best starts.
const LOOK: usize = 6;
/// Evaluations spent at a time on the better one.
const EARNEST: usize = 12;

/// Times that a fit goes on at most with the weights of where it stands, unless so few evaluations
/// end it.
const AGAIN: usize = 4;
/// See [`AGAIN`].
const FEW: usize = 3;

/// Positions of the base model's free parameters.
#[must_use]
pub fn free_base(data: &ChannelData) -> Vec<usize> {
    let still = data.inputs.volume_rate_m3_s.iter().all(|v| v.abs() <= 0.0);
    let parameters = data.plant.parameters();
    (0..parameters.len()).filter(|&k| !(still && parameters[k].name == "volume_weight")).collect()
}

/// Positions of a model's free parameters. Where a reference was calibrated, only what can have
/// changed since is free, and not the effects that the reference has.
#[must_use]
pub fn free_of(data: &ChannelData, model: &Extended, calibrated: bool) -> Vec<usize> {
    let own = if calibrated { Vec::new() } else { free_base(data) };
    let asked = |effect: &usize| !calibrated || CATALOGUE[*effect].question == Question::Change;
    let effects = model.effects.iter().copied().filter(asked);
    own.into_iter().chain(effects.filter_map(|effect| model.range(&data.plant, effect)).flatten()).collect()
}

/// The base model with what sound rigs have in small and no parameter of its own describes, where
/// the drive of a spool is recorded.
#[must_use]
pub fn with_usual(data: &ChannelData, model: &Extended) -> Extended {
    let recorded = data.inputs.spool_is_recorded();
    let usual = (0..CATALOGUE.len()).filter(|&e| recorded && CATALOGUE[e].in_base(&data.plant));
    usual.fold(model.clone(), |model, effect| model.with_usual(&data.plant, effect))
}

/// A first-principles model whose valve has this gain, mm^2 per 1e-4 m^3 of volume, and opens at
/// this drive.
#[must_use]
pub fn start(data: &ChannelData, gain: f64, edge: f64) -> Extended {
    let parameters = data.plant.parameters();
    let volume = data.inputs.volume_m3.first().copied().unwrap_or(1e-4);
    let discharge = data.plant.model.valve().map_or(1.0, |valve| valve.discharge_coefficient);
    let gain = gain * volume / 1e-4 / discharge;
    // Of one spool, whose vent port opens at negative drives.
    let out = if data.plant.separate() { edge } else { -edge };
    let value = |p: &Parameter| match p.name.as_str() {
        "leak_in" | "leak_out" => LEAK * gain,
        "gain" | "gain_in" | "gain_out" => gain,
        "threshold_in" => edge,
        "threshold_out" => out,
        "corner" => CORNER * gain,
        _ => p.nominal,
    };
    Extended::base(parameters.iter().map(|p| value(p).clamp(p.lower, p.upper)).collect())
}

/// The model with leaks and corner of a [`start`], where its corner has become so sharp that
/// nothing depends on its width any more: where a base model was fitted alone it has imitated what
/// it lacks, and would stay there.
#[must_use]
pub fn rounded(data: &ChannelData, model: &Extended) -> Option<Extended> {
    let corner = data.plant.position("corner")?;
    if model.values[corner] > SHARP_MM2 {
        return None;
    }
    let gain = gain_of(data, model)?;
    let mut rounded = model.clone();
    for leak in ["leak_in", "leak_out"] {
        rounded.values[data.plant.position(leak)?] = LEAK * gain;
    }
    rounded.values[corner] = CORNER * gain;
    Some(rounded)
}

/// Gain of the valve, mm^2, the filling one of two; none of a regulator.
#[must_use]
pub fn gain_of(data: &ChannelData, model: &Extended) -> Option<f64> {
    let position = data.plant.position("gain").or_else(|| data.plant.position("gain_in"))?;
    Some(model.values[position])
}

/// Fits the base model to a channel from a grid of starts.
#[must_use]
pub fn fit_base(data: &ChannelData) -> Extended {
    let starts: Vec<Extended> = if data.plant.model.is_regulator() {
        [0.3, 1.0, 3.0, 10.0, 30.0].map(|rate| Extended::base(vec![rate, rate])).to_vec()
    } else {
        GAINS.iter().flat_map(|gain| EDGES.map(|edge| start(data, *gain, edge))).collect()
    };
    let costs = plain_costs(data, &starts).into_iter();
    let mut ranked: Vec<(f64, Extended)> = costs.zip(starts).filter(|(cost, _)| cost.is_finite()).collect();
    ascending(&mut ranked, |item| item.0);
    // A few steps from the two best starts, then in earnest from the better; the weights depend on
    // the model.
    let looked = ranked.into_iter().take(2).map(|(_, start)| {
        let model = refit_by_own_weights(data, &start, LOOK).0;
        (plain_cost(data, &model), model)
    });
    match looked.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((_, look)) => fit_base_from(data, &look),
        None => {
            let nominal = data.plant.parameters().iter().map(|p| p.nominal).collect();
            with_usual(data, &Extended::base(nominal))
        }
    }
}

/// Fits the base model to a channel from one start.
#[must_use]
pub fn fit_base_from(data: &ChannelData, start: &Extended) -> Extended {
    let mut model = with_usual(data, &refit_by_own_weights(data, start, EARNEST).0);
    let times = if data.inputs.spool_is_recorded() { AGAIN } else { 0 };
    for _ in 0..=times {
        let (next, spent) = refit_by_own_weights(data, &model, EARNEST);
        model = next;
        if spent <= FEW {
            break;
        }
    }
    // Where the model is no description, the weights (starts and supply free) lead it astray
    // between the blocks.
    if is_astray(data, &model, start) { with_usual(data, start) } else { model }
}

/// Has a fit made the plain error on its blocks much larger than where it started?
#[must_use]
pub fn is_astray(data: &ChannelData, fitted: &Extended, start: &Extended) -> bool {
    plain_cost(data, fitted) > ASTRAY * plain_cost(data, start)
}

/// Some steps of a fit with the weights that go with where it starts, and how many evaluations they
/// took.
#[must_use]
pub fn refit_by_own_weights(data: &ChannelData, model: &Extended, evaluations: usize) -> (Extended, usize) {
    refit(data, &weights(data, model), model, &free_of(data, model, false), evaluations)
}

/// Weights that go with a model. What is left of its error when noise and wander have had their
/// part is an error of its own: if that is large, wander is weighed beside it.
fn weights(data: &ChannelData, model: &Extended) -> Whitening {
    let derivatives = data.disturbances(model);
    let usual = Whitening::new(data, &derivatives);
    let residuals = whitened_residuals(data, &usual, &data.readings(model));
    let roles = &[Role::Fit];
    let left = total(data, &block_losses(data, &residuals), roles) / row_count(data, roles).max(1.0);
    if left > SETTINGS.large_error {
        Whitening::beside_error(data, &derivatives, data.noise_kpa * left.sqrt())
    } else {
        usual
    }
}

/// Mean squared residual on the fit blocks, kPa^2.
#[must_use]
pub fn plain_cost(data: &ChannelData, model: &Extended) -> f64 {
    plain_cost_of(data, &data.readings(model))
}

/// The same of several models.
#[must_use]
pub fn plain_costs(data: &ChannelData, models: &[Extended]) -> Vec<f64> {
    readings_of(data, models).iter().map(|readings| plain_cost_of(data, readings)).collect()
}

fn plain_cost_of(data: &ChannelData, readings: &[f64]) -> f64 {
    let fit = data.blocks.iter().zip(&data.spans).filter(|(b, _)| b.role == Role::Fit);
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (_, span) in fit {
        let pairs = readings[span.clone()].iter().zip(&data.measured_kpa[span.clone()]);
        sum += pairs.map(|(y, m)| (y - m) * (y - m)).sum::<f64>();
        count += span.len() as f64;
    }
    sum / count.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, with};

    /// What the weights leave of another level of the supply.
    fn left_of_a_level(data: &ChannelData, model: &Extended) -> f64 {
        let mut level: Vec<f64> = data.disturbances(model).iter().map(|d| d[1]).collect();
        weights(data, model).apply(&mut level);
        level.iter().map(|v| v * v).sum()
    }

    #[test]
    fn what_a_reference_has_is_held_and_only_what_can_have_changed_is_fitted() {
        let (data, base) = channel(false);
        let reference = with(&data, &base, "valve_asymmetry", &[1.1]);
        assert!(free_of(&data, &reference, true).is_empty());
        let leaking = with(&data, &reference, "exhaust_leak", &[0.02]);
        let free = free_of(&data, &leaking, true);
        assert_eq!(free.iter().map(|&k| leaking.values[k]).collect::<Vec<_>>(), [0.02]);
        assert_eq!(free_of(&data, &leaking, false).len(), free_base(&data).len() + 2);
    }

    #[test]
    fn an_error_cannot_hide_in_wander_where_the_model_is_far_off() {
        let (mut data, base) = channel(false);
        let right = left_of_a_level(&data, &base);
        data.measured_kpa = data.readings(&with(&data, &base, "valve_hysteresis", &[0.15])).into();
        let far_off = left_of_a_level(&data, &base);
        assert!(far_off > 10.0 * right, "{far_off} {right}");
    }
}
