//! How well the recording determines an effect's parameters.
//!
//! Standard errors come from the block sandwich `H^-1 (sum s_b s_b^T) H^-1` of the scores `s_b` of whole blocks (valid however the
//! residual is correlated within a block). The interval's ends are those of the profile likelihood: each parameter is moved, the others
//! refitted, until the cost has risen by what belongs to the standard error on a parabola. Where the cost is a parabola nothing
//! changes; where it is lopsided, has a threshold without derivative, or ends at a bound, the interval shows it.
//!
//! A step of the integration moves the estimate too, on all channels alike. What half of it changes in the readings, projected on the
//! parameters, is half of what is left of a first-order error and a third of a second-order one: both ends give way by twice that.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::blocks::Role;
use super::channel::ChannelData;
use super::chord::refit_with;
use super::fit::BlockObjective;
use super::hunting::as_likely;
use super::losses::total;
use super::prepare::halved;
use super::stage::{ChannelStage, block_losses};
use crate::fit::Objective;
use crate::model::Scale;

/// First step away from an estimate that has no standard error, as a part of its bounds' distance.
const FIRST_STEP: f64 = 0.002;
/// Points at which one side of a profile is evaluated at most.
const POINTS: usize = 6;
/// Simulations for a point.
const FOLLOW: usize = 4;
/// Nearness of a point to the wanted rise that ends the search, as a part of its root.
const NEAR: f64 = 0.1;

/// Reach of an open side among channels of which others close it.
const OPEN_REACH: f64 = 3.0;

/// An estimate on the scale on which the parameter is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Value, or its logarithm.
    pub value: f64,
    /// Standard error; infinite where the data say nothing.
    pub error: f64,
    /// Degrees of freedom of the error.
    pub freedom: f64,
    /// Distance of the interval's ends below and above, over that of a parabola; infinite where a bound comes first.
    pub reach: [f64; 2],
    /// Change of the value when the integration step is halved.
    pub halving: f64,
}

/// Covariances of a channel's free parameters: robust, and of independent residuals of the noise's variance.
struct Covariances {
    robust: DMatrix<f64>,
    naive: DMatrix<f64>,
}

fn covariances(data: &ChannelData, stage: &ChannelStage) -> Option<Covariances> {
    let n = stage.free.len();
    let mut bread = DMatrix::<f64>::zeros(n, n);
    let mut meat = DMatrix::<f64>::zeros(n, n);
    let fitted = data.blocks.iter().zip(&data.spans).filter(|(b, _)| b.role == Role::Fit);
    let mut blocks = 0.0_f64;
    for (_, span) in fitted {
        blocks += 1.0;
        let mut score = DVector::<f64>::zeros(n);
        for row in span.clone() {
            let s = &stage.sensitivities[row * n..(row + 1) * n];
            for a in 0..n {
                for b in 0..n {
                    bread[(a, b)] += s[a] * s[b];
                }
                score[a] += s[a] * stage.residuals[row];
            }
        }
        meat += &score * score.transpose();
    }
    // A parameter without influence has no slope: leave it out by giving it its own.
    for k in 0..n {
        if bread[(k, k)] <= 0.0 {
            bread[(k, k)] = 1e-30;
        }
    }
    let scale = DVector::from_fn(n, |k, _| bread[(k, k)].sqrt().recip());
    let scaled = DMatrix::from_fn(n, n, |a, b| bread[(a, b)] * scale[a] * scale[b]);
    let inverse = (scaled + DMatrix::identity(n, n) * 1e-10).try_inverse()?;
    let naive = DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] * scale[a] * scale[b]);
    let correction = blocks / (blocks - 1.0).max(1.0);
    Some(Covariances { robust: &naive * meat * &naive * correction, naive })
}

fn quantile(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(2.0, |d| d.inverse_cdf(0.975))
}

/// The parameters of one effect on one channel.
#[must_use]
pub fn coordinates(data: &ChannelData, stage: &ChannelStage, effect: usize) -> Vec<Coordinate> {
    let Some(range) = stage.model.range(&data.plant, effect) else {
        return Vec::new();
    };
    let parameters = stage.model.parameters(&data.plant);
    let covariances = covariances(data, stage);
    let freedom = (data.blocks.iter().filter(|b| b.role == Role::Fit).count() as f64 - 1.0).max(1.0);
    let profile = Profile::new(data, stage);
    let halving = by_halving(data, stage);
    range
        .map(|position| {
            let raw = stage.model.values[position];
            let value = match parameters[position].scale {
                Scale::Linear => raw,
                Scale::Logarithmic => raw.ln(),
            };
            let free = stage.free.iter().position(|&k| k == position);
            let halving = free.map_or(0.0, |k| halving[k]);
            let unknown = Coordinate { value, error: f64::INFINITY, freedom, reach: [1.0; 2], halving };
            let (Some(c), Some(k)) = (&covariances, free) else {
                return unknown;
            };
            let slope = stage.sensitivities.iter().skip(k).step_by(stage.free.len()).any(|s| s.abs() > 0.0);
            let t = quantile(freedom);
            if slope && c.robust[(k, k)] > 0.0 && c.robust[(k, k)].is_finite() {
                let error = c.robust[(k, k)].sqrt();
                let rise = t * t * c.robust[(k, k)] / c.naive[(k, k)];
                let mut reach = profile.ends(k, t * error, rise).map(|end| end / (t * error));
                if let Some(likely) = as_likely(data, stage, effect, position, rise) {
                    for (reach, likely) in reach.iter_mut().zip(likely) {
                        // The squared error of a loop that hunts may fall all the way to less hunting: no end is no end of the size.
                        let profile = if reach.is_finite() { *reach } else { 1.0 };
                        *reach = profile.max(likely / (t * error));
                    }
                }
                return Coordinate { error, reach, ..unknown };
            }
            // A threshold has no derivative; the rise is what the other parameters' errors need on average.
            let ratios: Vec<f64> = (0..stage.free.len())
                .map(|j| c.robust[(j, j)] / c.naive[(j, j)])
                .filter(|r| r.is_finite() && *r > 1e-3)
                .collect();
            let rise = t * t * ratios.iter().sum::<f64>() / (ratios.len() as f64).max(1.0);
            let ends = profile.ends(k, 0.0, rise);
            let error = 0.5 * (ends[0] + ends[1]) / t;
            if error.is_finite() && error > 0.0 {
                Coordinate { error, reach: ends.map(|end| end / (t * error)), ..unknown }
            } else {
                unknown
            }
        })
        .collect()
}

/// What half the integration step changes in the free parameters, to first order.
fn by_halving(data: &ChannelData, stage: &ChannelStage) -> Vec<f64> {
    let mut change = halved(data).readings(&stage.model);
    change.iter_mut().zip(&stage.readings).for_each(|(fine, now)| *fine = (now - *fine) / data.noise_kpa);
    stage.whitening.apply(&mut change);
    stage.project(data, &change)
}

/// The cost of the fit blocks along one parameter.
struct Profile<'a> {
    objective: BlockObjective<'a>,
    /// Whitened derivatives at the optimum, kPa, row by row.
    derivatives: Vec<f64>,
    start: Vec<f64>,
    bounds: Vec<(f64, f64)>,
    least: f64,
}

impl<'a> Profile<'a> {
    fn new(data: &'a ChannelData, stage: &'a ChannelStage) -> Self {
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

    /// Distances below and above at which the cost has risen by `rise`; infinite where a bound comes first. `stride` is where they
    /// are expected, zero where nothing is known.
    fn ends(&self, k: usize, stride: f64, rise: f64) -> [f64; 2] {
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

/// One estimate from those of several channels. Where they differ by more than their errors allow (each valve has a size of its own), the
/// mean is that of a population with a spread (DerSimonian and Laird, Controlled Clinical Trials 7, 1986), so that a channel with a
/// small error does not speak for the others.
#[must_use]
pub fn pool(channels: &[Coordinate]) -> Option<Coordinate> {
    let known: Vec<&Coordinate> = channels.iter().filter(|c| c.error.is_finite()).collect();
    if known.is_empty() {
        return channels.first().copied();
    }
    let count = known.len() as f64;
    let mean_by = |spread: f64| {
        let weights: Vec<f64> = known.iter().map(|c| 1.0 / (c.error * c.error + spread)).collect();
        let total: f64 = weights.iter().sum();
        let value = weights.iter().zip(&known).map(|(w, c)| w * c.value).sum::<f64>() / total;
        (weights, total, value)
    };
    let (weights, total, value) = mean_by(0.0);
    let excess =
        weights.iter().zip(&known).map(|(w, c)| w * (c.value - value).powi(2)).sum::<f64>() - (count - 1.0);
    let scale = total - weights.iter().map(|w| w * w).sum::<f64>() / total;
    let spread = if count > 1.0 && scale > 0.0 { (excess / scale).max(0.0) } else { 0.0 };
    let (weights, total, value) = mean_by(spread);
    // Degrees of freedom of the sum of both variances (Satterthwaite, Biometrics Bulletin 2, 1946): few where the channels' scatter rules.
    let within = known.iter().map(|c| c.freedom).sum::<f64>();
    let errors = known.iter().map(|c| c.error * c.error).sum::<f64>() / count;
    let own = errors / (errors + spread);
    let freedom = 1.0 / (own * own / within + (1.0 - own).powi(2) / (count - 1.0).max(1.0));
    // A side that is open on one channel is closed by the others.
    let reach = [0, 1].map(|side| {
        if known.iter().all(|c| c.reach[side].is_infinite()) {
            return f64::INFINITY;
        }
        weights.iter().zip(&known).map(|(w, c)| w * c.reach[side].min(OPEN_REACH)).sum::<f64>() / total
    });
    let halving = weights.iter().zip(&known).map(|(w, c)| w * c.halving).sum::<f64>() / total;
    Some(Coordinate { value, error: total.sqrt().recip(), freedom, reach, halving })
}

/// The 95 % interval in the parameter's own unit.
#[must_use]
pub fn interval(coordinate: &Coordinate, scale: Scale) -> Option<[f64; 2]> {
    if !coordinate.error.is_finite() {
        return None;
    }
    let half = quantile(coordinate.freedom) * coordinate.error;
    let [below, above] = coordinate.reach.map(|reach| half * reach + 2.0 * coordinate.halving.abs());
    let ends = [coordinate.value - below, coordinate.value + above];
    Some(match scale {
        Scale::Linear => ends,
        Scale::Logarithmic => ends.map(f64::exp),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(value: f64, error: f64, reach: [f64; 2]) -> Coordinate {
        Coordinate { value, error, freedom: 1e6, reach, halving: 0.0 }
    }

    #[test]
    fn what_the_integration_step_leaves_is_part_of_the_interval_and_does_not_average_out() {
        let stepped = |halving| Coordinate { halving, ..coordinate(1.0, 0.1, [1.0; 2]) };
        let pooled = pool(&[stepped(0.05), stepped(0.07)]);
        let Some([low, high]) = pooled.and_then(|p| interval(&p, Scale::Linear)) else {
            panic!("two channels with errors have an interval")
        };
        let half = 0.196 / 2.0_f64.sqrt() + 2.0 * 0.06;
        assert!((low - (1.0 - half)).abs() < 1e-3 && (high - (1.0 + half)).abs() < 1e-3, "{low} {high}");
    }

    #[test]
    fn a_lopsided_profile_makes_a_lopsided_interval() {
        let ends = interval(&coordinate(1.0, 0.1, [1.0, 2.0]), Scale::Linear);
        let [low, high] = ends.unwrap_or_default();
        assert!((low - (1.0 - 0.196)).abs() < 1e-3 && (high - (1.0 + 0.392)).abs() < 1e-3, "{low} {high}");
        let open = interval(&coordinate(1.0, 0.1, [f64::INFINITY, 1.0]), Scale::Logarithmic);
        assert_eq!(open.map(|ends| ends[0]), Some(0.0));
    }

    #[test]
    fn channels_are_weighted_by_precision_and_close_each_others_open_sides() {
        let channels = [coordinate(1.0, 0.1, [1.0, 1.0]), coordinate(1.2, 0.3, [1.0, f64::INFINITY])];
        let pooled = pool(&channels);
        let Some(p) = pooled else { panic!("two channels with errors have a mean") };
        assert!((p.value - 1.02).abs() < 1e-9, "{p:?}");
        assert!((p.error - 0.3 / 10.0_f64.sqrt()).abs() < 1e-9, "{p:?}");
        assert!((p.reach[0] - 1.0).abs() < 1e-12 && (p.reach[1] - 1.2).abs() < 1e-9, "{p:?}");
    }

    #[test]
    fn a_channel_with_a_small_error_does_not_speak_for_channels_that_differ() {
        let mut channels = [1.0, 1.1, 1.2, 1.3].map(|value| coordinate(value, 0.01, [1.0; 2]));
        channels[0].error = 1e-6;
        let Some(p) = pool(&channels) else { panic!("channels with errors have a mean") };
        assert!((p.value - 1.15).abs() < 0.01, "{p:?}");
        // By hand: weights 1e12 and three of 1e4, Q = 1400, spread^2 = (1400 - 3) / 6e4, over the root of four channels.
        assert!((p.error - 0.0763).abs() < 0.0005, "{p:?}");
    }

    #[test]
    fn channels_that_disagree_widen_the_interval() {
        let far = [coordinate(1.0, 0.1, [1.0; 2]), coordinate(2.0, 0.1, [1.0; 2])];
        let near = [coordinate(1.0, 0.1, [1.0; 2]), coordinate(1.1, 0.1, [1.0; 2])];
        let error = |channels: &[Coordinate]| pool(channels).map_or(0.0, |p| p.error);
        assert!((error(&far) - 0.5).abs() < 1e-9);
        // Nearly all of it from two channels' scatter: one degree of freedom.
        assert!(pool(&far).is_some_and(|p| p.freedom < 1.1), "{:?}", pool(&far));
        assert!((error(&near) - 0.1 / 2.0_f64.sqrt()).abs() < 1e-9);
    }
}
