//! A second look where nothing explains: every effect with base parameters of its own.
//!
//! A base model that is fitted alone may go so far to imitate an effect (ten times the valve's
//! gain, say, for what chatters behind a narrow tube) that the effect itself explains nothing from
//! there.

use crate::diagnosis::settings::SETTINGS;
use crate::order::ascending;

use super::acceptance::{is_large, worth_naming};
use super::candidate::{Candidate, refit_further};
use super::chance::p_value;
use super::racing::rivals;
use super::selected::Found;
use crate::diagnosis::channel::{ChannelData, Extended, OPEN};
use crate::diagnosis::estimation::{
    ChannelStage, GAINS, free_of, plain_cost, plain_costs, refit, refit_by_own_weights, start, with_usual,
};
use crate::diagnosis::likelihood::{Whitening, together};
use crate::diagnosis::screening::{Asked, Trial};
use crate::effects::Question;
use crate::effects::catalogue::CATALOGUE;
use crate::parallel;

/// Drive at which the valve's edges are taken to be.
const EDGE: f64 = 0.06;
/// Effects that are fitted.
const LOOKED: usize = 4;
/// An effect that leaves more than this part of the squared error of a channel is not followed.
const PART: f64 = 0.3;
/// The same of two effects together: what is left may be the weighed error's to judge.
const PART_OF_TWO: f64 = 0.5;
/// Starts of a pair that are fitted.
const FOLLOWED: usize = 2;
/// Evaluations of a fit, with weights that go with its start.
const EVALUATIONS: usize = 10;

/// A cause that explains a large error only with base parameters of its own, and the models with
/// it.
#[must_use]
pub fn explained_afresh(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    asked: Asked<'_>,
) -> Option<(Vec<Extended>, Found)> {
    let ranked = candidates(channels, stages, asked);
    let best = ranked.first().filter(|best| worth_naming(channels, stages, best))?;
    let p_value = p_value(channels, stages, best);
    if p_value > SETTINGS.level {
        return None;
    }
    let equivalent = rivals(channels, stages, &ranked, 0);
    Some((best.models.clone(), Found::new(channels, stages, &ranked, 0, &equivalent, p_value)))
}

/// Looks on the channel with the largest error for effects that explain it, and fits those to all;
/// best first.
fn candidates(channels: &[ChannelData], stages: &[ChannelStage], asked: Asked<'_>) -> Vec<Candidate> {
    let Some((worst, cost)) = worst(channels, stages) else { return Vec::new() };
    // A valve that imitates what is missing there, too, leads as far astray.
    let described = |k: &usize| !is_large(&channels[*k..=*k], &stages[*k..=*k]);
    let valves: Vec<&Extended> = (0..channels.len()).filter(described).map(|k| &stages[k].model).collect();
    let first = first_looks(&channels[worst], &valves, asked);
    let mut looked = parallel::map(first.into_iter().take(LOOKED), |(effect, model)| {
        (effect, fit(&channels[worst], &model))
    });
    looked.retain(|(_, model)| plain_cost(&channels[worst], model) < PART * cost);
    let mut fitted: Vec<(f64, Candidate)> = looked
        .into_iter()
        .map(|(effect, lent)| {
            let models = parallel::map(channels.iter(), |data| fit(data, &lent));
            let acts = vec![true; channels.len()];
            let look = Candidate { effect, models, acts, losses: Vec::new() };
            // Only judged here: the weights that go with a model that is no description would lead
            // a fit astray.
            let candidate = refit_further(channels, stages, &look, 0);
            (together(channels, &candidate.losses, &OPEN).iter().sum(), candidate)
        })
        .collect();
    ascending(&mut fitted, |item| item.0);
    fitted.into_iter().map(|(_, candidate)| candidate).collect()
}

/// The best start of every effect on a channel, best first, with a valve of each of seven gains and
/// the `valves` of channels that are described well.
fn first_looks(data: &ChannelData, valves: &[&Extended], asked: Asked<'_>) -> Vec<(usize, Extended)> {
    let of_gain = |gain: &f64| with_usual(data, &start(data, *gain, EDGE));
    let bases: Vec<Extended> = GAINS.iter().map(of_gain).chain(valves.iter().map(|&v| v.clone())).collect();
    let may_be =
        |&effect: &usize| asked.is_about(data, effect) && CATALOGUE[effect].question == Question::Structure;
    let looked = parallel::map((0..CATALOGUE.len()).filter(may_be), |effect| {
        let probes = CATALOGUE[effect].probes.iter();
        let starts: Vec<Extended> =
            probes.flat_map(|probe| bases.iter().map(|base| base.with(&data.plant, effect, probe))).collect();
        let costs = plain_costs(data, &starts).into_iter().zip(starts);
        let costs = costs.map(|(cost, model)| (cost, effect, model));
        costs.filter(|(cost, ..)| cost.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0))
    });
    let mut best: Vec<(f64, usize, Extended)> = looked.into_iter().flatten().collect();
    ascending(&mut best, |item| item.0);
    best.into_iter().map(|(_, effect, model)| (effect, model)).collect()
}

/// Models of every channel with two effects, and base parameters that neither a base model nor one
/// of them alone has led astray. `None` where they leave much of the error of the channel with the
/// largest, on which they are looked for.
#[must_use]
pub fn together_afresh(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    tried: &[Vec<Trial>],
    effects: [usize; 2],
) -> Option<Vec<Extended>> {
    let (worst, cost) = worst(channels, stages)?;
    let lent = two_afresh(&channels[worst], &tried[worst], effects)?;
    (plain_cost(&channels[worst], &lent) < PART_OF_TWO * cost).then(|| {
        parallel::map(
            channels.iter().enumerate(),
            |(k, data)| {
                if k == worst { lent.clone() } else { fit(data, &lent) }
            },
        )
    })
}

/// The channel with the largest error, and its square.
fn worst(channels: &[ChannelData], stages: &[ChannelStage]) -> Option<(usize, f64)> {
    let costs = channels.iter().zip(stages).map(|(data, stage)| plain_cost(data, &stage.model));
    costs.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The best model of a channel with two effects, from all their sizes with a valve of each of seven
/// gains.
fn two_afresh(data: &ChannelData, trials: &[Trial], effects: [usize; 2]) -> Option<Extended> {
    let mut starts: Vec<Extended> =
        GAINS.iter().map(|&gain| with_usual(data, &start(data, gain, EDGE))).collect();
    for effect in effects {
        let sizes = sizes(data, trials, effect);
        let with = |model: &Extended| -> Vec<Extended> {
            sizes.iter().map(|size| model.with(&data.plant, effect, size)).collect()
        };
        starts = starts.iter().flat_map(with).collect();
    }
    let mut ranked: Vec<(f64, Extended)> = plain_costs(data, &starts).into_iter().zip(starts).collect();
    ranked.retain(|(cost, _)| cost.is_finite());
    ascending(&mut ranked, |item| item.0);
    let fitted = parallel::map(ranked.into_iter().take(FOLLOWED), |(_, start)| {
        let model = fit(data, &start);
        (plain_cost(data, &model), model)
    });
    fitted.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, model)| model)
}

/// Sizes at which an effect is tried on a channel: its probes, or where they are found in the
/// recording, what was tried there.
fn sizes(data: &ChannelData, trials: &[Trial], effect: usize) -> Vec<Vec<f64>> {
    let probes = CATALOGUE[effect].probes;
    if !probes.is_empty() {
        return probes.iter().map(|probe| probe.to_vec()).collect();
    }
    let of = |trial: &Trial| Some(trial.start.values[trial.start.range(&data.plant, effect)?].to_vec());
    trials.iter().filter(|trial| trial.effect == effect).filter_map(of).collect()
}

/// Base parameters and effects, all free. Of a loop, the error that is left is weighed beside the
/// wander, and where that leads astray the start stays. Where the drive is recorded and a model is
/// far off, the likelihood judges instead: with the same weights this named what is false in the
/// seventh run of the ventilator with a pinch valve, and the likelihood was no longer asked.
fn fit(data: &ChannelData, start: &Extended) -> Extended {
    if !data.inputs.in_loop() {
        let whitening = Whitening::new(data, &data.disturbances(start));
        return refit(data, &whitening, start, &free_of(data, start, false), EVALUATIONS).0;
    }
    let fitted = refit_by_own_weights(data, start, EVALUATIONS).0;
    if plain_cost(data, &fitted) < plain_cost(data, start) { fitted } else { start.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{STRUCTURE, channel};
    use crate::effects::catalogue::index_of;

    /// A loop around a valve with a narrow tube behind it, and a base model as the tube leads it
    /// astray.
    fn behind_a_tube() -> (ChannelData, ChannelStage, Extended) {
        let (mut data, base) = channel(true);
        let tube = index_of("line_restriction").expect("it is in the catalogue");
        let truth = base.with(&data.plant, tube, &[1.3, 0.05, 0.0]);
        data.measured_kpa = data.readings(&truth).into();
        let mut astray = base;
        astray.values[2] *= 10.0;
        let free = free_of(&data, &astray, false);
        let stage = ChannelStage::new(&data, astray, free);
        (data, stage, truth)
    }

    #[test]
    fn a_tube_is_found_with_a_valve_of_its_own() {
        let (data, stage, truth) = behind_a_tube();
        let before = plain_cost(&data, &stage.model);
        let ranked = candidates(std::slice::from_ref(&data), &[stage], STRUCTURE);
        let best = ranked.first().expect("the tube explains nearly everything");
        assert!(best.models[0].has(best.effect) && best.effect == truth.effects[0], "{best:?}");
        let left = plain_cost(&data, &best.models[0]) / before;
        assert!(left < 0.01, "{left} of the squared error is left");
        let gain = best.models[0].values[2] / truth.values[2];
        assert!((0.8..1.25).contains(&gain), "a valve of {gain} times the right gain");
    }

    #[test]
    fn behind_a_tube_the_valve_of_another_channel_is_tried() {
        let (data, stage, truth) = behind_a_tube();
        let best = |valves: &[&Extended]| {
            let (effect, model) = first_looks(&data, valves, STRUCTURE).swap_remove(0);
            (effect, plain_cost(&data, &model) / plain_cost(&data, &stage.model))
        };
        let neighbour = Extended::base(truth.values[..stage.model.values.len()].to_vec());
        let ((tube, near), (_, alone)) = (best(&[&neighbour]), best(&[]));
        assert_eq!(tube, truth.effects[0]);
        assert!(near < 0.7 * alone, "{near} with it, {alone} without");
    }

    #[test]
    fn what_leaves_too_much_is_not_followed() {
        let (mut data, stage, truth) = behind_a_tube();
        // Beside the tube something that no effect of the catalogue does.
        let wave = |row: usize| 40.0 * (0.9 * row as f64).sin();
        data.measured_kpa = data.readings(&truth).iter().enumerate().map(|(k, y)| y + wave(k)).collect();
        let stage = ChannelStage::new(&data, stage.model, stage.free);
        assert!(candidates(&[data], &[stage], STRUCTURE).is_empty());
    }

    #[test]
    fn two_effects_are_found_with_a_valve_of_their_own_or_not_followed() {
        let (mut data, stage, behind) = behind_a_tube();
        let [lag, saturation] = ["sensor_lag", "drive_saturation"].map(|id| index_of(id).unwrap());
        let truth = behind.with(&data.plant, lag, &[0.05]);
        data.measured_kpa = data.readings(&truth).into();
        let stage = ChannelStage::new(&data, stage.model, stage.free);
        let before = plain_cost(&data, &stage.model);
        let (channels, stages) = ([data], [stage]);
        let found = |other| together_afresh(&channels, &stages, &[Vec::new()], [behind.effects[0], other]);
        let both = found(lag).expect("they explain nearly everything").swap_remove(0);
        let left = plain_cost(&channels[0], &both) / before;
        assert!(left < 0.01, "{left} of the squared error is left");
        let range = both.range(&channels[0].plant, lag).unwrap();
        assert!((0.04..0.06).contains(&both.values[range.start]), "{both:?}");
        // Without the lag no valve comes near.
        let without = found(saturation).map(|models| plain_cost(&channels[0], &models[0]) / before);
        assert!(without.is_none_or(|part| part > 0.05), "{without:?}");
    }
}
