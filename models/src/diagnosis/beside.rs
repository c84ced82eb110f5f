//! Several models of a channel simulated side by side.
//!
//! One simulation waits most of the time: each step needs what the one before left. Models with the same effects take the same
//! instructions, so a vector of them is done in little more time than one.

use rayon::prelude::*;

use super::channel::{ChannelData, Extended};
use crate::effects::Undisturbed;
use crate::numeric::Lanes;

/// Models in one simulation.
const LANES: usize = 8;
/// A vector takes as long as this many models one by one.
const WORTH: usize = 3;

/// Readings of models, as [`ChannelData::readings`] has them, in their order.
#[must_use]
pub fn readings_of(data: &ChannelData, models: &[Extended]) -> Vec<Vec<f64>> {
    let alike = |part: &[Extended]| {
        part.iter().all(|model| model.effects == part[0].effects && model.correction.is_none())
    };
    let parts = models.par_chunks(LANES).map(|part| {
        if part.len() < WORTH || !alike(part) {
            part.par_iter().map(|model| data.readings(model)).collect()
        } else {
            side_by_side(data, part)
        }
    });
    parts.collect::<Vec<Vec<Vec<f64>>>>().into_iter().flatten().collect()
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
