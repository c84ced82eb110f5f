//! Which sizes of what makes a loop hunt are as likely as the one that was fitted.

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::deviances;
use crate::diagnosis::likelihood::limit_cycle::is_hunting;

/// Pairs of courses from which the scatter of a [deviance](Losses::deviance) is estimated, and how
/// many standard deviations of it are put down to luck.
const LUCKY: u64 = 4;
const LUCK: f64 = 2.0;
/// Values of a parameter that are looked at on either side for its interval: how many, and their
/// ratio.
const LIKELY_STEPS: i32 = 5;
const LIKELY_STEP: f64 = 1.05;

/// The most [deviance](Losses::deviance) on the blocks for fitting that a model of an equally
/// likely size may have: `rise` above the mean over courses of the noise, and what another course
/// adds by luck.
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

/// Distances below and above, in the parameter's unit, up to which a model has hardly more deviance
/// than where it stands. `None` where the loop does not hunt because of this effect.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;
    use crate::effects::catalogue::{CATALOGUE, index_of};

    fn sticking(data: &ChannelData, base: &Extended, threshold: f64) -> Extended {
        base.with(&data.plant, index_of("valve_stiction").unwrap(), &[threshold])
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

    /// The same size with another course of the noise must not look less likely than where it was
    /// fitted.
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
