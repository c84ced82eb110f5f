//! How the node fails, and with which exit status.

use pneudrive_record::RecordError;
use pneudrive_virtual::VirtualError;
use std::fmt::Display;
use std::process::ExitCode;

/// Why the node ended otherwise than it was told to.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    message: String,
    status: u8,
}

impl Failure {
    /// The arguments cannot be used. Nothing has been sent to a board.
    pub fn input(message: impl Display) -> Self {
        Self { message: message.to_string(), status: 2 }
    }

    /// Something failed.
    pub fn running(message: impl Display) -> Self {
        Self { message: message.to_string(), status: 1 }
    }

    /// The process's exit status.
    pub fn status(&self) -> ExitCode {
        ExitCode::from(self.status)
    }
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Write { .. } | RecordError::TooSlow { .. } => Self::running(error),
            _ => Self::input(error),
        }
    }
}

impl From<VirtualError> for Failure {
    fn from(error: VirtualError) -> Self {
        if error.is_input() { Self::input(error) } else { Self::running(error) }
    }
}
