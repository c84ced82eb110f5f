//! Commands from Python: four pressures that can be reached, or an error that says which one cannot.

use super::guard::Rules;
use crate::errors::{self, CommandError};
use numpy::{AllowTypeChange, PyArrayLike1};
use pneudrive_protocol::{CHANNELS, Counts};
use pyo3::prelude::*;

/// Four pressures, kPa gauge, as counts.
///
/// Takes whatever NumPy can make a float array of shape (4,) of, within `rules`.
pub fn counts(board: u8, pressures: &Bound<'_, PyAny>, rules: &Rules) -> PyResult<[Counts; CHANNELS]> {
    let wrong = |got: String| {
        CommandError::new_err(format!("board {board}: expected {CHANNELS} pressures in kPa, got {got}"))
    };
    let array: PyArrayLike1<'_, f64, AllowTypeChange> = match pressures.extract() {
        Ok(array) => array,
        Err(error) => {
            let got = describe(pressures)?;
            return Err(errors::instead_of(pressures.py(), error, || wrong(got)));
        }
    };
    let array = array.as_array();
    if array.len() != CHANNELS {
        return Err(wrong(format!("{} of them", array.len())));
    }
    let Rules { limits, calibration, .. } = rules;
    let mut counts = [Counts::ATMOSPHERE; CHANNELS];
    for (channel, (slot, kpa)) in counts.iter_mut().zip(array.iter()).enumerate() {
        let scale = calibration.channel(board, channel);
        *slot = scale.counts(*kpa).map_err(|error| {
            CommandError::new_err(format!("board {board}, channel {channel}: {error}; nothing was sent"))
        })?;
        limits
            .check(board, channel, *kpa)
            .map_err(|refused| CommandError::new_err(format!("{refused}; nothing was sent")))?;
        let max_kpa = limits.of(board)[channel].max_kpa;
        if scale.kpa(*slot) > max_kpa && *slot > Counts::ATMOSPHERE {
            // Rounded to the nearest count, it would be above the limit.
            *slot = Counts::saturating(slot.get() - 1);
        }
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

fn describe(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let class = value.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
    match value.getattr_opt("shape")? {
        Some(shape) => Ok(format!("{class} of shape {}", shape.str()?)),
        None => Ok(class),
    }
}
