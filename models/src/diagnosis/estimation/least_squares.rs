//! Fitting a channel's model on its fit blocks.

use std::sync::atomic::AtomicBool;

use super::frozen_jacobian::refit_renewing;
use super::objective::BlockObjective;
use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::likelihood::{Whitening, hunts};
use crate::fit::{Objective, Stopping, minimise};

/// Evaluations between two sets of secants, which cost as many simulations as there are parameters
/// and hold over a distance.
const BETWEEN_SECANTS: usize = 4;

/// Fits the free parameters from where the model stands. Returns the model and the evaluations
/// spent.
#[must_use]
pub fn refit(
    data: &ChannelData,
    whitening: &Whitening,
    model: &Extended,
    free: &[usize],
    evaluations: usize,
) -> (Extended, usize) {
    if hunts(data, model) {
        let sets = evaluations.div_ceil(BETWEEN_SECANTS);
        return (refit_renewing(data, whitening, model, free, (BETWEEN_SECANTS, sets)), evaluations);
    }
    let objective =
        BlockObjective { data, whitening, model: model.clone(), free: free.to_vec(), roles: &[Role::Fit] };
    let stopping = Stopping { evaluations, cost_tolerance: 1e-4, gradient_tolerance: 1e-6 };
    let start = objective.nominal();
    let minimum = minimise(&objective, &objective.bounds(), &start, &stopping, &AtomicBool::new(false));
    (objective.model_at(&minimum.coordinates), minimum.evaluations)
}
