//! In place of `data_set`, where there is no simulator.

use crate::errors::PneuDriveError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Refuses: this build has no truth plant.
#[pyfunction]
#[pyo3(name = "_record", signature = (*_arguments, **_options))]
pub fn record_data_set(
    _arguments: &Bound<'_, PyTuple>,
    _options: Option<&Bound<'_, PyDict>>,
) -> PyResult<u64> {
    Err(PneuDriveError::new_err("this pneudrive_py was built without the simulator (feature `sim`)"))
}
