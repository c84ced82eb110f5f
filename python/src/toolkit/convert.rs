//! Results as Python objects: dictionaries by way of JSON, tables for notebooks, where files come
//! from.

use crate::errors::PneuDriveError;
use crate::types::{Array, Dict, Vector};
use numpy::PyArray1;
use pneudrive_model::data::Source;
use pneudrive_model::experiment::{Origin, Score};
use pneudrive_model::report::{Align, Table, number};
use pneudrive_model::store::{Provenance, RigSource};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

/// The object that `value` is in the JSON files of the command line: dictionaries, lists, `None`
/// for what is not finite.
pub fn object<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| PneuDriveError::new_err(error.to_string()))?;
    parsed(py, &text)
}

/// JSON as dictionaries, lists, numbers and texts.
pub fn parsed<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}

/// The serialisable value that a Python object is in JSON.
pub fn value(object: &Bound<'_, PyAny>) -> PyResult<serde_json::Value> {
    let text: String = object.py().import("json")?.call_method1("dumps", (object,))?.extract()?;
    serde_json::from_str(&text).map_err(|error| PneuDriveError::new_err(error.to_string()))
}

/// Single precision as recordings keep it, as a float64 array.
pub fn widened<'py>(py: Python<'py>, values: &[f32]) -> Vector<'py> {
    Array(PyArray1::from_iter(py, values.iter().map(|value| f64::from(*value))))
}

/// An error of a simulation by its measures, or `None` where there is nothing to compare with.
pub type ScoreDict<'py> = Option<Dict<'py, Bound<'py, PyAny>>>;

/// A score, or `None`.
pub fn score<'py>(py: Python<'py>, score: Option<&Score>) -> PyResult<ScoreDict<'py>> {
    let Some(score) = score else { return Ok(None) };
    let dict = PyDict::new(py);
    dict.set_item("r2", score.r2)?;
    dict.set_item("rmse_kpa", score.rmse_kpa)?;
    dict.set_item("mae_kpa", score.mae_kpa)?;
    dict.set_item("iae_kpa_s", score.iae_kpa_s)?;
    dict.set_item("largest_kpa", score.largest_kpa)?;
    dict.set_item("samples", score.samples)?;
    dict.set_item("seconds", score.seconds)?;
    Ok(Some(Dict::new(dict)))
}

/// A score's error for a table.
pub fn rmse(score: Option<&Score>) -> String {
    score.map_or_else(|| "-".to_owned(), |score| number(score.rmse_kpa, 3))
}

/// A table for notebooks: the first `words` columns to the left, numbers to the right.
pub fn table(head: &[&str], words: usize, rows: &[Vec<String>]) -> Table {
    let columns: Vec<(&str, Align)> = head
        .iter()
        .enumerate()
        .map(|(k, name)| (*name, if k < words { Align::Left } else { Align::Right }))
        .collect();
    let mut table = Table::new(&columns);
    for row in rows {
        table.row(row);
    }
    table
}

/// Program and date; `call` is the function that was called.
pub fn origin(py: Python<'_>, call: &str) -> PyResult<Origin> {
    let datetime = py.import("datetime")?;
    let utc = datetime.getattr("timezone")?.getattr("utc")?;
    let now = datetime.getattr("datetime")?.call_method1("now", (utc,))?;
    let options = PyDict::new(py);
    options.set_item("timespec", "seconds")?;
    let created: String = now.call_method("isoformat", (), Some(&options))?.extract()?;
    let program = concat!("pneudrive_py ", env!("CARGO_PKG_VERSION")).to_owned();
    Ok(Origin { program, created: created.replace("+00:00", "Z"), command: format!("pneudrive_py.{call}()") })
}

/// Where parameters come from.
pub fn provenance(
    py: Python<'_>,
    call: &str,
    data: &Source,
    rig_file: Option<String>,
) -> PyResult<Provenance> {
    let Origin { program, created, command } = origin(py, call)?;
    let rig = rig_file.map(|file| RigSource { file });
    Ok(Provenance { program, created, command, data: data.clone(), rig })
}
