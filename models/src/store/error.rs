//! What can be wrong with a parameter file.

use crate::data::{ChannelId, DataError, why};
use crate::rig::RigError;

/// A parameter file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The file could not be opened.
    #[error("{file}: cannot be opened: {}", why(.source))]
    Open {
        /// The file as given.
        file: String,
        /// The operating system's word.
        source: std::io::Error,
    },
    /// Not TOML or not of this form.
    #[error("{file}: {message}")]
    Syntax {
        /// The file as given.
        file: String,
        /// What the TOML reader said, with line and column.
        message: String,
    },
    /// Another kind of file.
    #[error(
        "{file}: schema is {found}, expected \"{expected}\": this is not a parameter file that `fit` wrote, or one of another version"
    )]
    Schema {
        /// The file as given.
        file: String,
        /// What it says.
        found: String,
        /// What it should say.
        expected: &'static str,
    },
    /// A channel without parameters.
    #[error("{file}: no parameters for channel {channel}; the file has {found}")]
    NoChannel {
        /// The file as given.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// Channels that have some.
        found: String,
    },
    /// The names are not the model's.
    #[error(
        "{file}: channel {channel}: the {model} model has the parameters {expected}, the file has {found}"
    )]
    Parameters {
        /// The file as given.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// The model.
        model: &'static str,
        /// Names of the model.
        expected: String,
        /// Names in the file.
        found: String,
    },
    /// A value that is not finite.
    #[error("{file}: channel {channel}: parameter {name} is {value}; a simulation needs a finite number")]
    NotFinite {
        /// The file as given.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// The parameter.
        name: String,
        /// The value.
        value: f64,
    },
    /// A value that the model cannot have.
    #[error(
        "{file}: channel {channel}: parameter {name} is {value}; the model has it from {lower} to {upper}"
    )]
    Impossible {
        /// The file as given.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// The parameter.
        name: String,
        /// The value.
        value: f64,
        /// Lowest that it can have.
        lower: f64,
        /// Highest.
        upper: f64,
    },
    /// Its rig is none.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// No simulation takes so many steps, or none.
    #[error("{file}: channel {channel}: substeps = {substeps}; 1 to {most} are possible")]
    Substeps {
        /// The file as given.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// What it says.
        substeps: usize,
        /// The most that is accepted.
        most: usize,
    },
    /// The values cannot be expressed in TOML: a defect of this program.
    #[error("{file}: cannot be expressed as TOML: {message}")]
    Express {
        /// The file.
        file: String,
        /// What the TOML writer said.
        message: String,
    },
    /// Writing failed.
    #[error(transparent)]
    Write(#[from] DataError),
}
