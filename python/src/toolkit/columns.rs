//! Columns from Python as the content of a file, so that one set of checks holds for both; and
//! columns of a recording.

use crate::arrays::{floats, shape_text};
use crate::errors;
use numpy::PyUntypedArrayMethods;
use pneudrive_model::data::{BoardSupply, Drive, Recording};
use pneudrive_record::trajectory::ColumnName;
use pyo3::prelude::*;
use std::fmt::Write as _;

/// Names and values.
pub type Columns = Vec<(String, Vec<f64>)>;

/// Columns of a mapping from names to arrays of shape (rows,), a DataFrame or a recording.
///
/// # Errors
/// `DataError` for anything else, and what reading it raised.
pub fn table(columns: &Bound<'_, PyAny>) -> PyResult<Columns> {
    let py = columns.py();
    let wrong = |error: PyErr| {
        let advice = "expected a mapping from column names to arrays, or a DataFrame";
        errors::instead_of(py, error, || errors::unusable(advice))
    };
    let names =
        columns.call_method0("keys").and_then(|keys| keys.try_iter()?.map(|key| key?.extract()).collect());
    let names: Vec<String> = names.map_err(wrong)?;
    let mut table: Columns = Vec::with_capacity(names.len());
    for name in names {
        let values = columns.get_item(&name)?;
        let unfit = |got: &str| {
            errors::unusable(format!("column {name}: expected numbers of shape (rows,), got {got}"))
        };
        let array = floats(&values, unfit)?;
        if array.ndim() != 1 {
            return Err(unfit(&format!("shape {}", shape_text(array.shape()))));
        }
        let values = array.as_array().iter().copied().collect();
        table.push((name, values));
    }
    Ok(table)
}

/// Time and set points: what of a recording a trajectory is made of. And the names of columns that
/// are neither a trajectory's nor a recording's.
pub fn commands_of(table: Columns) -> (Columns, Vec<String>) {
    let (mut kept, mut ignored) = (Vec::new(), Vec::new());
    for (name, values) in table {
        match ColumnName::of(&name) {
            // Misspelt ones too: whoever reads them says what they should be called.
            ColumnName::Time | ColumnName::Command { .. } | ColumnName::Misspelt { .. } => {
                kept.push((name, values));
            }
            ColumnName::Recorded => {}
            ColumnName::Other => ignored.push(name),
        }
    }
    (kept, ignored)
}

/// Columns as the content of a file: what is checked there is checked here.
///
/// # Errors
/// `DataError` for columns of different lengths and for names that no file can hold.
pub fn csv(table: &[(String, Vec<f64>)]) -> PyResult<String> {
    let rows = table.first().map_or(0, |(_, values)| values.len());
    if let Some((name, values)) = table.iter().find(|(_, values)| values.len() != rows) {
        let first = &table[0].0;
        return Err(errors::unusable(format!(
            "column {name} has {} values and {first} has {rows}; all columns are equally long",
            values.len()
        )));
    }
    if let Some((name, _)) = table.iter().find(|(name, _)| name.contains([',', '"', '\n', '\r', '#'])) {
        return Err(errors::unusable(format!("{name:?} is no column name")));
    }
    let mut text = table.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(",");
    for row in 0..rows {
        text.push('\n');
        for (column, (_, values)) in table.iter().enumerate() {
            if column > 0 {
                text.push(',');
            }
            if values[row].is_finite() {
                // Writing to a String cannot fail.
                let _ = write!(text, "{}", values[row]);
            } else {
                // An empty line would be no row at all.
                text.push_str("na");
            }
        }
    }
    text.push('\n');
    Ok(text)
}

/// Name and values of each column of a recording but time.
pub fn of(recording: &Recording) -> Vec<(String, &[f32])> {
    let mut columns: Vec<(String, &[f32])> = Vec::new();
    for channel in &recording.channels {
        let id = channel.id;
        columns.extend(channel.command_kpa.as_deref().map(|values| (id.command_column(), values)));
        columns.extend(channel.pressure_kpa.as_deref().map(|values| (id.pressure_column(), values)));
        match &channel.drive {
            None => {}
            Some(Drive::Spool(u)) => columns.push((id.drive_column(), u)),
            Some(Drive::Separate { fill, vent }) => {
                let (fill_name, vent_name) = id.fill_vent_columns();
                columns.extend([(fill_name, fill.as_slice()), (vent_name, vent.as_slice())]);
            }
        }
    }
    for joint in &recording.joints {
        columns.extend(joint.qu_rad.as_deref().map(|q| (format!("b{}_qu_rad", joint.board), q)));
        columns.extend(joint.qv_rad.as_deref().map(|q| (format!("b{}_qv_rad", joint.board), q)));
    }
    columns.extend(recording.supply_kpa.as_deref().map(|values| ("supply_kpa".to_owned(), values)));
    for BoardSupply { board, kpa } in &recording.board_supplies {
        columns.push((format!("b{board}_supply_kpa"), kpa));
    }
    columns
}
