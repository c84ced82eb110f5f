//! What a channel's recording says of its model's parameters.

use std::sync::OnceLock;

use super::considered::considered;
use super::likely_sizes::as_likely;
use super::profile::Profile;
use super::sandwich::{BlockError, Sandwich};
use super::{Coordinate, quantile};
use crate::diagnosis::channel::{ChannelData, halved};
use crate::diagnosis::estimation::ChannelStage;
use crate::parallel;

/// How well a channel's recording determines its model's parameters: the same for all effects, and
/// worked out once one of them asks.
pub struct Determined<'a> {
    data: &'a ChannelData,
    stage: &'a ChannelStage,
    known: OnceLock<Known<'a>>,
}

struct Known<'a> {
    sandwich: Option<Sandwich>,
    profile: Profile<'a>,
    /// What half the integration step changes in the free parameters.
    halving: Vec<f64>,
    /// Variance that what is taken for known adds to each.
    considered: Option<Vec<f64>>,
}

impl<'a> Known<'a> {
    fn new(data: &'a ChannelData, stage: &'a ChannelStage) -> Self {
        let sandwich = Sandwich::new(data, stage);
        let considered = sandwich.as_ref().map(|s| considered(data, stage, s.on_average().0));
        Self { sandwich, profile: Profile::new(data, stage), halving: by_halving(data, stage), considered }
    }
}

impl<'a> Determined<'a> {
    /// Of a channel whose model has been fitted.
    #[must_use]
    pub fn new(data: &'a ChannelData, stage: &'a ChannelStage) -> Self {
        Self { data, stage, known: OnceLock::new() }
    }

    /// The parameters of one effect.
    #[must_use]
    pub fn coordinates(&self, effect: usize) -> Vec<Coordinate> {
        let Self { data, stage, .. } = *self;
        let Some(range) = stage.model.range(&data.plant, effect) else {
            return Vec::new();
        };
        let known = self.known.get_or_init(|| Known::new(data, stage));
        parallel::map(range, |position| self.coordinate(known, effect, position))
    }

    /// The parameter at a position, which is one of an effect's.
    fn coordinate(&self, known: &Known<'_>, effect: usize, position: usize) -> Coordinate {
        let Self { data, stage, .. } = *self;
        let raw = stage.model.values[position];
        let value = stage.model.parameters(&data.plant)[position].scale.coordinate(raw);
        let free = stage.free.iter().position(|&k| k == position);
        let unknown = Coordinate {
            value,
            error: f64::INFINITY,
            by_block: Vec::new(),
            freedom: 1.0,
            reach: [1.0; 2],
            as_likely: [0.0; 2],
            halving: free.map_or(0.0, |k| known.halving[k]),
            considered: 0.0,
        };
        let (Some(sandwich), Some(k)) = (&known.sandwich, free) else {
            return unknown;
        };
        let slope = stage.sensitivities.iter().skip(k).step_by(stage.free.len()).any(|s| s.abs() > 0.0);
        let block = sandwich.error(k);
        if slope && block.variance > 0.0 && block.variance.is_finite() {
            let (error, t) = (block.variance.sqrt(), quantile(block.freedom));
            let rise = t * t * sandwich.ratio(k, &block);
            let mut reach = known.profile.ends(k, t * error, rise).map(|end| end / (t * error));
            let as_likely = as_likely(data, stage, effect, position, rise);
            if as_likely.is_some() {
                // The squared error of a loop that hunts may fall all the way to less hunting: no
                // end is no end of the size.
                reach = reach.map(|end| if end.is_finite() { end } else { 1.0 });
            }
            let as_likely = as_likely.unwrap_or_default();
            let BlockError { by_block, freedom, .. } = block;
            let considered = known.considered.as_ref().map_or(0.0, |variances| variances[k].sqrt());
            return Coordinate { error, by_block, freedom, reach, as_likely, considered, ..unknown };
        }
        // A threshold has no derivative; the rise is what the other parameters' errors need on
        // average.
        let (ratio, freedom) = sandwich.on_average();
        let t = quantile(freedom);
        let ends = known.profile.ends_of_steps(k, t * t * ratio);
        let error = 0.5 * (ends[0] + ends[1]) / t;
        if error.is_finite() && error > 0.0 {
            // All sizes between two drives are as likely, on one channel as on many.
            let reach = ends.map(|end| end / (t * error));
            Coordinate { error, freedom, reach, as_likely: ends, ..unknown }
        } else {
            unknown
        }
    }
}

/// What half the integration step changes in the free parameters, to first order.
fn by_halving(data: &ChannelData, stage: &ChannelStage) -> Vec<f64> {
    let mut change = halved(data).readings(&stage.model);
    change.iter_mut().zip(&stage.readings).for_each(|(fine, now)| *fine = (now - *fine) / data.noise_kpa);
    stage.whitening.apply(&mut change);
    stage.project(data, &change)
}
