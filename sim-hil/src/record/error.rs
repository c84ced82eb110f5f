//! What can go wrong with a recording.

use std::path::PathBuf;

use crate::plant::{EffectError, PlantError, with_unit};

/// A recording that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// A setting is outside its range.
    #[error("{name} is {}: expected {expected}", with_unit(*value, unit))]
    Setting {
        /// The setting.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
        /// The range that is accepted.
        expected: &'static str,
    },
    /// Columns for set points that there are none of.
    #[error("an open-loop recording has no set points: switch columns.command off")]
    NoSetPoints,
    /// The plant cannot be built.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// An effect cannot be read.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// The control crate refuses the gains.
    #[error("control: {0}")]
    Control(#[from] pneudrive_control::ConfigError),
    /// The output's name does not say how to write it.
    #[error("{}: expected a name that ends in .csv, .csv.gz or .csv.zst", path.display())]
    Extension {
        /// The file asked for.
        path: PathBuf,
    },
    /// The output is there already.
    #[error("{}: exists; choose another name, or pass --overwrite", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Recording and rig description would be one file, and one of them lost.
    #[error("{}: --out and --rig-out are the same file; choose another name for one of them", path.display())]
    SameFile {
        /// The file.
        path: PathBuf,
    },
    /// A file cannot be made.
    #[error("{}: cannot be created: {reason}", path.display())]
    NotCreated {
        /// The file.
        path: PathBuf,
        /// What stands in the way.
        reason: String,
    },
    /// It was told to stop; nothing is left of the file.
    #[error("{}: interrupted, and not written", path.display())]
    Interrupted {
        /// The file.
        path: PathBuf,
    },
    /// A file cannot be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The rig's description cannot be written as TOML.
    #[error("rig description: {0}")]
    Toml(#[from] toml::ser::Error),
}

impl RecordError {
    /// Exit status of a program that ends with this error: 2 for unusable arguments, 1 for a
    /// failure while running.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Setting { .. }
            | Self::NoSetPoints
            | Self::Plant(_)
            | Self::Effect(_)
            | Self::Control(_)
            | Self::Extension { .. }
            | Self::Exists { .. }
            | Self::SameFile { .. }
            | Self::NotCreated { .. } => 2,
            Self::Interrupted { .. } | Self::Write { .. } | Self::Toml(_) => 1,
        }
    }
}
