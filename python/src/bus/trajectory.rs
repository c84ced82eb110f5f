//! Trajectories from Python: columns or a file, to be played by the bus thread.

use super::guard::Rules;
use crate::errors::{self, CommandError, FileError};
use crate::toolkit::columns;
use pneudrive_host::poller::VENTED;
use pneudrive_record::trajectory::{AtEnd, Interpolation, Trajectory, TrajectoryError, TrajectorySource};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::ffi::CString;
use std::path::PathBuf;

/// Longest history that a poller keeps, s.
const MOST_KEPT_S: f64 = 3600.0;

/// What is kept beyond a trajectory's end, s: its last cycles.
const BEYOND_S: f64 = 10.0;

/// A path or columns, checked against the boards and their limits.
///
/// # Errors
/// `DataError`, `FileError` or `CommandError`, and what reading the columns raised.
pub fn read(given: &Bound<'_, PyAny>, devices: u16, rules: &Rules) -> PyResult<Trajectory> {
    let py = given.py();
    let is_path = given.is_instance_of::<PyString>() || given.hasattr("__fspath__")?;
    let boards = usize::from(devices);
    let calibration = || rules.calibration.clone();
    let mut ignored = Vec::new();
    let read = if is_path {
        let path: PathBuf = given.extract()?;
        py.detach(|| Trajectory::read(&path, boards, calibration()))
    } else {
        let (commands, others) = columns::commands_of(columns::table(given)?);
        ignored = others;
        let text = columns::csv(&commands)?;
        py.detach(|| Trajectory::parse("trajectory", text.as_bytes(), boards, calibration()))
    };
    let trajectory = read.map_err(|error| match &error {
        TrajectoryError::Unreadable { .. } => FileError::new_err(error.to_string()),
        // The error itself speaks of an option of the command line.
        TrajectoryError::NoSuchChannel { file, column, boards, .. } => errors::unusable(format!(
            "{file}, column {column}: there are boards 0 to {}, each with channels 0 to 3; see num_devices",
            boards - 1
        )),
        _ => errors::unusable(error),
    })?;
    trajectory
        .check(&rules.limits)
        .map_err(|error| CommandError::new_err(format!("trajectory: {error}; nothing was sent")))?;
    ignored.extend_from_slice(trajectory.ignored());
    if !ignored.is_empty() {
        let names = ignored.join(", ");
        let message = CString::new(format!(
            "trajectory: ignored, for they are no commands (b{{n}}_cmd{{k}}_kpa): {names}"
        ))?;
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &message, 1)?;
    }
    Ok(trajectory)
}

/// So many times as fast.
///
/// # Errors
/// `CommandError` for a factor that makes no sense.
pub fn at_speed(trajectory: Trajectory, speed: f64) -> PyResult<Trajectory> {
    if !(1e-3..=1e3).contains(&speed) {
        return Err(CommandError::new_err(format!("speed is {speed}; it must be 0.001 to 1000")));
    }
    Ok(trajectory.with_speed(speed))
}

/// How much of the past is kept so that all of it is there at its end, s.
pub fn kept_s(trajectory: &Trajectory) -> f64 {
    (trajectory.seconds() + BEYOND_S).min(MOST_KEPT_S)
}

/// What the bus thread asks for commands.
///
/// # Errors
/// `CommandError` for words that mean nothing.
pub fn source(
    trajectory: Trajectory,
    interpolation: &str,
    at_end: &str,
    devices: u16,
    rules: &Rules,
) -> PyResult<TrajectorySource> {
    let interpolation = match interpolation {
        "hold" => Interpolation::Hold,
        "linear" => Interpolation::Linear,
        other => return Err(unknown("interpolation", other, "\"hold\" or \"linear\"")),
    };
    let at_end = match at_end {
        "stop" => AtEnd::Stop,
        "hold" => AtEnd::Hold,
        "repeat" => AtEnd::Repeat,
        other => return Err(unknown("at_end", other, "\"stop\", \"hold\" or \"repeat\"")),
    };
    let others = vec![VENTED; usize::from(devices)];
    Ok(trajectory.play(interpolation, at_end, rules.calibration.clone(), others))
}

fn unknown(argument: &str, word: &str, expected: &str) -> PyErr {
    CommandError::new_err(format!("{argument} is {word:?}; it must be {expected}"))
}
