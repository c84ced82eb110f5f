//! Exchanges by hand, one after the other.

use super::link::Link;
use crate::errors::{BusFailure, CommandError, NoAnswerError};
use numpy::{PyArray2, PyArrayMethods};
use pneudrive_protocol::{CHANNELS, Counts};
use pyo3::prelude::*;
use std::time::{Duration, Instant};

/// Pressures of all boards, kPa gauge, shape (boards, channels).
type Pressures<'py> = Bound<'py, PyArray2<f64>>;

/// One exchange, without the interpreter's lock.
pub fn exchange(
    py: Python<'_>,
    link: &Link,
    board: u8,
    commands: [Counts; CHANNELS],
    retries: u32,
) -> Result<[f64; CHANNELS], BusFailure> {
    py.detach(|| link.exchange(board, commands, retries))
}

/// Commands 0 kPa to every board until all have answered.
///
/// # Errors
/// `NoAnswerError` naming the boards that did not answer within `timeout` (s); whatever Ctrl-C
/// raises.
pub fn ping(py: Python<'_>, link: &Link, timeout: f64) -> PyResult<()> {
    let patience = Duration::try_from_secs_f64(timeout)
        .map_err(|_| CommandError::new_err(format!("timeout is {timeout} s; it must be 0 or more")))?;
    let deadline = Instant::now() + patience;
    let devices = link.devices();
    let mut missing: Vec<u8> = (0..=u8::MAX).take(usize::from(devices)).collect();
    loop {
        let mut still_missing = Vec::new();
        for &board in &missing {
            match exchange(py, link, board, [Counts::ATMOSPHERE; CHANNELS], 0) {
                Ok(_) => {}
                Err(failure) if failure.is_of_a_board() => still_missing.push(board),
                Err(failure) => return Err(failure.into()),
            }
            py.check_signals()?;
        }
        missing = still_missing;
        let Some(&first) = missing.first() else { return Ok(()) };
        if Instant::now() >= deadline {
            let message = format!(
                "no answer from {} of {devices} boards ({missing:?}) within {timeout} s; check power, wiring and address switches",
                missing.len(),
            );
            return Err(NoAnswerError::new_err((message, first)));
        }
        py.detach(|| std::thread::sleep(Duration::from_millis(10)));
    }
}

/// Commands every board and gives what all measured.
///
/// # Errors
/// The first exchange that failed; the boards after it are still commanded.
pub fn exchange_all<'py>(
    py: Python<'py>,
    link: &Link,
    commands: Vec<(u8, [Counts; CHANNELS])>,
    retries: u32,
) -> PyResult<Pressures<'py>> {
    let mut first_failure = None;
    let measured = PyArray2::zeros(py, [commands.len(), CHANNELS], false);
    for (board, counts) in commands {
        py.check_signals()?;
        match exchange(py, link, board, counts, retries) {
            Ok(kpa) => fill(&measured, board, kpa),
            Err(failure) if failure.is_of_a_board() => first_failure = first_failure.or(Some(failure)),
            Err(failure) => return Err(failure.into()),
        }
    }
    first_failure.map_or(Ok(measured), |failure| Err(failure.into()))
}

/// What all boards sent in their last exchanges; NaN where that failed.
pub fn readings<'py>(py: Python<'py>, link: &Link) -> Pressures<'py> {
    let measured = PyArray2::zeros(py, [usize::from(link.devices()), CHANNELS], false);
    for board in (0..=u8::MAX).take(usize::from(link.devices())) {
        fill(&measured, board, link.reading(board).unwrap_or([f64::NAN; CHANNELS]));
    }
    measured
}

fn fill(measured: &Pressures<'_>, board: u8, kpa: [f64; CHANNELS]) {
    for (channel, value) in kpa.into_iter().enumerate() {
        measured.readwrite().as_array_mut()[[usize::from(board), channel]] = value;
    }
}
