//! A loop that hunts.
//!
//! A loop around a spool with friction or play never rests, and two simulations that differ by next to nothing soon hunt out of
//! step. Nobody recorded the noise that the loop saw between the rows, so no simulation hunts in step with the recording either. How
//! far two of them are apart that differ in this noise alone is what a model may leave without being any worse for it.

use super::beside::readings_of;
use super::blocks::Role;
use super::channel::{ChannelData, Extended};
use super::losses::{Losses, total};
use super::stage::{ChannelStage, whitened_residuals};
use super::whiten::Whitening;
use crate::effects::catalogue::CATALOGUE;

/// Effects with which a board's loop hunts.
const HUNTING: [&str; 2] = ["valve_hysteresis", "valve_stiction"];
/// Courses of the noise over which a mean is taken.
const EXPECTED: u64 = 8;
/// Pairs of courses from which the scatter of a [deviance](Losses::deviance) is estimated, and how many standard deviations of it are put
/// down to luck.
const LUCKY: u64 = 4;
const LUCK: f64 = 2.0;
/// Values of a parameter that are looked at on either side for its interval: how many, and their ratio.
const LIKELY_STEPS: i32 = 5;
const LIKELY_STEP: f64 = 1.05;

/// Does a board's loop hunt with this effect?
#[must_use]
pub fn is_hunting(effect: usize) -> bool {
    HUNTING.contains(&CATALOGUE[effect].id)
}

/// Does the loop of this model hunt?
#[must_use]
pub fn hunts(data: &ChannelData, model: &Extended) -> bool {
    data.inputs.in_loop() && model.effects.iter().any(|&e| is_hunting(e))
}

/// The model without what makes a board's loop hunt.
#[must_use]
pub fn at_rest(data: &ChannelData, model: &Extended) -> Extended {
    if !hunts(data, model) {
        return model.clone();
    }
    let hunting = model.effects.iter().copied().filter(|&effect| is_hunting(effect));
    hunting.fold(model.clone(), |model, effect| model.without(&data.plant, effect))
}

/// What a reader of the report should know where a loop hunts.
#[must_use]
pub fn note(channels: &[ChannelData], models: &[Extended]) -> Option<String> {
    channels.iter().zip(models).any(|(data, model)| hunts(data, model)).then(|| {
        format!(
            "The loop hunts around the spool's play or friction, and no simulation hunts in step with it: the error with that cause is the one of the mean of {EXPECTED} simulations, each with a noise of its own."
        )
    })
}

/// The channel with another course of the noise.
#[must_use]
pub fn otherwise(data: &ChannelData) -> ChannelData {
    let mut other = data.clone();
    if let Some(board) = &mut other.plant.board {
        board.noise_draw += 1;
    }
    other
}

/// [Deviances](Losses::deviance) of models on the blocks for fitting.
fn deviances(data: &ChannelData, whitening: &Whitening, models: &[Extended]) -> Vec<f64> {
    let readings = readings_of(data, models);
    let residuals: Vec<_> = readings.iter().map(|y| whitened_residuals(data, whitening, y)).collect();
    let losses = Losses::of(data, whitening, models, &residuals);
    losses.iter().map(|losses| total(data, &losses.deviance, &[Role::Fit])).collect()
}

/// The one of two models that has less [deviance](Losses::deviance) on the blocks for fitting, behind that. A fit of the squared error
/// prefers a model that hunts less than the recording.
#[must_use]
pub fn likelier(data: &ChannelData, whitening: &Whitening, models: [Extended; 2]) -> (f64, Extended) {
    let deviances = deviances(data, whitening, &models);
    let [one, other] = models;
    if deviances[1] < deviances[0] { (deviances[1], other) } else { (deviances[0], one) }
}

/// The most [deviance](Losses::deviance) on the blocks for fitting that a model of an equally likely size may have: `rise` above the mean
/// over courses of the noise, and what another course adds by luck.
fn most_deviance(data: &ChannelData, stage: &ChannelStage, rise: f64) -> f64 {
    let mut other = data.clone();
    let mut deviance = |pair: u64| {
        if let Some(board) = &mut other.plant.board {
            board.noise_draw = 2 * pair;
        }
        deviances(&other, &stage.whitening, std::slice::from_ref(&stage.model))[0]
    };
    let all: Vec<f64> = (0..LUCKY).map(&mut deviance).collect();
    let mean = all.iter().sum::<f64>() / LUCKY as f64;
    let variance = all.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (LUCKY as f64 - 1.0);
    mean + rise + LUCK * variance.sqrt()
}

/// Distances below and above, in the parameter's unit, up to which a model has hardly more deviance than where it stands. `None` where
/// the loop does not hunt because of this effect.
#[must_use]
pub fn as_likely(
    data: &ChannelData,
    stage: &ChannelStage,
    effect: usize,
    position: usize,
    rise: f64,
) -> Option<[f64; 2]> {
    if !data.inputs.in_loop() || !is_hunting(effect) {
        return None;
    }
    let value = stage.model.values[position];
    let upper = stage.model.parameters(&data.plant)[position].upper;
    let most = most_deviance(data, stage, rise);
    Some([-1, 1].map(|sign| {
        let to = |k: i32| (value * LIKELY_STEP.powi(sign * k)).min(upper);
        let at = |k: i32| {
            let mut model = stage.model.clone();
            model.values[position] = to(k);
            model
        };
        let models: Vec<Extended> = (1..=LIKELY_STEPS).map(at).collect();
        let deviances = deviances(data, &stage.whitening, &models);
        let likely = (1..=LIKELY_STEPS).zip(deviances).filter(|(_, deviance)| *deviance < most);
        likely.map(|(k, _)| (to(k) - value).abs()).fold(0.0, f64::max)
    }))
}

/// Readings as they are expected: of a loop that hunts, the mean over some courses of the noise.
#[must_use]
pub fn expected_readings(data: &ChannelData, model: &Extended) -> Vec<f64> {
    let mut sum = data.readings(model);
    if hunts(data, model) {
        let mut other = data.clone();
        for draw in 1..EXPECTED {
            if let Some(board) = &mut other.plant.board {
                board.noise_draw = draw;
            }
            sum.iter_mut().zip(other.readings(model)).for_each(|(sum, y)| *sum += y);
        }
        sum.iter_mut().for_each(|sum| *sum /= EXPECTED as f64);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::testing::channel;
    use super::*;
    use crate::effects::catalogue::index_of;

    fn sticking(data: &ChannelData, base: &Extended, threshold: f64) -> Extended {
        base.with(&data.plant, index_of("valve_stiction").unwrap(), &[threshold])
    }

    #[test]
    fn only_a_loop_hunts_and_only_around_friction_or_play() {
        let ((looped, base), (driven, _)) = (channel(true), channel(false));
        let sticks = sticking(&looped, &base, 0.05);
        assert!(hunts(&looped, &sticks) && !hunts(&driven, &sticks) && !hunts(&looped, &base));
        assert_eq!(at_rest(&looped, &sticks), base);
        assert_eq!(at_rest(&driven, &sticks), sticks);
    }

    /// Derivatives along a loop that hunts grow without bound; weights made of them would shrink everything.
    #[test]
    fn weights_of_a_loop_that_hunts_are_those_of_the_loop_at_rest() {
        let (data, base) = channel(true);
        assert_eq!(data.disturbances(&sticking(&data, &base, 0.05)), data.disturbances(&base));
    }

    #[test]
    fn a_size_is_not_called_likely_beyond_its_bounds() {
        let (mut data, base) = channel(true);
        let effect = index_of("valve_stiction").unwrap();
        let upper = CATALOGUE[effect].parameters[0].upper;
        let model = sticking(&data, &base, upper);
        data.measured_kpa = data.readings(&model).into();
        let position = base.values.len();
        let stage = ChannelStage::new(&data, model, vec![position]);
        let likely = as_likely(&data, &stage, effect, position, f64::INFINITY);
        let lowest = upper * (1.0 - LIKELY_STEP.powi(-LIKELY_STEPS));
        assert!(
            likely.is_some_and(|[below, above]| (below - lowest).abs() < 1e-12 && above == 0.0),
            "{likely:?}"
        );
        assert_eq!(as_likely(&data, &stage, index_of("valve_lag").unwrap(), position, 1.0), None);
    }

    /// The same size with another course of the noise must not look less likely than where it was fitted.
    #[test]
    fn what_another_course_of_the_noise_adds_is_luck() {
        let (mut data, base) = channel(true);
        let model = sticking(&data, &base, 0.05);
        data.measured_kpa = data.readings(&model).into();
        let stage = ChannelStage::new(&data, model, vec![base.values.len()]);
        let with_course = |draw: u64| {
            let mut other = data.clone();
            other.plant.board.as_mut().unwrap().noise_draw = draw;
            deviances(&other, &stage.whitening, std::slice::from_ref(&stage.model))[0]
        };
        let all = [0, 2, 4, 6].map(with_course);
        let worst = all.iter().copied().fold(0.0, f64::max);
        let mean = all.iter().sum::<f64>() / 4.0;
        assert!(worst > mean + 1.0, "the courses do not differ: {all:?}");
        assert!(most_deviance(&data, &stage, 0.0) > worst, "{all:?}");
        assert!((most_deviance(&data, &stage, 7.0) - most_deviance(&data, &stage, 0.0) - 7.0).abs() < 1e-6);
    }
}
