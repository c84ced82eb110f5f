//! One model fitted to the channels of a recording, and judged on the rest.

use std::ops::Range;

use serde::Serialize;

use crate::data::{Channel, ChannelId, InputError, Recording};
use crate::fit::{Control, Fit, FitError, FitOptions};
use crate::model::FlowForm;
use crate::rig::Rig;
use crate::rollout::Start;

use super::{
    ControllerUse, DriveKind, ModelKind, Objective, Prepared, Score, Setup, Split, SplitError,
    channels_at_once, prepare, score,
};

/// How a model is fitted to a recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FitSettings {
    /// Which model.
    pub model: ModelKind,
    /// What is fitted and what judges; `None` fits the whole recording.
    pub split: Option<Split>,
    /// What the fit minimises.
    pub objective: Objective,
    /// Whether the board's loop is simulated.
    pub controller: ControllerUse,
    /// Which valve.
    pub drive: DriveKind,
    /// Form of the flow function.
    pub form: FlowForm,
    /// Settings of the fit.
    pub fit: FitOptions,
}

/// One channel's fit.
#[derive(Debug, Clone, Serialize)]
pub struct FittedChannel {
    /// The channel.
    #[serde(skip)]
    pub channel: ChannelId,
    /// What was simulated.
    #[serde(skip)]
    pub setup: Setup,
    /// The fit.
    pub fit: Fit,
    /// The rollout on the fitted part.
    pub fitted: Option<Score>,
    /// The rollout on the rest, where there is one.
    pub held_out: Option<Score>,
}

/// Why a recording cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FitChannelsError {
    /// The division.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// Nothing to fit.
    #[error("{file}: {rows} rows are too few to fit; {least} at least")]
    TooFewRows {
        /// The recording.
        file: String,
        /// Its rows.
        rows: usize,
        /// Rows needed.
        least: usize,
    },
    /// The recording or the rig lacks something.
    #[error(transparent)]
    Inputs(#[from] InputError),
    /// Rates need a drive that is recorded.
    #[error(
        "rates can be fitted only where the drive is recorded; with the board's loop simulated, fit rollouts"
    )]
    NoRates,
    /// A fit failed.
    #[error("channel {channel}: {source}")]
    Fit {
        /// The channel.
        channel: ChannelId,
        /// Why.
        source: FitError,
    },
}

impl FitSettings {
    /// Rows to fit, and rows to judge by where the recording is divided.
    ///
    /// # Errors
    /// [`FitChannelsError::Split`] or [`FitChannelsError::TooFewRows`].
    pub fn ranges(&self, recording: &Recording) -> Result<Vec<Range<usize>>, FitChannelsError> {
        let (rows, least) = (recording.rows(), Split::LEAST_ROWS);
        match self.split {
            Some(split) => Ok(split.rows(recording)?.to_vec()),
            None if rows < least => {
                Err(FitChannelsError::TooFewRows { file: recording.source.file.clone(), rows, least })
            }
            None => Ok(std::iter::once(0..rows).collect()),
        }
    }
}

/// Fits every channel of `recording` on its own.
///
/// # Errors
/// [`FitChannelsError`] at the first channel that cannot be fitted.
pub fn fit_channels(
    recording: &Recording,
    rig: &Rig,
    settings: &FitSettings,
    control: Control<'_>,
) -> Result<Vec<FittedChannel>, FitChannelsError> {
    let ranges = settings.ranges(recording)?;
    // Before anything that may be said of a drive: without pressures there is nothing to fit to.
    for channel in &recording.channels {
        recording.pressure(channel, "a fit").map_err(InputError::from)?;
    }
    let mut fitted = Vec::with_capacity(recording.channels.len());
    for part in recording.channels.chunks(channels_at_once(recording)) {
        let one = |channel: &Channel| {
            let (controller, drive) = (settings.controller, settings.drive);
            let setup = Setup::resolve(settings.model, controller, drive, recording, channel, rig)?;
            Ok((channel.id, prepare(setup, recording, channel, rig, settings.form, &ranges)?))
        };
        let channels = part.iter().map(one).collect::<Result<Vec<_>, InputError>>()?;
        let rates = matches!(settings.objective, Objective::Rate { .. });
        if rates && channels.iter().any(|(_, prepared)| !prepared.subject.has_rates()) {
            return Err(FitChannelsError::NoRates);
        }
        fit_part(&channels, settings, control, &mut fitted)?;
    }
    fitted.sort_by_key(|fit| fit.channel);
    Ok(fitted)
}

/// Fits these channels, those with one model together.
fn fit_part(
    channels: &[(ChannelId, Prepared)],
    settings: &FitSettings,
    control: Control<'_>,
    fitted: &mut Vec<FittedChannel>,
) -> Result<(), FitChannelsError> {
    let mut leaders: Vec<&Prepared> = Vec::new();
    for (_, prepared) in channels {
        if leaders.iter().any(|leader| leader.same_model(prepared)) {
            continue;
        }
        leaders.push(prepared);
        let group: Vec<&(ChannelId, Prepared)> =
            channels.iter().filter(|(_, other)| other.same_model(prepared)).collect();
        let series: Vec<_> = group.iter().map(|(_, prepared)| &prepared.series[0]).collect();
        let outcomes = prepared.subject.fit(&series, settings.objective, &settings.fit, control);
        for ((channel, prepared), outcome) in group.into_iter().zip(outcomes) {
            let fit = outcome.map_err(|source| FitChannelsError::Fit { channel: *channel, source })?;
            fitted.push(judged(*channel, prepared, fit));
        }
    }
    Ok(())
}

fn judged(channel: ChannelId, prepared: &Prepared, fit: Fit) -> FittedChannel {
    let (subject, values) = (&prepared.subject, fit.values());
    let starts = fit.starts();
    let start = if starts.is_empty() { Start::Measured } else { Start::Given(&starts) };
    let simulate = |series, start| score(series, &subject.simulate(&values, series, start, fit.substeps));
    let fitted = simulate(&prepared.series[0], start);
    let held_out = prepared.series.get(1).and_then(|series| simulate(series, Start::Measured));
    FittedChannel { channel, setup: prepared.setup, fit, fitted, held_out }
}
