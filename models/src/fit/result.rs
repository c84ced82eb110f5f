//! What a fit found, with all that is needed to judge and repeat it.

use serde::Serialize;

use super::levenberg::Ending;
use super::multistart::StartOutcome;

/// A value at the end of its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// At the lower bound.
    Lower,
    /// At the upper bound.
    Upper,
}

/// One parameter of a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedParameter {
    /// Name within the model.
    pub name: String,
    /// Unit of the values.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// It was not fitted.
    pub fixed: bool,
    /// It ended on a bound: its interval is not known.
    pub at_bound: Option<Bound>,
    /// Standard error, robust against correlated residuals. `None` for a fixed parameter, one at a
    /// bound, or an undetermined one.
    pub standard_error: Option<f64>,
    /// 95 % interval from the standard error (on the scale of fitting).
    pub ci95: Option<[f64; 2]>,
    /// 95 % interval from the profile likelihood, when asked for; `None` at an end means open.
    pub profile95: Option<[Option<f64>; 2]>,
}

/// Why the data do not determine a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Nothing in the recording changes with it.
    NoEffect,
    /// Others can make up for it: they are named.
    Confounded(Vec<String>),
    /// Its interval is as wide as its range.
    Wide,
}

/// A parameter the data do not determine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Undetermined {
    /// Name of the parameter.
    pub name: String,
    /// Why.
    pub reason: Reason,
}

/// What was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// Simulated against measured pressures; residuals in kPa.
    Rollout,
    /// Model rate against the measured pressure's derivative; residuals in kPa/s.
    Rate {
        /// Samples to either side in the smoothing derivative.
        half_width: usize,
    },
}

/// The result of a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fit {
    /// All parameters in the model's order.
    pub parameters: Vec<FittedParameter>,
    /// What was fitted.
    pub target: Target,
    /// Root mean square residual, kPa or kPa/s.
    pub rms: f64,
    /// Number of residuals.
    pub residuals: usize,
    /// Absolute start pressures in Pa, per segment and output; empty when rates were fitted.
    pub start_pressures_pa: Vec<Vec<f64>>,
    /// Condition number of the scaled Jacobian, over the free coordinates.
    pub condition: f64,
    /// Parameters the data do not determine.
    pub undetermined: Vec<Undetermined>,
    /// Names of the free parameters, in the order of `covariance`.
    pub free: Vec<String>,
    /// Covariance of the free parameters in their units, row by row; infinite where undetermined.
    pub covariance: Vec<Vec<f64>>,
    /// How many independent samples the recording is worth to the parameter that suffers most from
    /// correlated residuals.
    pub effective_samples: f64,
    /// Runge-Kutta steps per tick.
    pub substeps: usize,
    /// Largest change in Pa of the rollouts when the step is halved; `None` when rates were fitted.
    pub integration_error_pa: Option<f64>,
    /// How the best start ended.
    pub ending: Ending,
    /// All starts in order.
    pub starts: Vec<StartOutcome>,
    /// How many of them reached the best minimum.
    pub agreeing_starts: usize,
    /// Seed of the starts.
    pub seed: u64,
}

impl Fit {
    /// The values in the model's order, as simulations take them.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// The parameter of this name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&FittedParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Start pressures as rollouts take them.
    #[must_use]
    pub fn starts(&self) -> Vec<f64> {
        self.start_pressures_pa.iter().flatten().copied().collect()
    }
}
