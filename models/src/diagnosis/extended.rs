//! `extended.toml`: the extended model as a file that can be simulated.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::channel::{ChannelData, Extended};
use super::error::DiagnosisError;
use crate::effects::catalogue::{CATALOGUE, index_of};
use crate::rig::Rig;

/// Name of the format.
pub const SCHEMA: &str = "pneudrive-extended/1";

/// The file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExtendedFile {
    /// `pneudrive-extended`, with its version.
    pub schema: String,
    /// Base model: `nonlinear` or `linear`.
    pub model: String,
    /// The rig it was fitted with.
    pub rig: Rig,
    /// By channel.
    pub channels: BTreeMap<String, ExtendedChannel>,
}

/// One channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExtendedChannel {
    /// Parameters of the base model by name, in the units of its definition.
    pub parameters: BTreeMap<String, f64>,
    /// Effects at work and their parameters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub effects: BTreeMap<String, BTreeMap<String, f64>>,
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
        ExtendedChannel { parameters, effects: effects.collect() }
    };
    ExtendedFile {
        schema: SCHEMA.to_owned(),
        model: channels.first().map_or("nonlinear", |d| d.plant.name()).to_owned(),
        rig: rig.clone(),
        channels: channels.iter().zip(models).map(|(d, m)| (d.id.to_string(), one(d, m))).collect(),
    }
}

impl ExtendedFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DiagnosisError::Reference`] when it cannot be read or is of another kind.
    pub fn load(path: &Path) -> Result<Self, DiagnosisError> {
        let file = path.display().to_string();
        let problem = |problem: String| DiagnosisError::Reference { file: file.clone(), problem };
        let text = std::fs::read_to_string(path).map_err(|e| problem(e.to_string()))?;
        let read: Self = toml::from_str(&text).map_err(|e| problem(e.to_string()))?;
        if read.schema == SCHEMA {
            Ok(read)
        } else {
            Err(problem(format!("schema is {}, expected {SCHEMA}", read.schema)))
        }
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
                let value = |map: &BTreeMap<String, f64>, name: &str| {
                    map.get(name).copied().ok_or_else(|| problem(format!("{id} has no parameter {name}")))
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
                Ok(Extended { effects: numbered, values })
            })
            .collect()
    }
}
