//! The parameter file itself.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Provenance, StoreError};
use crate::data::{ChannelId, Recording, write};
use crate::experiment::{FitChannelsError, FitSettings, FittedChannel, Objective, Setup, Subject};
use crate::fit::Fit;
use crate::model::FlowForm;
use crate::noise;
use crate::rig::Rig;

/// Fitted parameters of one or more channels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterFile {
    /// [`ParameterFile::SCHEMA`].
    pub schema: String,
    /// Where the parameters came from.
    pub provenance: Provenance,
    /// How they were fitted.
    pub settings: Settings,
    /// The rig they were fitted with: a simulation needs the same constants.
    pub rig: Rig,
    /// The parameters, by channel name.
    pub channels: BTreeMap<ChannelId, ChannelParameters>,
}

/// How the parameters were fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// `rollout` or `rate`.
    pub objective: String,
    /// Number of starts.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Seconds from the beginning of the recording that were fitted.
    pub fit_seconds: f64,
    /// Whether the flow function is the paper's printed form instead of ISO 6358's.
    pub printed_flow: bool,
    /// Whether the fit was stopped early.
    pub stopped: bool,
}

/// What was found for one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelParameters {
    /// Model, drive and controller.
    pub setup: Setup,
    /// Runge-Kutta steps per tick of the simulation.
    pub substeps: usize,
    /// Root mean square residual of the fit, kPa (kPa/s for fits on rates).
    pub rms: f64,
    /// Noise of the measurement, kPa RMS: what varies from sample to sample, whatever a model says.
    /// `None` in files that do not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_kpa: Option<f64>,
    /// Samples fitted.
    pub samples: usize,
    /// Condition number of the scaled Jacobian.
    pub condition: f64,
    /// Starts that reached the best minimum.
    pub agreeing_starts: usize,
    /// Names of the free parameters, in the order of `covariance`.
    pub free: Vec<String>,
    /// Covariance of the free parameters in their units, row by row; infinite where undetermined.
    pub covariance: Vec<Vec<f64>>,
    /// All parameters, in the model's order.
    pub parameters: Vec<StoredParameter>,
}

/// One parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredParameter {
    /// Name within the model.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit of the value, `1` for none.
    pub unit: String,
    /// 95 % interval, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
    /// Standard error, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
    /// 95 % profile-likelihood interval, where it was computed; infinite at an open end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile95: Option<[f64; 2]>,
    /// Whether the data determine it.
    pub determined: bool,
}

impl ChannelParameters {
    /// What is kept of a fit.
    #[must_use]
    pub fn of(setup: Setup, fit: &Fit) -> Self {
        let parameters = fit.parameters.iter().map(|p| StoredParameter {
            name: p.name.clone(),
            value: p.value,
            unit: p.unit.to_owned(),
            ci95: p.ci95,
            standard_error: p.standard_error,
            profile95: p
                .profile95
                .map(|[low, high]| [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]),
            determined: !p.fixed && p.at_bound.is_none() && fit.undetermined.iter().all(|u| u.name != p.name),
        });
        Self {
            setup,
            substeps: fit.substeps,
            rms: fit.rms,
            noise_kpa: None,
            samples: fit.residuals,
            condition: fit.condition,
            agreeing_starts: fit.agreeing_starts,
            free: fit.free.clone(),
            covariance: fit.covariance.clone(),
            parameters: parameters.collect(),
        }
    }
}

fn stored(recording: &Recording, fitted: &FittedChannel) -> ChannelParameters {
    let noise_kpa = recording.channel(fitted.channel).ok().and_then(noise::measured_kpa);
    ChannelParameters { noise_kpa, ..ChannelParameters::of(fitted.setup, &fitted.fit) }
}

impl ParameterFile {
    /// What the key `schema` says in a file of this form.
    pub const SCHEMA: &'static str = "pneudrive-parameters/1";

    /// More Runge-Kutta steps a tick than any fit has chosen; a simulation takes proportionally
    /// longer.
    pub const MOST_SUBSTEPS: usize = 1_000;

    /// What is kept of the fits of a recording.
    ///
    /// # Errors
    /// [`FitChannelsError`] where the settings do not fit the recording, and the fits cannot be of
    /// it.
    pub fn of(
        recording: &Recording,
        rig: &Rig,
        settings: &FitSettings,
        fitted: &[FittedChannel],
    ) -> Result<Self, FitChannelsError> {
        let rows = &settings.ranges(recording)?[0];
        let objective = if settings.objective == Objective::Rollout { "rollout" } else { "rate" };
        Ok(Self {
            schema: Self::SCHEMA.to_owned(),
            provenance: Provenance::now(&recording.source),
            settings: Settings {
                objective: objective.to_owned(),
                starts: settings.fit.starts,
                seed: settings.fit.seed,
                fit_seconds: recording.time_s[rows.end - 1] - recording.time_s[rows.start],
                printed_flow: settings.form == FlowForm::Printed,
                stopped: false,
            },
            rig: rig.clone(),
            channels: fitted.iter().map(|fitted| (fitted.channel, stored(recording, fitted))).collect(),
        })
    }

    /// Reads a parameter file.
    ///
    /// # Errors
    /// [`StoreError`], naming the file and what is wrong in it.
    pub fn load(path: &Path) -> Result<Self, StoreError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|source| StoreError::Open { file: file.clone(), source })?;
        Self::parse(&file, &text)
    }

    /// Checks the content of a parameter file; `file` is its name for messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(file: &str, text: &str) -> Result<Self, StoreError> {
        let syntax =
            |e: toml::de::Error| StoreError::Syntax { file: file.to_owned(), message: e.to_string() };
        let table: toml::Table = text.parse().map_err(syntax)?;
        if table.get("schema").and_then(toml::Value::as_str) != Some(Self::SCHEMA) {
            let found = table.get("schema").map_or_else(|| "missing".to_owned(), ToString::to_string);
            return Err(StoreError::Schema { file: file.to_owned(), found, expected: Self::SCHEMA });
        }
        let read: Self = toml::from_str(text).map_err(syntax)?;
        Rig::check_within(file, text)?;
        for (&channel, stored) in &read.channels {
            if !(1..=Self::MOST_SUBSTEPS).contains(&stored.substeps) {
                let (file, substeps) = (file.to_owned(), stored.substeps);
                return Err(StoreError::Substeps { file, channel, substeps, most: Self::MOST_SUBSTEPS });
            }
        }
        Ok(read)
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`StoreError::Write`] naming the file.
    pub fn save(&self, path: &Path) -> Result<(), StoreError> {
        let file = path.display().to_string();
        let text = toml::to_string(self).map_err(|e| StoreError::Express { file, message: e.to_string() })?;
        write::text_atomically(path, &text)?;
        Ok(())
    }

    /// The entry of a channel; `file` is this file's name for messages.
    ///
    /// # Errors
    /// [`StoreError::NoChannel`].
    pub fn channel(&self, file: &str, id: ChannelId) -> Result<&ChannelParameters, StoreError> {
        self.channels.get(&id).ok_or_else(|| StoreError::NoChannel {
            file: file.to_owned(),
            channel: id,
            found: self.channels.keys().map(ToString::to_string).collect::<Vec<_>>().join(", "),
        })
    }

    /// The values of a channel in the order that `subject` takes them.
    ///
    /// # Errors
    /// [`StoreError`] when the names are not the model's, or a value is not finite or none that the
    /// model can have.
    pub fn values(&self, file: &str, id: ChannelId, subject: &Subject) -> Result<Vec<f64>, StoreError> {
        let stored = self.channel(file, id)?;
        let expected: Vec<String> = subject.parameters().into_iter().map(|p| p.name).collect();
        let found: Vec<String> = stored.parameters.iter().map(|p| p.name.clone()).collect();
        if expected != found {
            return Err(StoreError::Parameters {
                file: file.to_owned(),
                channel: id,
                model: stored.setup.model.name(),
                expected: expected.join(", "),
                found: found.join(", "),
            });
        }
        if let Some(p) = stored.parameters.iter().find(|p| !p.value.is_finite()) {
            let (name, value) = (p.name.clone(), p.value);
            return Err(StoreError::NotFinite { file: file.to_owned(), channel: id, name, value });
        }
        // What a fit could not have found has been put there by hand.
        for (parameter, stored) in subject.parameters().into_iter().zip(&stored.parameters) {
            let (lower, upper, value) = (parameter.lower, parameter.upper, stored.value);
            if !(lower..=upper).contains(&value) {
                let (file, name) = (file.to_owned(), parameter.name);
                return Err(StoreError::Impossible { file, channel: id, name, value, lower, upper });
            }
        }
        Ok(stored.parameters.iter().map(|p| p.value).collect())
    }

    /// The flow function's form.
    #[must_use]
    pub fn flow_form(&self) -> FlowForm {
        if self.settings.printed_flow { FlowForm::Printed } else { FlowForm::Iso6358 }
    }
}
