//! The density of parameters, given the prediction errors and what is expected of them beforehand.

use super::filter::{Gains, Innovations, filtered};
use super::uncertainty::{COUNT, Uncertainty};
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::settings::SETTINGS;
use crate::model::Parameter;

/// Standard deviation of the logarithm of the noise: it is known from the recording itself.
const NOISE_KNOWN: f64 = 0.1;
/// Widest deviations that are believed, over what is expected.
const WIDEST: [f64; COUNT] = [2.0, 10.0, 5.0];
/// Narrowest.
const NARROWEST: [f64; COUNT] = [1e-3, 1e-3, 0.3];

/// Mean and standard deviation of a coordinate before anything was measured.
pub type Expected = (f64, f64);

/// What is to be estimated on a channel, and from what.
pub struct Posterior<'a> {
    /// The channel.
    pub data: &'a ChannelData,
    /// Its model; values that are not free stay.
    pub model: Extended,
    /// All its parameters.
    pub parameters: Vec<Parameter>,
    /// Positions of the free ones.
    pub free: Vec<usize>,
    /// What is expected of each free one, on its scale.
    pub expected: Vec<Expected>,
    /// Scales of the deviations: half-normal, of the noise log-normal.
    pub scales: Uncertainty,
    /// Is the supply taken as it is, and the filter's gain where derivatives are taken? What most
    /// parameters do to that gain is some percent of what they do to the errors.
    pub stiff: bool,
    /// Rows whose prediction errors count.
    pub counted: &'a [bool],
}

/// The posterior at a point.
#[derive(Debug, Clone)]
pub struct Density {
    /// Logarithm of the density; minus infinity where the simulation runs away.
    pub log: f64,
    /// The prediction errors there ...
    pub innovations: Innovations,
    /// ... and how the filter followed them.
    pub gains: Gains,
}

impl Posterior<'_> {
    /// Coordinates: the free parameters on their scales, then the logarithms of the deviations.
    #[must_use]
    pub fn coordinates(&self, model: &Extended, uncertainty: &Uncertainty) -> Vec<f64> {
        let free = self.free.iter().map(|&k| self.parameters[k].scale.coordinate(model.values[k]));
        let bounds = self.bounds();
        let all = free.chain(uncertainty.logarithms());
        all.zip(bounds).map(|(x, (low, high))| x.clamp(low, high)).collect()
    }

    /// Bounds of the coordinates.
    #[must_use]
    pub fn bounds(&self) -> Vec<(f64, f64)> {
        let free = self.free.iter().map(|&k| {
            let p = &self.parameters[k];
            p.coordinate_bounds()
        });
        let scales = self.scales.logarithms();
        let deviations = (0..COUNT).map(|k| {
            let narrow = scales[k] + NARROWEST[k].ln();
            (narrow, if k == 0 && self.stiff { narrow } else { scales[k] + WIDEST[k].ln() })
        });
        free.chain(deviations).collect()
    }

    /// The model and the deviations at some coordinates.
    #[must_use]
    pub fn at(&self, coordinates: &[f64]) -> (Extended, Uncertainty) {
        let mut model = self.model.clone();
        for (&k, &x) in self.free.iter().zip(coordinates) {
            let p = &self.parameters[k];
            let value = p.scale.value(x);
            model.values[k] = value.clamp(p.lower, p.upper);
        }
        (model, Uncertainty::from_logarithms(&coordinates[self.free.len()..]))
    }

    /// The posterior at some coordinates.
    #[must_use]
    pub fn density(&self, coordinates: &[f64]) -> Density {
        let (model, uncertainty) = self.at(coordinates);
        let (innovations, gains) = filtered(self.data, &model, &uncertainty, self.counted);
        let log = log_likelihood(&innovations) + self.prior(coordinates);
        Density { log: if log.is_finite() { log } else { f64::NEG_INFINITY }, innovations, gains }
    }

    /// Logarithm of the prior, up to a constant.
    fn prior(&self, coordinates: &[f64]) -> f64 {
        let gaussian = |(x, (mean, error)): (&f64, &Expected)| -0.5 * ((x - mean) / error).powi(2);
        let free: f64 = coordinates.iter().zip(&self.expected).map(gaussian).sum();
        let [supply, discrepancy, noise] = self.over_scales(coordinates);
        let half_normal = |ratio: f64| -0.5 * ratio.exp().powi(2);
        free + half_normal(supply) + half_normal(discrepancy) - 0.5 * (noise / NOISE_KNOWN).powi(2)
    }

    /// Slope of the prior's logarithm by a coordinate, and minus its curvature where that is
    /// positive.
    #[must_use]
    pub fn prior_slope(&self, coordinates: &[f64], k: usize) -> (f64, f64) {
        if let Some((mean, error)) = self.expected.get(k) {
            return (-(coordinates[k] - mean) / error.powi(2), error.powi(-2));
        }
        let deviation = k - self.expected.len();
        let ratio = self.over_scales(coordinates)[deviation];
        if deviation == COUNT - 1 {
            (-ratio / NOISE_KNOWN.powi(2), NOISE_KNOWN.powi(-2))
        } else {
            let square = ratio.exp().powi(2);
            (-square, 2.0 * square)
        }
    }

    fn over_scales(&self, coordinates: &[f64]) -> [f64; COUNT] {
        let scales = self.scales.logarithms();
        std::array::from_fn(|k| coordinates[self.free.len() + k] - scales[k])
    }
}

/// Logarithm of the density of prediction errors, large ones counted less.
#[must_use]
pub fn log_likelihood(innovations: &Innovations) -> f64 {
    let one = |(error, variance): (&f64, &f64)| {
        let z = error.abs() / variance.sqrt();
        let loss = if z < SETTINGS.greybox_huber {
            0.5 * z * z
        } else {
            SETTINGS.greybox_huber * (z - 0.5 * SETTINGS.greybox_huber)
        };
        -0.5 * (std::f64::consts::TAU * variance).ln() - loss
    };
    innovations.errors.iter().zip(&innovations.variances).map(one).sum()
}
