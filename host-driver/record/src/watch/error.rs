//! Why nothing is watched.

use std::path::PathBuf;
use thiserror::Error;

/// Why a watch could not be started.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum WatchError {
    /// The program is neither beside this one nor on the search path.
    #[error(
        "{program}: not found beside this program nor in PATH; it runs the calibrated model: install it \
         (cargo install --path models), or say where it is"
    )]
    NoProgram {
        /// Its name.
        program: String,
    },
    /// The program was found and could not be started.
    #[error("{}: {reason}", program.display())]
    NotStarted {
        /// The program.
        program: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The program refused the model, or these boards.
    #[error("{}: {reason}", parameters.display())]
    Refused {
        /// The calibrated model.
        parameters: PathBuf,
        /// What the program says.
        reason: String,
    },
}
