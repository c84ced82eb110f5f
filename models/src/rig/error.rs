//! Why a rig cannot be used.

use pneudrive_rig::RigError as RigFileError;

/// A rig file that cannot be used, or that lacks what is asked of it.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The file: it names the line, the key and what is expected.
    #[error(transparent)]
    File(#[from] RigFileError),
    /// The rig file lacks a table that the chosen work needs.
    #[error("the rig file has no table [{table}], which {purpose} needs")]
    MissingTable {
        /// The table's name.
        table: &'static str,
        /// What needs it.
        purpose: &'static str,
    },
}
