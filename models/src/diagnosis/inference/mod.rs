//! How well the recording determines an effect's parameters.
//!
//! Standard errors come from how blocks would move the estimate ([`sandwich`]). The interval's ends
//! are those of the profile likelihood ([`profile`]): each parameter is moved, the others refitted,
//! until the cost has risen by what belongs to the standard error on a parabola. Where the cost is
//! a parabola nothing changes; where it is lopsided, has a threshold without derivative, or ends at
//! a bound, the interval shows it. Channels are put together by [`pool`].
//!
//! Of a loop that hunts, the interval has all sizes nearby that are as likely, and so has that of a
//! threshold, between whose neighbouring drives nothing changes. What a fit of the squared error
//! makes of hunting is alike on all channels, and so are the drives' steps: this does not average
//! out between them.
//!
//! What is taken for known and is not (`considered`) widens both ends, and does not average out
//! either.
//!
//! [`band`] says how far readings are from the simulation itself.
//!
//! A step of the integration moves the estimate too, on all channels alike. What half of it changes
//! in the readings, projected on the parameters, is half of what is left of a first-order error and
//! a third of a second-order one: both ends give way by twice that.

pub mod band;
mod considered;
mod determined;
mod likely_sizes;
mod pool;
mod profile;
mod sandwich;

use statrs::distribution::{ContinuousCDF, StudentsT};

pub use self::determined::Determined;
pub use self::pool::pool;
use crate::diagnosis::channel::{ChannelData, Role};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::settings::SETTINGS;
use crate::model::Scale;

/// An estimate on the scale on which the parameter is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// Value, or its logarithm.
    pub value: f64,
    /// Standard error; infinite where the data say nothing.
    pub error: f64,
    /// What each block for fitting adds to that. Empty for a threshold, which has no derivative.
    pub by_block: Vec<f64>,
    /// Degrees of freedom of the error.
    pub freedom: f64,
    /// Distance of the interval's ends below and above, over that of a parabola; infinite where a
    /// bound comes first.
    pub reach: [f64; 2],
    /// Distances below and above up to which a threshold, or a loop that hunts, is as likely; zero
    /// for what has derivatives.
    pub as_likely: [f64; 2],
    /// Change of the value when the integration step is halved.
    pub halving: f64,
    /// Standard error that what is taken for known adds, the same in all blocks and on all
    /// channels.
    pub considered: f64,
}

fn quantile(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom.min(1e6)).map_or(2.0, |d| d.inverse_cdf(0.975))
}

/// The parameters of one effect on one channel with standard errors, on their scales, that are
/// known already.
#[must_use]
pub fn as_estimated(
    data: &ChannelData,
    stage: &ChannelStage,
    effect: usize,
    errors: &[f64],
) -> Vec<Coordinate> {
    let parameters = stage.model.parameters(&data.plant);
    let blocks = data.blocks.iter().filter(|block| block.role == Role::Fit).count();
    let range = stage.model.range(&data.plant, effect).unwrap_or_default();
    let coordinate = |(k, error): (usize, &f64)| {
        let value = stage.model.values[k];
        Coordinate {
            value: if parameters[k].scale == Scale::Linear { value } else { value.ln() },
            error: *error,
            by_block: Vec::new(),
            freedom: blocks.saturating_sub(1).max(1) as f64,
            reach: [1.0; 2],
            as_likely: [0.0; 2],
            halving: 0.0,
            considered: 0.0,
        }
    };
    range.zip(errors).map(coordinate).collect()
}

/// The 95 % interval in the parameter's own unit.
#[must_use]
pub fn interval(coordinate: &Coordinate, scale: Scale) -> Option<[f64; 2]> {
    if !coordinate.error.is_finite() {
        return None;
    }
    let half = quantile(coordinate.freedom) * coordinate.error;
    let known = quantile(f64::INFINITY) * coordinate.considered;
    let step = 2.0 * coordinate.halving.abs();
    let [below, above] = [0, 1]
        .map(|side| (half * coordinate.reach[side]).hypot(known).max(coordinate.as_likely[side]) + step);
    let ends = [coordinate.value - below, coordinate.value + above];
    Some(ends.map(|end| scale.value(end)))
}

/// Does an interval within the bounds of a parameter determine anything?
#[must_use]
pub fn determines(scale: Scale, ci95: [f64; 2], bounds: [f64; 2]) -> bool {
    let width = |[low, high]: [f64; 2]| scale.coordinate(high) - scale.coordinate(low);
    width(ci95) <= SETTINGS.flat * width(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lopsided_profile_makes_a_lopsided_interval() {
        let coordinate = |reach| Coordinate {
            value: 1.0,
            error: 0.1,
            by_block: Vec::new(),
            freedom: 1e6,
            reach,
            as_likely: [0.0; 2],
            halving: 0.0,
            considered: 0.0,
        };
        let ends = interval(&coordinate([1.0, 2.0]), Scale::Linear);
        let [low, high] = ends.unwrap_or_default();
        assert!((low - (1.0 - 0.196)).abs() < 1e-3 && (high - (1.0 + 0.392)).abs() < 1e-3, "{low} {high}");
        let open = interval(&coordinate([f64::INFINITY, 1.0]), Scale::Logarithmic);
        assert_eq!(open.map(|ends| ends[0]), Some(0.0));
    }
}
