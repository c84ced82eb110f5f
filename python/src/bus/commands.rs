//! Commands from Python: four pressures that can be reached, or an error that says which one
//! cannot.

use super::guard::Rules;
use crate::arrays::{Floats, floats, shape_text};
use crate::errors::CommandError;
use numpy::PyUntypedArrayMethods;
use pneudrive_protocol::{CHANNELS, Counts};
use pyo3::prelude::*;

/// Four pressures, kPa gauge, as counts.
///
/// Takes whatever NumPy can make a float array of shape (4,) of, within `rules`.
pub fn counts(board: u8, pressures: &Bound<'_, PyAny>, rules: &Rules) -> PyResult<[Counts; CHANNELS]> {
    let wrong = |got: &str| {
        CommandError::new_err(format!(
            "pressures of board {board}: expected {CHANNELS} numbers in kPa, shape ({CHANNELS},), got {got}"
        ))
    };
    let array = floats(pressures, wrong)?;
    if array.shape() != [CHANNELS] {
        return Err(wrong(&format!("shape {}", shape_text(array.shape()))));
    }
    of_board(board, &values(&array), rules)
}

/// Pressures of all boards, kPa gauge, as counts: of shape (devices, 4), or what broadcasts to it,
/// (4,) or ().
pub fn of_all(
    devices: u16,
    pressures: &Bound<'_, PyAny>,
    rules: &Rules,
) -> PyResult<Vec<(u8, [Counts; CHANNELS])>> {
    let wrong = |got: &str| {
        CommandError::new_err(format!(
            "pressures: expected numbers in kPa, shape ({devices}, {CHANNELS}), got {got}"
        ))
    };
    let array = floats(pressures, wrong)?;
    let values = values(&array);
    let of = |board: usize, channel: usize| match *array.shape() {
        [] => Some(values[0]),
        [CHANNELS] => Some(values[channel]),
        [boards, CHANNELS] if boards == usize::from(devices) => Some(values[CHANNELS * board + channel]),
        _ => None,
    };
    if of(0, 0).is_none() {
        return Err(wrong(&format!("shape {}", shape_text(array.shape()))));
    }
    let boards = (0..=u8::MAX).take(usize::from(devices));
    let counts = boards.map(|board| {
        let kpa: [f64; CHANNELS] =
            std::array::from_fn(|channel| of(usize::from(board), channel).unwrap_or(f64::NAN));
        Ok((board, of_board(board, &kpa, rules)?))
    });
    counts.collect()
}

/// In the order of the rows, whatever the array's strides.
fn values(array: &Floats<'_>) -> Vec<f64> {
    array.as_array().iter().copied().collect()
}

fn of_board(board: u8, kpa: &[f64], rules: &Rules) -> PyResult<[Counts; CHANNELS]> {
    let Rules { limits, calibration, .. } = rules;
    let mut counts = [Counts::ATMOSPHERE; CHANNELS];
    for (channel, (slot, kpa)) in counts.iter_mut().zip(kpa).enumerate() {
        let scale = calibration.channel(board, channel);
        *slot = scale.counts(*kpa).map_err(|error| {
            CommandError::new_err(format!("board {board}, channel {channel}: {error}; nothing was sent"))
        })?;
        limits
            .check(board, channel, *kpa)
            .map_err(|refused| CommandError::new_err(format!("{refused}; nothing was sent")))?;
        // Rounded to the nearest count, it may be above the limit.
        *slot = limits.of(board)[channel].highest(scale).min(*slot);
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

/// Boards, as displays say how many.
pub fn counted(boards: u16) -> String {
    format!("{boards} {}", if boards == 1 { "board" } else { "boards" })
}
