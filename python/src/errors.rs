//! From Rust's errors to Python's exceptions.

use pneudrive_host::bus::{ExchangeError, OpenBusError};
use pneudrive_host::line::LineError;
use pneudrive_model::data;
use pneudrive_model::experiment::FitChannelsError;
use pneudrive_model::rig::RigError;
use pneudrive_model::store::StoreError;
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

/// A bus that could not be opened.
pub fn open(error: OpenBusError) -> PyErr {
    PortError::new_err(error.to_string())
}

/// A line that failed.
pub fn line(error: &LineError) -> PyErr {
    PortError::new_err(error.to_string())
}

/// An exchange with `board` that brought no answer.
pub fn exchange(board: u8, error: &ExchangeError) -> PyErr {
    let message = error.to_string();
    match error {
        ExchangeError::Line(gone) => line(gone),
        ExchangeError::NoAnswer { .. } => NoAnswerError::new_err((message, board)),
        _ => GarbledAnswerError::new_err((message, board)),
    }
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
        RigError::Open { .. } => FileError::new_err(error.to_string()),
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

/// A recording that cannot be fitted.
pub fn fit(error: FitChannelsError) -> PyErr {
    match &error {
        FitChannelsError::Fit { .. } => FitError::new_err(error.to_string()),
        _ => unusable(error),
    }
}
