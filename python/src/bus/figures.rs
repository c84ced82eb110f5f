//! What a poller saw, as dicts.

use super::guard::Rules;
use crate::errors::PneuDriveError;
use crate::types::Dict;
use numpy::PyArray2;
use pneudrive_host::poller::{Outcome, Snapshot};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::CHANNELS;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A cycle as ``Poller.wait`` returns it.
pub fn row_as_dict<'py>(
    py: Python<'py>,
    row: &Snapshot,
    rules: &Rules,
) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
    let matrix = |rows: Vec<Vec<f64>>| {
        PyArray2::from_vec2(py, &rows).map_err(|error| PneuDriveError::new_err(error.to_string()))
    };
    let commands =
        row.boards.iter().map(|one| rules.calibration.command_kpa(one.board, one.command).to_vec());
    let pressures = row.boards.iter().map(|one| match (one.outcome, one.reading) {
        (Outcome::Fresh, Some(reading)) => reading.kpa.to_vec(),
        _ => vec![f64::NAN; CHANNELS],
    });
    let dict = PyDict::new(py);
    dict.set_item("cycle", row.cycle)?;
    dict.set_item("t_s", row.since_start_ns as f64 * 1e-9)?;
    dict.set_item("commands_kpa", matrix(commands.collect())?)?;
    dict.set_item("pressures_kpa", matrix(pressures.collect())?)?;
    Ok(Dict::new(dict))
}

/// Figures as ``Poller.statistics`` returns them.
pub fn as_dict<'py>(py: Python<'py>, statistics: &Statistics) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
    let loop_hz = PyDict::new(py);
    loop_hz.set_item("mean", statistics.loop_hz.mean)?;
    loop_hz.set_item("std", statistics.loop_hz.std)?;
    loop_hz.set_item("min", statistics.loop_hz.min)?;
    let cycle_us = PyDict::new(py);
    cycle_us.set_item("p50", statistics.cycle_us.p50)?;
    cycle_us.set_item("p99", statistics.cycle_us.p99)?;
    cycle_us.set_item("p999", statistics.cycle_us.p999)?;
    cycle_us.set_item("max", statistics.cycle_us.max)?;
    let dict = PyDict::new(py);
    dict.set_item("devices", statistics.devices)?;
    dict.set_item("seconds", statistics.seconds)?;
    dict.set_item("baud", statistics.baud)?;
    dict.set_item("cycles", statistics.cycles)?;
    dict.set_item("loop_hz", loop_hz)?;
    dict.set_item("cycle_us", cycle_us)?;
    dict.set_item("exchanges", statistics.exchanges)?;
    dict.set_item("lost", statistics.lost)?;
    dict.set_item("rejected", statistics.rejected)?;
    dict.set_item("missed_ticks", statistics.missed_ticks)?;
    dict.set_item("cpu_share", statistics.cpu_share)?;
    Ok(Dict::new(dict))
}
