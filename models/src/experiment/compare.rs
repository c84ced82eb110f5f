//! The paper's experiment: three models, fitted on one part of a recording, judged on the other.

use crate::order::ascending;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use std::time::Instant;

use crate::data::{Channel, ChannelId, InputError, Recording};
use crate::fit::{Control, Fit, FitError, FitOptions};
use crate::model::FlowForm;
use crate::rig::Rig;

use super::judge::{judge, overall};
use super::{
    ChannelComparison, Comparison, ControllerUse, DriveKind, ModelKind, ModelResult, Objective, Overall,
    Prepared, Setup, Split, SplitError, prepare,
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

impl Default for CompareSettings {
    /// All three models, fitted on rollouts of the first 80 % of the recording and judged on the
    /// rest.
    fn default() -> Self {
        Self {
            models: ModelKind::ALL.to_vec(),
            split: Split::FitFraction(0.8),
            objective: Objective::default(),
            controller: ControllerUse::default(),
            drive: DriveKind::default(),
            form: FlowForm::default(),
            fit: FitOptions::default(),
        }
    }
}

/// A comparison that cannot be made at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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

/// How a caller watches and stops a comparison.
#[derive(Clone, Copy)]
pub struct CompareWatch<'a> {
    /// Watches and stops the fits.
    pub control: Control<'a>,
    /// Seconds of a steady clock, for the timings.
    pub clock: &'a dyn Fn() -> f64,
    /// Told which model is being fitted, on how many channels.
    pub announce: &'a dyn Fn(ModelKind, usize),
}

impl std::fmt::Debug for CompareWatch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CompareWatch").field("control", &self.control).finish_non_exhaustive()
    }
}

impl CompareWatch<'static> {
    /// Nobody watches; timings by the system's clock.
    #[must_use]
    pub fn none() -> Self {
        static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);
        Self { control: Control::none(), clock: &|| BEGAN.elapsed().as_secs_f64(), announce: &|_, _| {} }
    }
}

/// Fits and judges all models on all channels that have a measured pressure.
///
/// # Errors
/// [`CompareError`] when no channel can be compared with any model. What only some models or
/// channels lack is said in their [`ModelResult::error`].
pub fn compare(
    recording: &Recording,
    rig: &Rig,
    settings: &CompareSettings,
    watch: CompareWatch<'_>,
) -> Result<Comparison, CompareError> {
    let CompareWatch { control, clock, announce } = watch;
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
    ascending(&mut order, |item| item.rollout_rmse_kpa);
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

/// Channels whose inputs are held in memory together: all of a short recording, one at a time of an
/// hour at 1 kHz.
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

/// Fits channels whose models agree in one call, so that all their starts share the processor.
fn fit_together(
    prepared: &[Result<Prepared, InputError>],
    settings: &CompareSettings,
    control: Control<'_>,
) -> Vec<Option<Result<Fit, FitError>>> {
    let mut fits: Vec<Option<Result<Fit, FitError>>> = prepared.iter().map(|_| None).collect();
    for first in 0..prepared.len() {
        let Ok(leader) = &prepared[first] else { continue };
        if fits[first].is_some() {
            continue;
        }
        let same = |&k: &usize| prepared[k].as_ref().is_ok_and(|other| other.same_model(leader));
        let group: Vec<usize> = (first..prepared.len()).filter(same).collect();
        let series: Vec<_> =
            group.iter().filter_map(|&k| Some(&prepared[k].as_ref().ok()?.series[0])).collect();
        let outcomes = leader.subject.fit(&series, settings.objective, &settings.fit, control);
        for (index, outcome) in group.into_iter().zip(outcomes) {
            fits[index] = Some(outcome);
        }
    }
    fits
}
