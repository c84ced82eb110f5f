//! What a comparison found.

use serde::Serialize;

use crate::data::ChannelId;
use crate::fit::Fit;

use super::{ModelKind, Score, Setup};

/// Simulated and predicted pressures of one model on the judging part, for plots.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// First row of the recording it covers.
    pub first_row: usize,
    /// Rollout, kPa gauge, `NaN` outside the stretches.
    pub rollout_kpa: Vec<f64>,
}

/// One model on one channel.
#[derive(Debug, Clone, Serialize)]
pub struct ModelResult {
    /// The model.
    pub model: ModelKind,
    /// What was simulated, if the channel allows it.
    pub setup: Option<Setup>,
    /// Why there is no result.
    pub error: Option<String>,
    /// Rollouts on the judging part.
    pub rollout: Option<Score>,
    /// One-step predictions on the judging part.
    pub one_step: Option<Score>,
    /// Rollouts on the fitted part.
    pub rollout_fitted: Option<Score>,
    /// Time of one evaluation of the right-hand side, inputs prepared included, s.
    pub evaluation_s: Option<f64>,
    /// The fit.
    pub fit: Option<Fit>,
    /// Rollout over the judging part.
    #[serde(skip)]
    pub trace: Option<Trace>,
}

/// All models on one channel.
#[derive(Debug, Clone, Serialize)]
pub struct ChannelComparison {
    /// The channel.
    pub channel: ChannelId,
    /// One entry per model, in the order asked for.
    pub models: Vec<ModelResult>,
}

/// One model over all channels.
#[derive(Debug, Clone, Serialize)]
pub struct Overall {
    /// The model.
    pub model: ModelKind,
    /// Channels it could be applied to.
    pub channels: usize,
    /// Root mean square of the channels' rollout errors, kPa.
    pub rollout_rmse_kpa: f64,
    /// Mean of the channels' rollout R^2.
    pub rollout_r2: f64,
    /// Sum of the channels' integrated absolute rollout errors, kPa s.
    pub rollout_iae_kpa_s: f64,
    /// Mean of the channels' one-step R^2.
    pub one_step_r2: f64,
    /// Mean time of one evaluation, s.
    pub evaluation_s: f64,
    /// Time of all fits of this model together, s.
    pub fit_s: f64,
}

/// The whole experiment.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Seconds of the recording that were fitted.
    pub fit_seconds: f64,
    /// Seconds of the recording that judge.
    pub test_seconds: f64,
    /// Row of the recording that begins the judging part.
    pub test_from_row: usize,
    /// Models, best first by the root mean square rollout error on the judging part.
    pub ranking: Vec<ModelKind>,
    /// Models over all channels, in the order asked for.
    pub overall: Vec<Overall>,
    /// Channel by channel.
    pub channels: Vec<ChannelComparison>,
    /// Whether the fits were stopped early.
    pub stopped: bool,
}
