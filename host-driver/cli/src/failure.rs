use crate::find_boards::NoBoards;
use pneudrive_host::bus::OpenBusError;
use pneudrive_host::line::OpenError;
use pneudrive_host::poller::{PollerPanicked, StartError};
use pneudrive_host::real_time::RealTimeError;
use pneudrive_manual::ManualError;
use pneudrive_record::RecordError;
use pneudrive_virtual::VirtualError;
use std::fmt;
use std::path::Path;

/// Why the program ends without having done what it should.
#[derive(Debug, Clone, PartialEq)]
pub enum Failure {
    /// The arguments or files cannot be used. Nothing has been sent to a board.
    Input(String),
    /// Something failed while running.
    Running(String),
}

impl Failure {
    pub fn input(message: impl fmt::Display) -> Self {
        Self::Input(message.to_string())
    }

    pub fn running(message: impl fmt::Display) -> Self {
        Self::Running(message.to_string())
    }

    pub fn status(&self) -> u8 {
        match self {
            Self::Running(_) => 1,
            Self::Input(_) => 2,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(message) | Self::Running(message) => f.write_str(message),
        }
    }
}

/// A letter more, less or other than in `sim`.
fn is_meant_as_sim(port: &Path) -> bool {
    let name = port.to_str().map(str::to_ascii_lowercase);
    name.is_some_and(|name| strsim::osa_distance(&name, "sim") <= 1)
}

impl From<OpenBusError> for Failure {
    fn from(error: OpenBusError) -> Self {
        match error {
            OpenBusError::Port(OpenError::NotFound { port }) if is_meant_as_sim(&port) => {
                let port = port.display();
                Self::input(format!("{port}: no such port; did you mean --port sim, the virtual boards?"))
            }
            OpenBusError::Port(error) => Self::input(error),
            _ => Self::running(error),
        }
    }
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::UnknownFormat { .. }
            | RecordError::NotABag { .. }
            | RecordError::Exists { .. }
            | RecordError::NotCreated { .. } => Self::input(error),
            _ => Self::running(error),
        }
    }
}

impl From<RealTimeError> for Failure {
    fn from(error: RealTimeError) -> Self {
        Self::input(error)
    }
}

impl From<StartError> for Failure {
    fn from(error: StartError) -> Self {
        Self::running(error)
    }
}

impl From<PollerPanicked> for Failure {
    fn from(error: PollerPanicked) -> Self {
        // The panic's own message stands on standard error.
        Self::running(format!("{error}; see above"))
    }
}

impl From<VirtualError> for Failure {
    fn from(error: VirtualError) -> Self {
        if error.is_input() { Self::input(error) } else { Self::running(error) }
    }
}

impl From<ManualError> for Failure {
    fn from(error: ManualError) -> Self {
        match error {
            ManualError::Folder { .. } => Self::input(error),
            ManualError::Output(_) => Self::running(error),
        }
    }
}

impl From<NoBoards> for Failure {
    fn from(error: NoBoards) -> Self {
        Self::running(error)
    }
}
