//! From Rust's errors to Python's exceptions.

use pneudrive_host::bus::{ExchangeError, OpenBusError};
use pneudrive_host::line::LineError;
use pneudrive_model::data;
use pneudrive_model::experiment::FitChannelsError;
use pneudrive_model::rig::{RigError, RigFileError};
use pneudrive_model::simulation::SimulationError;
use pneudrive_model::store::StoreError;
use pyo3::exceptions::PyException;
use pyo3::import_exception;
use pyo3::prelude::*;
use std::fmt::Display;

import_exception!(pneudrive_py.exceptions, CommandError);
import_exception!(pneudrive_py.exceptions, DataError);
import_exception!(pneudrive_py.exceptions, FileError);
import_exception!(pneudrive_py.exceptions, FitError);
import_exception!(pneudrive_py.exceptions, GarbledAnswerError);
import_exception!(pneudrive_py.exceptions, NoAnswerError);
import_exception!(pneudrive_py.exceptions, PneuDriveError);
import_exception!(pneudrive_py.exceptions, PortError);
import_exception!(pneudrive_py.exceptions, StaleDataError);
import_exception!(pneudrive_py.exceptions, VentWarning);

/// A bus that could not be opened.
pub fn open(error: OpenBusError) -> PyErr {
    PortError::new_err(error.to_string())
}

/// What the bus could not do. Not an exception yet: to make one runs Python code, in which Ctrl-C
/// may raise something else.
#[derive(Debug)]
pub enum BusFailure {
    /// The port failed, or is not to be used now.
    Port(String),
    /// The command is not allowed; nothing was sent.
    Refused(String),
    /// A board did not answer.
    NoAnswer {
        /// Its number.
        board: u8,
        /// What happened.
        message: String,
    },
    /// Something else came than its answer.
    Garbled {
        /// Its number.
        board: u8,
        /// What happened.
        message: String,
    },
    /// What Python code raised, a signal's handler for example.
    Python(PyErr),
}

impl BusFailure {
    /// A line that failed.
    pub fn line(error: &LineError) -> Self {
        Self::Port(error.to_string())
    }

    /// An exchange with `board` that brought no answer.
    pub fn exchange(board: u8, error: &ExchangeError) -> Self {
        let message = error.to_string();
        match error {
            ExchangeError::Line(gone) => Self::line(gone),
            ExchangeError::NoAnswer { .. } => Self::NoAnswer { board, message },
            _ => Self::Garbled { board, message },
        }
    }

    /// Whether it is one board's, so that others can be asked.
    pub fn is_of_a_board(&self) -> bool {
        matches!(self, Self::NoAnswer { .. } | Self::Garbled { .. })
    }

    /// The exception that it becomes.
    pub fn into_exception(self) -> PyErr {
        match self {
            Self::Port(message) => PortError::new_err(message),
            Self::Refused(message) => CommandError::new_err(message),
            Self::NoAnswer { board, message } => NoAnswerError::new_err((message, board)),
            Self::Garbled { board, message } => GarbledAnswerError::new_err((message, board)),
            Self::Python(error) => error,
        }
    }
}

/// `instead` of an ordinary exception; Ctrl-C and exits stay what they are.
pub fn instead_of(py: Python<'_>, error: PyErr, instead: impl FnOnce() -> PyErr) -> PyErr {
    if error.is_instance_of::<PyException>(py) { instead() } else { error }
}

/// Content or arguments that cannot be used.
pub fn unusable(error: impl Display) -> PyErr {
    DataError::new_err(error.to_string())
}

/// A recording that cannot be read, understood or written.
pub fn recording(error: data::DataError) -> PyErr {
    let message = error.to_string();
    match error {
        data::DataError::Open { .. } | data::DataError::Read { .. } | data::DataError::Write { .. } => {
            FileError::new_err(message)
        }
        _ => unusable(message),
    }
}

/// A rig file that cannot be read or understood.
pub fn rig(error: RigError) -> PyErr {
    match &error {
        RigError::File(RigFileError::Open { .. }) => FileError::new_err(error.to_string()),
        _ => unusable(error),
    }
}

/// A parameter file that cannot be read, understood or written.
pub fn store(error: StoreError) -> PyErr {
    match &error {
        StoreError::Open { .. } | StoreError::Write(_) => FileError::new_err(error.to_string()),
        _ => unusable(error),
    }
}

/// A recording that cannot be simulated.
pub fn simulation(error: SimulationError) -> PyErr {
    match error {
        SimulationError::Parameters(error) => store(error),
        SimulationError::Recording(error) => recording(error),
        SimulationError::RunsAway { .. } => PneuDriveError::new_err(error.to_string()),
        _ => unusable(error),
    }
}

/// A recording that cannot be fitted.
pub fn fit(error: FitChannelsError) -> PyErr {
    match &error {
        FitChannelsError::Fit { .. } => FitError::new_err(error.to_string()),
        _ => unusable(error),
    }
}
