use super::super::displays::{self, Shown};
use crate::errors;
use pneudrive_model::diagnosis::machine::{self, MachineDiagnosis};
use pneudrive_model::diagnosis::{
    ChannelData, Diagnosis, EXTENDED_FILE, Extended, ExtendedFile, Role, json, page,
};
use pneudrive_model::report::{Colour, Markup, html};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// A diagnosis, as it is kept.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Kept {
    pub report: json::Report,
    /// The extended model with its file's name; of a machine one for each recording.
    pub extended: Vec<(String, ExtendedFile)>,
    pub html: String,
    /// The next experiment, where one would tell more.
    pub trajectory: Option<String>,
    /// None of a machine, whose recordings are each simulated by a model of their own.
    pub channels: Vec<Residuals>,
}

/// One channel's, at the compared rows.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Residuals {
    pub channel: String,
    pub time_s: Vec<f64>,
    pub measured_kpa: Vec<f64>,
    pub base_kpa: Vec<f64>,
    pub extended_kpa: Vec<f64>,
    /// What the row's block was used for.
    pub role: Vec<String>,
}

impl Kept {
    pub fn of(diagnosis: Diagnosis, footer: &str) -> PyResult<Self> {
        let html = page::page(&diagnosis, footer).map_err(errors::unusable)?;
        let models = diagnosis.base.iter().zip(&diagnosis.extended_models);
        let channels = diagnosis.channels.iter().zip(models);
        let channels = channels.map(|(data, (base, extended))| Residuals::of(data, base, extended)).collect();
        let Diagnosis { report, extended, plan, .. } = diagnosis;
        let extended = vec![(EXTENDED_FILE.to_owned(), extended)];
        Ok(Self { report, extended, html, trajectory: plan.map(|plan| plan.trajectory), channels })
    }

    pub fn of_machine(found: MachineDiagnosis, footer: &str) -> PyResult<Self> {
        let html = machine::page::page(&found, footer).map_err(errors::unusable)?;
        let MachineDiagnosis { report, extended, .. } = found;
        Ok(Self { report, extended, html, trajectory: None, channels: Vec::new() })
    }

    /// The first channel's errors without and with the causes, where they can be drawn.
    pub fn drawn(&self) -> Markup {
        let Some(first) = self.channels.first() else { return html! {} };
        let simulated = |residuals: &[f64]| -> Vec<f64> {
            first.measured_kpa.iter().zip(residuals).map(|(measured, error)| measured - error).collect()
        };
        let mut models = vec![("base model".to_owned(), Colour::Orange, simulated(&first.base_kpa))];
        if !self.report.causes.is_empty() {
            models.push(("with the causes".to_owned(), Colour::Blue, simulated(&first.extended_kpa)));
        }
        let shown = Shown {
            channel: &first.channel,
            channels: self.channels.len(),
            time_s: &first.time_s,
            measured_kpa: &first.measured_kpa,
            models,
            shaded: first.role.iter().map(|role| role == "test").collect(),
            shaded_name: "test blocks",
        };
        displays::draw(&shown)
    }
}

impl Residuals {
    fn of(data: &ChannelData, base: &Extended, extended: &Extended) -> Self {
        let mut role = vec![String::new(); data.rows.len()];
        for (block, span) in data.blocks.iter().zip(&data.spans) {
            let word = match block.role {
                Role::Fit => "fit",
                Role::Select => "select",
                Role::Test => "test",
            };
            role[span.clone()].fill(word.to_owned());
        }
        Self {
            channel: data.id.to_string(),
            time_s: data.rows.iter().map(|row| data.inputs.time_s[*row as usize]).collect(),
            measured_kpa: data.measured_kpa.to_vec(),
            base_kpa: data.residuals(base),
            extended_kpa: data.residuals(extended),
            role,
        }
    }
}
