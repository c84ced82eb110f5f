//! Why a rig cannot be used.

use pneudrive_rig::RigError as RigFileError;

/// A rig file that cannot be used, or that lacks what is asked of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The file: it names the line, the key and what is expected.
    #[error(transparent)]
    File(#[from] RigFileError),
    /// No rig file is given, or it lacks a table that the chosen work needs.
    #[error(
        "{purpose} needs the table [{table}] of a rig file: give one that has it (--rig, in Python rig=), or use the linear model"
    )]
    MissingTable {
        /// The table's name.
        table: &'static str,
        /// What needs it.
        purpose: &'static str,
    },
}
