//! Commands from Python: four pressures that can be reached, or an error that says which one cannot.

use crate::errors::CommandError;
use numpy::{AllowTypeChange, PyArrayLike1};
use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use pyo3::prelude::*;

/// What pressures mean on the bus: the original's sensor.
pub const SCALE: SensorScale = SensorScale::ORIGINAL;

/// Four pressures, kPa gauge, as counts.
///
/// Takes whatever NumPy can make a float array of shape (4,) of.
pub fn counts(board: u8, pressures: &Bound<'_, PyAny>) -> PyResult<[Counts; CHANNELS]> {
    let wrong = |got: String| {
        CommandError::new_err(format!("board {board}: expected {CHANNELS} pressures in kPa, got {got}"))
    };
    let array: PyArrayLike1<'_, f64, AllowTypeChange> =
        pressures.extract().map_err(|_| wrong(describe(pressures)))?;
    let array = array.as_array();
    if array.len() != CHANNELS {
        return Err(wrong(format!("{} of them", array.len())));
    }
    let mut counts = [Counts::ATMOSPHERE; CHANNELS];
    for (channel, (slot, kpa)) in counts.iter_mut().zip(array.iter()).enumerate() {
        *slot = SCALE.counts(*kpa).map_err(|error| {
            CommandError::new_err(format!("board {board}, channel {channel}: {error}; nothing was sent"))
        })?;
    }
    Ok(counts)
}

/// The board with this number, if there are so many.
pub fn board(number: i64, devices: u16) -> PyResult<u8> {
    match u8::try_from(number) {
        Ok(board) if u16::from(board) < devices => Ok(board),
        _ => Err(CommandError::new_err(format!(
            "there is no board {number}: this controller has {devices}, counted from 0"
        ))),
    }
}

fn describe(value: &Bound<'_, PyAny>) -> String {
    let shape =
        value.getattr("shape").and_then(|shape| shape.str()).map(|shape| format!(" of shape {shape}"));
    let class = value.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
    format!("{class}{}", shape.unwrap_or_default())
}
