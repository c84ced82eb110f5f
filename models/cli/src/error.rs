//! How a command fails, and with which exit status.

use pneudrive_manual::ManualError;
use pneudrive_model::data::import::ImportError;
use pneudrive_model::data::{DataError, InputError};
use pneudrive_model::experiment::{CompareError, FitChannelsError, SplitError};
use pneudrive_model::report::PlotError;
use pneudrive_model::rig::RigError;
use pneudrive_model::simulation::SimulationError;
use pneudrive_model::store::StoreError;

/// A failed command: what to print and the exit status.
#[derive(Debug)]
pub struct Failure {
    message: String,
    status: u8,
}

impl Failure {
    /// Unusable arguments or input: status 2.
    pub fn input(message: impl std::fmt::Display) -> Self {
        Self { message: message.to_string(), status: 2 }
    }

    /// Failed while running: status 1.
    pub fn running(message: impl std::fmt::Display) -> Self {
        Self { message: message.to_string(), status: 1 }
    }

    /// Done, and found what the status stands for: it has been said.
    pub fn finding(status: u8) -> Self {
        Self { message: String::new(), status }
    }

    /// Is there anything left to say?
    pub fn has_message(&self) -> bool {
        !self.message.is_empty()
    }

    /// The exit status.
    pub fn status(&self) -> u8 {
        self.status
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<DataError> for Failure {
    fn from(error: DataError) -> Self {
        match error {
            DataError::Write { .. } => Self::running(error),
            _ => Self::input(error),
        }
    }
}

impl From<ImportError> for Failure {
    fn from(error: ImportError) -> Self {
        match error {
            ImportError::Data(error) => error.into(),
            _ => Self::input(error),
        }
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Write(_) | StoreError::Express { .. } => Self::running(error),
            _ => Self::input(error),
        }
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::input(error)
    }
}

impl From<RigError> for Failure {
    fn from(error: RigError) -> Self {
        Self::input(error)
    }
}

impl From<SplitError> for Failure {
    fn from(error: SplitError) -> Self {
        Self::input(error)
    }
}

impl From<FitChannelsError> for Failure {
    fn from(error: FitChannelsError) -> Self {
        match error {
            FitChannelsError::Fit { .. } => Self::running(error),
            _ => Self::input(error),
        }
    }
}

impl From<CompareError> for Failure {
    fn from(error: CompareError) -> Self {
        Self::input(error)
    }
}

impl From<SimulationError> for Failure {
    fn from(error: SimulationError) -> Self {
        match error {
            SimulationError::Parameters(error) => error.into(),
            SimulationError::Recording(error) => error.into(),
            SimulationError::RunsAway { .. } => Self::running(error),
            _ => Self::input(error),
        }
    }
}

impl From<ManualError> for Failure {
    fn from(error: ManualError) -> Self {
        Self { message: error.to_string(), status: error.exit_status() }
    }
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        Self::running(error)
    }
}
