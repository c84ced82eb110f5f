//! A model with its parameters, whoever found them.

use std::path::Path;
use std::sync::Arc;

use crate::diagnosis::{EXTENDED_SCHEMA, ExtendedFile};
use crate::rig::Rig;
use crate::store::ParameterFile;

use super::error::SimulationError;

/// A model of a rig's channels with its parameters. Copies share them.
#[derive(Debug, Clone)]
pub enum CalibratedModel {
    /// What `fit` saves.
    Fitted {
        /// Where it is from, for messages: a file's name.
        name: String,
        /// The parameters.
        file: Arc<ParameterFile>,
    },
    /// What `diagnose` saves: a base model with effects.
    Extended {
        /// Where it is from, for messages: a file's name.
        name: String,
        /// The models.
        file: Arc<ExtendedFile>,
    },
}

impl CalibratedModel {
    /// Reads the parameter file of a fit, or the extended model of a diagnosis.
    ///
    /// # Errors
    /// [`SimulationError`], naming the file and what is wrong in it.
    pub fn load(path: &Path) -> Result<Self, SimulationError> {
        let name = path.display().to_string();
        if is_extended(path) {
            return Ok(Self::Extended { name, file: Arc::new(ExtendedFile::load(path)?) });
        }
        Ok(Self::Fitted { name, file: Arc::new(ParameterFile::load(path)?) })
    }

    /// The rig it was calibrated with.
    #[must_use]
    pub fn rig(&self) -> &Rig {
        match self {
            Self::Fitted { file, .. } => &file.rig,
            Self::Extended { file, .. } => &file.rig,
        }
    }
}

impl From<ParameterFile> for CalibratedModel {
    fn from(file: ParameterFile) -> Self {
        Self::Fitted { name: "parameters".to_owned(), file: Arc::new(file) }
    }
}

impl From<ExtendedFile> for CalibratedModel {
    fn from(file: ExtendedFile) -> Self {
        Self::Extended { name: "extended model".to_owned(), file: Arc::new(file) }
    }
}

/// Does the file say that it is the extended model of a diagnosis? What cannot be read says
/// nothing; loading it then says why.
fn is_extended(path: &Path) -> bool {
    let table = std::fs::read_to_string(path).ok().and_then(|text| text.parse::<toml::Table>().ok());
    table.is_some_and(|t| t.get("schema").and_then(toml::Value::as_str) == Some(EXTENDED_SCHEMA))
}
