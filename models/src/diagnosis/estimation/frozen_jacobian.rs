//! Refits near an optimum, where derivatives hardly change: the residuals are simulated at every
//! step, their derivatives only at the start (the chord method; Ortega and Rheinboldt, Iterative
//! Solution of Nonlinear Equations, 1970, section 7.1).
//!
//! A simulation with derivatives takes several times as long as one without. Steps that do not make
//! the cost less are taken back as everywhere, so frozen derivatives that do not fit cost progress
//! and nothing else.

use std::sync::atomic::AtomicBool;

use nalgebra::DVector;

use super::objective::{BlockObjective, Derivatives, normal_equations};
use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::likelihood::Whitening;
use crate::fit::{Minimum, Normal, Objective, Stopping, minimise};

/// Relative decrease of the cost that ends a refit: a hundredth of what an interval's end is away,
/// of 10,000 residuals.
const COST_TOLERANCE: f64 = 1e-5;

/// An objective with the derivatives of one place.
struct Frozen<'a> {
    objective: &'a BlockObjective<'a>,
    /// Whitened derivatives of the readings by the free parameters, kPa, row by row.
    derivatives: &'a [f64],
    /// Whitened residuals (simulated minus measured) of the model where they were taken, kPa, if
    /// that is where a fit starts.
    at_start: Option<&'a [f64]>,
}

impl Frozen<'_> {
    /// Where the objective's model stands, with its residuals, if they are known.
    fn known(&self, coordinates: &[f64]) -> Option<&[f64]> {
        self.at_start.filter(|_| self.objective.nominal() == coordinates)
    }
}

impl Objective for Frozen<'_> {
    fn dimension(&self) -> usize {
        self.objective.free.len()
    }

    fn bounds(&self) -> Vec<(f64, f64)> {
        self.objective.bounds()
    }

    fn nominal(&self) -> Vec<f64> {
        self.objective.nominal()
    }

    fn normal(&self, coordinates: &[f64]) -> Normal {
        let objective = self.objective;
        let normal = |r: &[f64]| {
            normal_equations(objective.data, objective.roles, r, self.derivatives, objective.free.len())
        };
        if let Some(known) = self.known(coordinates) {
            return normal(known);
        }
        let mut r = objective.whitened(&objective.model_at(coordinates));
        r.iter_mut().for_each(|v| *v = -*v);
        normal(&r)
    }

    fn last(&self, coordinates: &[f64]) -> Normal {
        self.objective.last(coordinates)
    }

    fn residuals(&self) -> usize {
        self.objective.residuals()
    }

    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64)) {
        self.objective.scores(coordinates, sink);
    }
}

/// Moves the free parameters of an objective from where its model stands, with at most so many
/// simulations, by whitened derivatives (kPa, row by row). Returns the model and its cost in kPa^2.
#[must_use]
pub fn refit_with(
    objective: &BlockObjective<'_>,
    derivatives: &[f64],
    simulations: usize,
) -> (Extended, f64) {
    refit_frozen(&Frozen { objective, derivatives, at_start: None }, simulations)
}

fn refit_frozen(frozen: &Frozen<'_>, simulations: usize) -> (Extended, f64) {
    let objective = frozen.objective;
    let stopping =
        Stopping { evaluations: simulations, cost_tolerance: COST_TOLERANCE, gradient_tolerance: 1e-6 };
    let start = objective.nominal();
    let Minimum { coordinates, normal, .. } =
        minimise(frozen, &objective.bounds(), &start, &stopping, &AtomicBool::new(false));
    (objective.model_at(&coordinates), normal.cost)
}

/// Evaluations between two sets of derivatives, the one where they are taken included.
const SIMULATIONS: usize = 5;
/// Sets of derivatives at most.
const RENEWALS: usize = 6;
/// Relative decrease of the cost for which the derivatives are worth renewing.
const WORTHWHILE: f64 = 1e-3;

/// Refits on the fit blocks from a model that is nearly there, renewing the derivatives as long as
/// that gains something (Shamanskii's method, Ukrainskii Matematicheskii Zhurnal 19, 1967).
#[must_use]
pub fn refit_near(data: &ChannelData, whitening: &Whitening, model: &Extended, free: &[usize]) -> Extended {
    refit_renewing(data, whitening, model, free, (SIMULATIONS, RENEWALS))
}

/// The same with so many evaluations between two sets of derivatives, and so many sets at most.
#[must_use]
pub fn refit_renewing(
    data: &ChannelData,
    whitening: &Whitening,
    model: &Extended,
    free: &[usize],
    (simulations, renewals): (usize, usize),
) -> Extended {
    if free.is_empty() {
        return model.clone();
    }
    let mut objective =
        BlockObjective { data, whitening, model: model.clone(), free: free.to_vec(), roles: &[Role::Fit] };
    for _ in 0..renewals {
        let Derivatives { matrix, residuals, cost: before } = objective.derivatives();
        let frozen = Frozen { objective: &objective, derivatives: &matrix, at_start: Some(&residuals) };
        let (next, cost) = refit_frozen(&frozen, simulations);
        objective.model = next;
        if cost > before * (1.0 - WORTHWHILE) {
            break;
        }
    }
    objective.model
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, measured};

    #[test]
    fn derivatives_of_the_start_lead_near_the_minimum() {
        let (data, base) = channel(false);
        let data = measured(data, &base, 1);
        let whitening = Whitening::new(&data, &data.disturbances(&base));
        let gain = data.plant.position("gain").expect("a valve has one");
        let mut start = base.clone();
        start.values[gain] *= 1.05;
        let best = refit_renewing(&data, &whitening, &start, &[gain], (10, 10));
        let off = |evaluations: usize| {
            let found = refit_renewing(&data, &whitening, &start, &[gain], (evaluations, 1));
            (found.values[gain] / best.values[gain] - 1.0).abs()
        };
        // Every step goes on from where the one before has led.
        assert!(off(2) < 0.1 * off(1) && off(3) < 0.1 * off(2), "{:?}", [1, 2, 3].map(off));
        // One evaluation is the start itself.
        assert!((off(1) / 0.05 - 1.0).abs() < 0.1, "{}", off(1));
    }
}
