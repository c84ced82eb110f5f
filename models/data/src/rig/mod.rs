//! The rig file: what the machine that made a recording is made of.
//!
//! Every table is optional: a pressure regulator with its own loop needs none of it and is
//! described by the linear model alone. What a table needs is required once the table is there;
//! unknown tables and keys are refused, so that a misspelt key cannot silently leave a nominal
//! value in force.
//!
//! The format, its ranges and its messages are those of the crate `pneudrive_rig`, which the host
//! reads the same file with. Here are the tables as the models work with them, and [`Rig::at`]: the
//! machine as one channel has it.

mod chamber;
mod controller;
mod differences;
mod environment;
mod error;
mod own;
mod plant;
mod sensor;
mod valve;

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use chamber::Chamber;
pub use controller::Controller;
pub use environment::{Ambient, Supply};
pub use error::RigError;
pub use own::{Calibration, OwnOfBoard, OwnOfChannel};
pub use pneudrive_rig::RigError as RigFileError;
pub use sensor::Sensor;
pub use valve::Valve;

/// The machine, nominally.
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
    /// What boards and channels have of their own, by the boards' numbers: see [`Rig::at`].
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub boards: BTreeMap<u8, OwnOfBoard>,
    /// Highest pressure that may be commanded to every channel, kPa gauge: the lowest `max_kpa` of
    /// the file's limits.
    #[serde(skip)]
    pub highest_set_point_kpa: Option<f64>,
}

impl Rig {
    /// Pressure of the supply, kPa gauge, where the file has one.
    #[must_use]
    pub fn supply_kpa(&self) -> Option<f64> {
        self.supply.as_ref().map(|supply| supply.pressure_kpa)
    }

    /// Reads and checks the rig file at `path`.
    ///
    /// # Errors
    /// [`RigError`], naming the file, the line, the key and what is expected.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        Self::of(&pneudrive_rig::Rig::load(path)?)
    }

    /// Checks the content of a rig file; `file` is its name for messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(file: &str, text: &str) -> Result<Self, RigError> {
        Self::of(&pneudrive_rig::Rig::parse(file, text)?)
    }

    fn of(read: &pneudrive_rig::Rig) -> Result<Self, RigError> {
        // Every value has been checked: what could fail here is a key that the format and these
        // structures do not share.
        let mut rig: Self = toml::from_str(read.text()).map_err(|error| RigFileError::Syntax {
            file: read.file().to_owned(),
            line: 1,
            problem: error.message().to_owned(),
        })?;
        rig.highest_set_point_kpa = read.lowest_max_kpa();
        rig.keep_own();
        Ok(rig)
    }

    /// Checks the table `[rig]` of a file that holds a rig beside other things, as what `fit` and
    /// `diagnose` save.
    ///
    /// # Errors
    /// As [`load`](Self::load), with the lines of that file.
    pub fn check_within(file: &str, text: &str) -> Result<(), RigError> {
        Ok(pneudrive_rig::Rig::check_table(file, text, "rig")?)
    }

    /// The room, as described or the standard atmosphere at 20 degrees Celsius.
    #[must_use]
    pub fn ambient_or_standard(&self) -> Ambient {
        self.ambient.clone().unwrap_or_default()
    }
}
