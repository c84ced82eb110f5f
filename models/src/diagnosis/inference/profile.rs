//! The cost along one parameter, everything else refitted.

use crate::diagnosis::channel::{ChannelData, Role};
use crate::diagnosis::estimation::{BlockObjective, ChannelStage, refit_with};
use crate::diagnosis::likelihood::{block_losses, total};
use crate::fit::Objective;

/// First step away from an estimate that has no standard error, as a part of its bounds' distance.
const FIRST_STEP: f64 = 0.002;
/// Points at which one side of a profile is evaluated at most.
const POINTS: usize = 6;
/// Simulations for a point.
const FOLLOW: usize = 4;
/// Nearness of a point to the wanted rise that ends the search, as a part of its root.
const NEAR: f64 = 0.1;

/// The cost of the fit blocks along one parameter.
pub struct Profile<'a> {
    objective: BlockObjective<'a>,
    /// Whitened derivatives at the optimum, kPa, row by row.
    derivatives: Vec<f64>,
    start: Vec<f64>,
    bounds: Vec<(f64, f64)>,
    least: f64,
}

impl<'a> Profile<'a> {
    #[must_use]
    pub fn new(data: &'a ChannelData, stage: &'a ChannelStage) -> Self {
        let objective = BlockObjective {
            data,
            whitening: &stage.whitening,
            model: stage.model.clone(),
            free: stage.free.clone(),
            roles: &[Role::Fit],
        };
        let (start, bounds) = (objective.nominal(), objective.bounds());
        let derivatives = stage.sensitivities.iter().map(|s| s * data.noise_kpa).collect();
        let least = total(data, &block_losses(data, &stage.residuals), &[Role::Fit]);
        Self { objective, derivatives, start, bounds, least }
    }

    /// Distances below and above at which the cost has risen by `rise`; infinite where a bound
    /// comes first. `stride` is where they are expected, zero where nothing is known.
    #[must_use]
    pub fn ends(&self, k: usize, stride: f64, rise: f64) -> [f64; 2] {
        [-1.0, 1.0].map(|sign| self.end(k, sign, stride, rise))
    }

    fn end(&self, k: usize, sign: f64, stride: f64, rise: f64) -> f64 {
        let (low, high) = self.bounds[k];
        let wall = if sign > 0.0 { high - self.start[k] } else { self.start[k] - low };
        let data = self.objective.data;
        let n = self.objective.free.len();
        let mut others = self.objective.free.clone();
        let position = others.remove(k);
        let derivatives: Vec<f64> = self
            .derivatives
            .iter()
            .enumerate()
            .filter(|(index, _)| index % n != k)
            .map(|(_, derivative)| *derivative)
            .collect();
        let mut warm = self.objective.model.clone();
        let mut root = |distance: f64| {
            let mut at = self.start.clone();
            at[k] += sign * distance;
            let moved = self.objective.model_at(&at).values[position];
            warm.values[position] = moved;
            let objective = BlockObjective {
                data,
                whitening: self.objective.whitening,
                model: warm.clone(),
                free: others.clone(),
                roles: self.objective.roles,
            };
            let (model, cost) = refit_with(&objective, &derivatives, FOLLOW);
            warm = model;
            (cost / (data.noise_kpa * data.noise_kpa) - self.least).max(0.0).sqrt()
        };
        let target = rise.sqrt();
        let mut next = if stride > 0.0 { stride } else { FIRST_STEP * (high - low) };
        let (mut inside, mut outside) = ((0.0, 0.0), None);
        for _ in 0..POINTS {
            next = next.min(wall);
            let reached = root(next);
            if (reached / target - 1.0).abs() < NEAR {
                return next * target / reached;
            }
            if reached < target {
                inside = (next, reached);
                if next >= wall {
                    return f64::INFINITY;
                }
            } else {
                outside = Some((next, reached));
            }
            next = match outside {
                None => next * (target / reached.max(1e-12)).clamp(1.2, 5.0),
                Some((far, top)) => {
                    let share = (target - inside.1) / (top - inside.1);
                    inside.0 + share.clamp(0.1, 0.9) * (far - inside.0)
                }
            };
        }
        next
    }
}
