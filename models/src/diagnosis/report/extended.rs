//! `extended.toml`: the extended model as a file that can be simulated.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::data::{why, write};
use crate::diagnosis::channel::{ChannelData, Correction, Extended};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::inference::band::Band;
use crate::effects::catalogue::{CATALOGUE, index_of};
use crate::experiment::{DriveKind, ModelKind};
use crate::model::FlowForm;
use crate::rig::Rig;
use crate::store::{ParameterFile, Provenance, StoreError};

/// Name of the format.
pub const SCHEMA: &str = "pneudrive-extended/1";

/// The file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExtendedFile {
    /// `pneudrive-extended`, with its version.
    pub schema: String,
    /// Base model: `nonlinear` or `linear`.
    pub model: String,
    /// Where it came from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
    /// The rig it was fitted with.
    pub rig: Rig,
    /// By channel.
    pub channels: BTreeMap<String, ExtendedChannel>,
}

/// One channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExtendedChannel {
    /// What drove the channel: `spool`, `separate`, `board` (the board's loop, from commands) or
    /// `command` (a regulator).
    pub drive: String,
    /// Noise of the measurement, kPa RMS: in the board's loop it shakes the spool.
    pub noise_kpa: f64,
    /// Command that counts as full drive where a command takes the place of a drive, kPa.
    pub command_range_kpa: f64,
    /// Parameters of the base model by name, in the units of its definition.
    pub parameters: BTreeMap<String, f64>,
    /// Effects at work and their parameters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub effects: BTreeMap<String, BTreeMap<String, f64>>,
    /// Smooth correction of what no effect explains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction: Option<Correction>,
    /// Where 95 % of the readings lie around the simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub band: Option<Band>,
}

/// The file's content for some models.
#[must_use]
pub fn extended_file(channels: &[ChannelData], models: &[Extended], rig: &Rig) -> ExtendedFile {
    let one = |data: &ChannelData, model: &Extended| {
        let names = data.plant.parameters();
        let parameters = names.iter().zip(&model.values).map(|(p, v)| (p.name.clone(), *v)).collect();
        let effects = model.effects.iter().filter_map(|&e| {
            let values = &model.values[model.range(&data.plant, e)?];
            let named = CATALOGUE[e].parameters.iter().zip(values).map(|(p, v)| (p.name.to_owned(), *v));
            Some((CATALOGUE[e].id.to_owned(), named.collect()))
        });
        ExtendedChannel {
            drive: data.driven_by().to_owned(),
            noise_kpa: data.noise_kpa,
            command_range_kpa: data.plant.command_range_pa * 1e-3,
            parameters,
            effects: effects.collect(),
            correction: model.correction.clone(),
            band: Band::of(data, model),
        }
    };
    ExtendedFile {
        schema: SCHEMA.to_owned(),
        model: channels.first().map_or("nonlinear", |d| d.plant.model.name()).to_owned(),
        provenance: None,
        rig: rig.clone(),
        channels: channels.iter().zip(models).map(|(d, m)| (d.id.to_string(), one(d, m))).collect(),
    }
}

/// Of each recording its channels, their models and their file: the share of the readings of all
/// test blocks that the bands hold.
#[must_use]
pub fn band_holds<'a>(
    recordings: impl IntoIterator<Item = (&'a [ChannelData], &'a [Extended], &'a ExtendedFile)>,
) -> Option<f64> {
    let (mut inside, mut count) = (0, 0);
    for (channels, models, file) in recordings {
        for (data, model) in channels.iter().zip(models) {
            let band = file.channels.get(&data.id.to_string()).and_then(|channel| channel.band);
            let held = band.map_or((0, 0), |band| band.held(data, model));
            (inside, count) = (inside + held.0, count + held.1);
        }
    }
    (count > 0).then(|| inside as f64 / count as f64)
}

impl ExtendedFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DiagnosisError::Reference`] when it cannot be read or is of another kind.
    pub fn load(path: &Path) -> Result<Self, DiagnosisError> {
        let file = path.display().to_string();
        let problem = |problem: String| DiagnosisError::Reference { file: file.clone(), problem };
        let text =
            std::fs::read_to_string(path).map_err(|e| problem(format!("cannot be opened: {}", why(&e))))?;
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| problem(e.to_string()))?;
        match table.get("schema").and_then(toml::Value::as_str) {
            Some(SCHEMA) => {
                let read: Self = toml::from_str(&text).map_err(|e| problem(e.to_string()))?;
                Rig::check_within(&file, &text)?;
                Ok(read)
            }
            Some(ParameterFile::SCHEMA) => {
                let fitted = ParameterFile::load(path).map_err(|e| problem(e.to_string()))?;
                Self::of_fit(&fitted).map_err(problem)
            }
            found => Err(problem(format!(
                "schema is {}, expected {SCHEMA} (what `diagnose` writes) or {} (what `fit` writes)",
                found.unwrap_or("missing"),
                ParameterFile::SCHEMA
            ))),
        }
    }

    /// The parameters that `fit` saved, as a model without effects.
    fn of_fit(file: &ParameterFile) -> Result<Self, String> {
        if file.flow_form() == FlowForm::Printed {
            return Err("it was fitted with the printed flow function, which a diagnosis does not simulate; fit again without --flow printed".to_owned());
        }
        let mut channels = BTreeMap::new();
        let mut model = "nonlinear";
        for (id, stored) in &file.channels {
            model = stored.setup.model.name();
            let drive = match (stored.setup.model, stored.setup.controller, stored.setup.drive) {
                (ModelKind::Linear, _, _) => "command",
                (ModelKind::Nonlinear, true, _) => "board",
                (ModelKind::Nonlinear, false, Some(DriveKind::Separate)) => "separate",
                (ModelKind::Nonlinear, false, _) => "spool",
                (other, _, _) => {
                    return Err(format!(
                        "{id} holds the {} model; a diagnosis compares with the nonlinear or the linear one",
                        other.name()
                    ));
                }
            };
            let channel = ExtendedChannel {
                drive: drive.to_owned(),
                // What the fit left is more than noise.
                noise_kpa: stored.noise_kpa.unwrap_or(stored.rms),
                command_range_kpa: 1.0,
                parameters: stored.parameters.iter().map(|p| (p.name.clone(), p.value)).collect(),
                effects: BTreeMap::new(),
                correction: None,
                band: None,
            };
            channels.insert(id.to_string(), channel);
        }
        Ok(Self {
            schema: SCHEMA.to_owned(),
            model: model.to_owned(),
            provenance: Some(file.provenance.clone()),
            rig: file.rig.clone(),
            channels,
        })
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`StoreError`] naming the file.
    pub fn save(&self, path: &Path) -> Result<(), StoreError> {
        let file = path.display().to_string();
        let text = toml::to_string(self).map_err(|e| StoreError::Express { file, message: e.to_string() })?;
        write::text_atomically(path, &text)?;
        Ok(())
    }

    /// The models of some channels, in their order.
    ///
    /// # Errors
    /// [`DiagnosisError::Reference`] when a channel, an effect or a parameter is missing.
    pub fn models(&self, file: &str, channels: &[ChannelData]) -> Result<Vec<Extended>, DiagnosisError> {
        let problem = |problem: String| DiagnosisError::Reference { file: file.to_owned(), problem };
        channels
            .iter()
            .map(|data| {
                let id = data.id.to_string();
                let channel = self.channels.get(&id).ok_or_else(|| {
                    let known: Vec<&str> = self.channels.keys().map(String::as_str).collect();
                    problem(format!("no channel {id}; it holds {}", known.join(", ")))
                })?;
                let value = |map: &BTreeMap<String, f64>, name: &str| match map.get(name) {
                    Some(value) if value.is_finite() => Ok(*value),
                    Some(value) => Err(problem(format!("{id}: parameter {name} is {value}, not a finite number"))),
                    None => Err(problem(format!(
                        "{id} has no parameter {name}, which the {} model of this recording needs; it has {}: was it fitted with another kind of drive or model?",
                        data.plant.model.name(),
                        map.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
                    ))),
                };
                let mut numbered = channel
                    .effects
                    .keys()
                    .map(|e| index_of(e).ok_or_else(|| problem(format!("{id}: no effect is called {e}"))))
                    .collect::<Result<Vec<usize>, _>>()?;
                numbered.sort_unstable();
                let names = data.plant.parameters();
                let mut values = names.iter().map(|p| value(&channel.parameters, &p.name)).collect::<Result<
                    Vec<f64>,
                    _,
                >>(
                )?;
                for &e in &numbered {
                    let map = &channel.effects[CATALOGUE[e].id];
                    for p in CATALOGUE[e].parameters {
                        values.push(value(map, p.name)?);
                    }
                }
                let correction = channel.correction.clone();
                if correction.as_ref().is_some_and(|c| !c.is_usable()) {
                    return Err(problem(format!("{id}: the correction's knots and heights are not usable")));
                }
                Ok(Extended { effects: numbered, values, usual: Vec::new(), correction })
            })
            .collect()
    }
}
