//! The cost along one parameter, everything else refitted.

use crate::diagnosis::channel::{ChannelData, Role};
use crate::diagnosis::estimation::{BlockObjective, ChannelStage, refit_with};
use crate::diagnosis::likelihood::{block_losses, total};
use crate::fit::Objective;
use crate::parallel;

/// First step away from an estimate that has no standard error, as a part of its bounds' distance.
const FIRST_STEP: f64 = 0.002;
/// Points at which one side of a profile is evaluated at most.
const POINTS: usize = 6;
/// Simulations for a point.
const FOLLOW: usize = 4;
/// The same of a parameter whose cost has steps: six times the distance between what is as likely
/// and what is not is halved.
const POINTS_OF_STEPS: usize = 10;
/// Nearness of a point to the wanted rise that ends the search, as a part of its root.
const NEAR: f64 = 0.1;

/// The root of the cost's rise as a function of the distance.
type Root<'a> = dyn FnMut(f64) -> f64 + 'a;

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
    /// comes first. `stride` is where they are expected.
    #[must_use]
    pub fn ends(&self, k: usize, stride: f64, rise: f64) -> [f64; 2] {
        self.both(k, |root, wall| smooth_end(root, wall, stride, rise.sqrt()))
    }

    /// The same where the cost has steps, as that of a threshold has between two drives.
    #[must_use]
    pub fn ends_of_steps(&self, k: usize, rise: f64) -> [f64; 2] {
        let (low, high) = self.bounds[k];
        self.both(k, |root, wall| end_of_steps(root, wall, FIRST_STEP * (high - low), rise.sqrt()))
    }

    /// The ends on both sides, side by side, from the root of the rise and the distance of the
    /// bound.
    fn both(&self, k: usize, end: impl Fn(&mut Root<'_>, f64) -> f64 + Sync) -> [f64; 2] {
        let sides = parallel::map([-1.0, 1.0], |sign| end(&mut self.side(k, sign), self.wall(k, sign)));
        [sides[0], sides[1]]
    }

    /// Distance of a parameter's bound.
    fn wall(&self, k: usize, sign: f64) -> f64 {
        let (low, high) = self.bounds[k];
        if sign > 0.0 { high - self.start[k] } else { self.start[k] - low }
    }

    /// The root of the cost's rise at a distance on one side.
    fn side(&self, k: usize, sign: f64) -> impl FnMut(f64) -> f64 {
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
        move |distance: f64| {
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
        }
    }
}

/// Where the root of a smooth cost's rise reaches the `target`; infinite where the wall comes
/// first.
fn smooth_end(root: &mut Root<'_>, wall: f64, stride: f64, target: f64) -> f64 {
    let mut next = stride;
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

/// Where the root of a rise in steps passes the `target`, rather too far out than too near;
/// infinite where the wall comes first. How high it is on either side of a step says nothing about
/// where the step is.
fn end_of_steps(root: &mut Root<'_>, wall: f64, first: f64, target: f64) -> f64 {
    let (mut inside, mut outside, mut next) = (0.0, None, first);
    for _ in 0..POINTS_OF_STEPS {
        next = f64::min(next, wall);
        if root(next) >= target {
            outside = Some(next);
        } else if next >= wall {
            return f64::INFINITY;
        } else {
            inside = next;
        }
        next = outside.map_or(3.0 * next, |far| 0.5 * (inside + far));
    }
    outside.unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_parabola_and_of_a_step_are_found_and_a_bound_is_none() {
        let parabola = |wall: f64| smooth_end(&mut |x| 2.0 * x, wall, 0.3, 2.0);
        assert!((parabola(10.0) - 1.0).abs() < 1e-9, "{}", parabola(10.0));
        assert!(parabola(0.8).is_infinite());
        // Nothing up to the step, and then far more than is asked for.
        let step = |wall: f64| end_of_steps(&mut |x| if x < 0.0145 { 0.0 } else { 40.0 }, wall, 0.001, 2.0);
        assert!((0.0145..0.0149).contains(&step(0.4)), "{}", step(0.4));
        assert!(step(0.014).is_infinite());
    }
}
