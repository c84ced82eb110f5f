//! From Rust's errors to Python's exceptions.

use pneudrive_host::bus::{ExchangeError, OpenBusError};
use pneudrive_host::line::LineError;
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(pneudrive_py.exceptions, CommandError);
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
