//! The paper's experiment: three models, fitted on one part of a recording, judged on the other.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::data::{Channel, ChannelId, Recording};
use crate::fit::{Control, Fit, FitError, FitOptions};
use crate::model::FlowForm;
use crate::rig::{InputError, Rig};
use crate::rollout::Start;

use super::score::{Basis, score_on};
use super::{
    ControllerUse, DriveKind, ModelKind, Objective, Prepared, Score, Setup, Split, SplitError, prepare, score,
};

/// How the comparison is made.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareSettings {
    /// Which models.
    pub models: Vec<ModelKind>,
    /// What is fitted and what judges.
    pub split: Split,
    /// What a fit minimises; models behind the board's loop are always fitted on rollouts.
    pub objective: Objective,
    /// Whether the board's loop is simulated.
    pub controller: ControllerUse,
    /// Which valve.
    pub drive: DriveKind,
    /// Form of the flow function.
    pub form: FlowForm,
    /// Settings of the fits.
    pub fit: FitOptions,
}

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

/// A comparison that cannot be made at all.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The division.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// No channel can be simulated with any model; the first reason.
    #[error(transparent)]
    Inputs(#[from] InputError),
    /// No model could be fitted; the first reason.
    #[error("no model could be fitted to any channel of {file}; {channel}, {model}: {reason}")]
    Nothing {
        /// The recording.
        file: String,
        /// A channel.
        channel: ChannelId,
        /// A model.
        model: &'static str,
        /// Why not.
        reason: String,
    },
    /// No channel has both a command or drive and a pressure.
    #[error("{file}: no channel has a measured pressure; nothing can be compared")]
    NoChannel {
        /// The recording.
        file: String,
    },
}

/// Fits and judges all models on all channels that have a measured pressure. `clock` returns seconds of a steady clock, for the
/// timings; `announce` is told which model is being fitted, on how many channels.
///
/// # Errors
/// [`CompareError`] when no channel can be compared with any model. What only some models or channels lack is said in their
/// [`ModelResult::error`].
pub fn compare(
    recording: &Recording,
    rig: &Rig,
    settings: &CompareSettings,
    control: Control<'_>,
    clock: &dyn Fn() -> f64,
    announce: &dyn Fn(ModelKind, usize),
) -> Result<Comparison, CompareError> {
    let [fitted, judging] = settings.split.rows(recording)?;
    let channels: Vec<&Channel> = recording.channels.iter().filter(|c| c.pressure_kpa.is_some()).collect();
    if channels.is_empty() {
        return Err(CompareError::NoChannel { file: recording.source.file.clone() });
    }
    let test_from_row = judging.start;
    let ranges = [fitted, judging];
    let mut results: Vec<Vec<ModelResult>> = Vec::with_capacity(channels.len());
    let mut fit_times = BTreeMap::new();
    for channels in channels.chunks(channels_at_once(recording)) {
        let mut part: Vec<Vec<ModelResult>> = channels.iter().map(|_| Vec::new()).collect();
        for &model in &settings.models {
            let prepared: Vec<Result<Prepared, InputError>> = channels
                .iter()
                .map(|channel| {
                    let (controller, drive) = (settings.controller, settings.drive);
                    let setup = Setup::resolve(model, controller, drive, recording, channel, rig)?;
                    prepare(setup, recording, channel, rig, settings.form, &ranges)
                })
                .collect();
            announce(model, prepared.iter().filter(|p| p.is_ok()).count());
            let began = clock();
            let fits = fit_together(&prepared, settings, control);
            *fit_times.entry(model.name()).or_insert(0.0) += clock() - began;
            for ((prepared, fit), results) in prepared.into_iter().zip(fits).zip(&mut part) {
                results.push(judge(model, prepared, fit, rig, test_from_row, clock));
            }
        }
        results.append(&mut part);
    }
    let channels: Vec<ChannelComparison> = channels
        .iter()
        .zip(results)
        .map(|(channel, models)| ChannelComparison { channel: channel.id, models })
        .collect();
    let overall: Vec<Overall> = settings
        .models
        .iter()
        .filter_map(|&model| overall(model, &channels, fit_times.get(model.name()).copied().unwrap_or(0.0)))
        .collect();
    if overall.is_empty() {
        return Err(nothing(recording, &channels));
    }
    let mut order: Vec<&Overall> = overall.iter().collect();
    order.sort_by(|a, b| a.rollout_rmse_kpa.total_cmp(&b.rollout_rmse_kpa));
    let ranking = order.iter().map(|o| o.model).collect();
    let at = recording.time_s[test_from_row];
    let origin = recording.time_s.first().copied().unwrap_or(at);
    let stopped = control.cancel.load(std::sync::atomic::Ordering::Relaxed);
    Ok(Comparison {
        fit_seconds: at - origin,
        test_seconds: origin + recording.duration_s() - at,
        test_from_row,
        ranking,
        overall,
        channels,
        stopped,
    })
}

/// Channels whose inputs are held in memory together: all of a short recording, one at a time of an hour at 1 kHz.
#[must_use]
pub fn channels_at_once(recording: &Recording) -> usize {
    /// A row takes about 90 bytes of inputs and measurements.
    const ROWS_HELD: usize = 4_000_000;
    (ROWS_HELD / recording.rows().max(1)).max(1)
}

fn nothing(recording: &Recording, channels: &[ChannelComparison]) -> CompareError {
    let results = channels.iter().flat_map(|c| c.models.iter().map(move |m| (c.channel, m)));
    let mut failures = results.filter_map(|(id, m)| Some((id, m.model.name(), m.error.clone()?)));
    let file = recording.source.file.clone();
    match failures.next() {
        Some((channel, model, reason)) => CompareError::Nothing { file, channel, model, reason },
        None => CompareError::NoChannel { file },
    }
}

/// Fits channels whose setups agree in one call, so that all their starts share the processor.
fn fit_together(
    prepared: &[Result<Prepared, InputError>],
    settings: &CompareSettings,
    control: Control<'_>,
) -> Vec<Option<Result<Fit, FitError>>> {
    let mut fits: Vec<Option<Result<Fit, FitError>>> = prepared.iter().map(|_| None).collect();
    let setup = |index: usize| prepared[index].as_ref().ok().map(|p| p.setup);
    for first in 0..prepared.len() {
        let Ok(leader) = &prepared[first] else { continue };
        if fits[first].is_some() {
            continue;
        }
        let group: Vec<usize> = (first..prepared.len()).filter(|&k| setup(k) == Some(leader.setup)).collect();
        let series: Vec<_> =
            group.iter().filter_map(|&k| Some(&prepared[k].as_ref().ok()?.series[0])).collect();
        let outcomes = leader.subject.fit(&series, settings.objective, &settings.fit, control);
        for (index, outcome) in group.into_iter().zip(outcomes) {
            fits[index] = Some(outcome);
        }
    }
    fits
}

fn judge(
    model: ModelKind,
    prepared: Result<Prepared, InputError>,
    fit: Option<Result<Fit, FitError>>,
    rig: &Rig,
    first_row: usize,
    clock: &dyn Fn() -> f64,
) -> ModelResult {
    let mut result = ModelResult {
        model,
        setup: prepared.as_ref().ok().map(|p| p.setup),
        error: None,
        rollout: None,
        one_step: None,
        rollout_fitted: None,
        evaluation_s: None,
        fit: None,
        trace: None,
    };
    let prepared = match prepared {
        Ok(prepared) => prepared,
        Err(error) => {
            result.error = Some(error.to_string());
            return result;
        }
    };
    let fit = match fit {
        Some(Ok(fit)) => fit,
        Some(Err(error)) => {
            result.error = Some(error.to_string());
            return result;
        }
        None => return result,
    };
    let (subject, values) = (&prepared.subject, fit.values());
    let [fitted, judging] = &prepared.series[..] else { return result };
    let starts = fit.starts::<1>();
    let start = if starts.is_empty() { Start::Measured } else { Start::Given(&starts) };
    result.rollout_fitted = score(fitted, &subject.simulate(&values, fitted, start, fit.substeps));
    let rollout = subject.simulate(&values, judging, Start::Measured, fit.substeps);
    result.rollout = score(judging, &rollout);
    let steps = subject.one_step(&values, judging, fit.substeps);
    result.one_step = score_on(judging, &steps, Basis::Change);
    result.evaluation_s = Some(evaluation_time(&prepared, &values, clock));
    let ambient_kpa = rig.ambient_or_standard().pressure_kpa_abs;
    let gauge = rollout.iter().map(|pa| pa * 1e-3 - ambient_kpa).collect();
    result.trace = Some(Trace { first_row, rollout_kpa: gauge });
    result.fit = Some(fit);
    result
}

/// Seconds for one evaluation of the right-hand side, from at least a few milliseconds' worth.
fn evaluation_time(prepared: &Prepared, values: &[f64], clock: &dyn Fn() -> f64) -> f64 {
    const LEAST_S: f64 = 5e-3;
    const MOST_ROUNDS: u32 = 10_000;
    let series = &prepared.series[0];
    let per_round: usize = series.segments().iter().map(std::ops::Range::len).sum();
    let began = clock();
    let mut rounds = 0;
    while rounds < MOST_ROUNDS {
        std::hint::black_box(prepared.subject.evaluate_all(values, series));
        rounds += 1;
        if clock() - began > LEAST_S {
            break;
        }
    }
    // Rows are far fewer than 2^52.
    (clock() - began) / (f64::from(rounds) * per_round as f64)
}

/// What counts of one channel towards the whole.
struct Judged {
    rollout: Score,
    one_step_r2: f64,
    evaluation_s: f64,
}

fn overall(model: ModelKind, channels: &[ChannelComparison], fit_s: f64) -> Option<Overall> {
    let results: Vec<Judged> = channels
        .iter()
        .flat_map(|c| c.models.iter().filter(|m| m.model == model))
        .filter_map(|m| {
            let one_step_r2 = m.one_step.map_or(f64::NAN, |s| s.r2);
            Some(Judged { rollout: m.rollout?, one_step_r2, evaluation_s: m.evaluation_s? })
        })
        .collect();
    if results.is_empty() {
        return None;
    }
    // A handful of channels.
    let count = results.len() as f64;
    let mean = |value: &dyn Fn(&Judged) -> f64| results.iter().map(value).sum::<f64>() / count;
    Some(Overall {
        model,
        channels: results.len(),
        rollout_rmse_kpa: mean(&|r| r.rollout.rmse_kpa.powi(2)).sqrt(),
        rollout_r2: mean(&|r| r.rollout.r2),
        rollout_iae_kpa_s: mean(&|r| r.rollout.iae_kpa_s) * count,
        one_step_r2: mean(&|r| r.one_step_r2),
        evaluation_s: mean(&|r| r.evaluation_s),
        fit_s,
    })
}
