//! The rig file: what the machine that made a recording is made of.
//!
//! Every table is optional: a pressure regulator with its own loop needs none of it and is described by the linear
//! model alone. What a table needs is required once the table is there; unknown tables and keys are refused, so that a
//! misspelt key cannot silently leave a nominal value in force.
//!
//! [`Rig::load`] reads and checks; the tables' own methods give the quantities the models work with.

mod chamber;
mod check;
mod controller;
mod environment;
mod error;
mod input_error;
mod inputs;
mod keys;
mod limits;
mod plant;
mod sensor;
mod valve;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use chamber::Chamber;
pub use controller::Controller;
pub use environment::{Ambient, Supply};
pub use error::RigError;
pub use input_error::InputError;
pub use inputs::{Needs, series};
pub use sensor::Sensor;
pub use valve::Valve;

/// The machine, nominally. One description for all boards and channels.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Rig {
    /// Compressed air.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply: Option<Supply>,
    /// The room.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ambient: Option<Ambient>,
    /// The chambers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chamber: Option<Chamber>,
    /// The valves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valve: Option<Valve>,
    /// The pressure loop on the board.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<Controller>,
    /// The pressure sensors and their converter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Sensor>,
    /// Highest pressure that may be commanded to every channel, kPa gauge: the lowest `max_kpa` of the file's limits.
    #[serde(skip)]
    pub highest_set_point_kpa: Option<f64>,
}

impl Rig {
    /// Reads and checks the rig file at `path`.
    ///
    /// # Errors
    /// [`RigError`], naming the file, the key and its value.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let file = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|source| RigError::Open { file: file.clone(), source })?;
        Self::parse(&file, &text)
    }

    /// Checks the content of a rig file; `file` is its name for messages.
    ///
    /// # Errors
    /// [`RigError`], naming the file, the key and its value.
    pub fn parse(file: &str, text: &str) -> Result<Self, RigError> {
        let syntax = |e: toml::de::Error| RigError::Syntax { file: file.to_owned(), message: e.to_string() };
        let mut table: toml::Table = text.parse().map_err(syntax)?;
        let highest_set_point_kpa = limits::take(&mut table, file)?;
        keys::refuse_unknown(file, &table)?;
        let rig: Self = toml::from_str(text).map_err(syntax)?;
        rig.check(file)?;
        Ok(Self { highest_set_point_kpa, ..rig })
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// [`RigError::OutOfRange`] or another that names the key.
    pub fn check(&self, file: &str) -> Result<(), RigError> {
        let checker = check::Checker { file };
        if let Some(supply) = &self.supply {
            supply.check(&checker)?;
        }
        if let Some(ambient) = &self.ambient {
            ambient.check(&checker)?;
        }
        if let Some(chamber) = &self.chamber {
            chamber.check(&checker)?;
        }
        if let Some(valve) = &self.valve {
            valve.check(&checker)?;
        }
        if let Some(controller) = &self.controller {
            controller.check(&checker)?;
        }
        if let Some(sensor) = &self.sensor {
            sensor.check(&checker)?;
        }
        Ok(())
    }

    /// The room, as described or the standard atmosphere at 20 degrees Celsius.
    #[must_use]
    pub fn ambient_or_standard(&self) -> Ambient {
        self.ambient.clone().unwrap_or_default()
    }
}
