//! Several models of a channel simulated side by side.
//!
//! One simulation waits most of the time: each step needs what the one before left. Models with the
//! same effects take the same instructions, so a vector of them is done in little more time than
//! one.

use super::data::ChannelData;
use super::model::Extended;
use crate::effects::Undisturbed;
use crate::numeric::Lanes;
use crate::parallel;

/// Models in one simulation.
const LANES: usize = 4;
/// A vector takes as long as this many models one by one.
const WORTH: usize = 2;

/// Readings of models, as [`ChannelData::readings`] has them, in their order.
#[must_use]
pub fn readings_of(data: &ChannelData, models: &[Extended]) -> Vec<Vec<f64>> {
    let alike = |part: &[Extended]| {
        part.iter().all(|model| model.effects == part[0].effects && model.correction.is_none())
    };
    let parts = parallel::map(models.chunks(LANES), |part| {
        if part.len() < WORTH || !alike(part) {
            parallel::map(part.iter(), |model| data.readings(model))
        } else {
            side_by_side(data, part)
        }
    });
    parts.into_iter().flatten().collect()
}

/// Readings of one to [`LANES`] models with the same effects.
fn side_by_side(data: &ChannelData, models: &[Extended]) -> Vec<Vec<f64>> {
    // Lanes that are not needed repeat the last one.
    let values = |k: usize| &models[k.min(models.len() - 1)].values;
    let together: Vec<Lanes<LANES>> =
        (0..values(0).len()).map(|p| Lanes(std::array::from_fn(|k| values(k)[p]))).collect();
    let run = data.run(&models[0], &together, &Undisturbed);
    (0..models.len()).map(|k| run.iter().map(|reading| reading.0[k]).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, channel_of};
    use crate::effects::Domain;
    use crate::effects::catalogue::CATALOGUE;
    use crate::model::Scale;

    /// The base model with an effect at some sizes, its other parameters away from where it is
    /// nothing.
    fn sizes(data: &ChannelData, base: &Extended, effect: usize, count: usize) -> Vec<Extended> {
        let between = |low: f64, high: f64, scale: Scale, part: f64| match scale {
            Scale::Linear => low + part * (high - low),
            Scale::Logarithmic => low * (high / low).powf(part),
        };
        let model = |k: usize| {
            let part = 0.1 + 0.25 * k as f64 / count as f64;
            let values: Vec<f64> = CATALOGUE[effect]
                .parameters
                .iter()
                .map(|p| between(p.lower, p.upper, p.scale, part))
                .collect();
            base.with(&data.plant, effect, &values)
        };
        (0..count).map(model).collect()
    }

    /// Vectors must change nothing but the time it takes.
    #[test]
    fn side_by_side_every_effect_does_what_it_does_alone() {
        for in_loop in [false, true] {
            let (data, base) = channel_of(600, in_loop);
            for effect in 0..CATALOGUE.len() {
                let info = CATALOGUE[effect];
                if info.domain == Domain::Regulator {
                    continue;
                }
                for count in [2, LANES + 3] {
                    let models = sizes(&data, &base, effect, count);
                    let together = readings_of(&data, &models);
                    assert_eq!(together.len(), count);
                    for (k, model) in models.iter().enumerate() {
                        let alone = data.readings(model);
                        let same = alone.iter().zip(&together[k]).all(|(a, b)| a.to_bits() == b.to_bits());
                        assert!(same, "{} number {k} of {count}, in a loop: {in_loop}", info.id);
                    }
                    assert!(together[0] != together[count - 1], "{} does nothing", info.id);
                }
            }
        }
    }

    #[test]
    fn models_with_different_effects_are_not_mixed_up() {
        let (data, base) = channel(false);
        let models: Vec<Extended> = (0..4).flat_map(|effect| sizes(&data, &base, effect, 1)).collect();
        let together = readings_of(&data, &models);
        for (model, readings) in models.iter().zip(&together) {
            assert_eq!(&data.readings(model), readings);
        }
    }
}
