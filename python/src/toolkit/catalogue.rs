use crate::types::Dict;
use pneudrive_model::effects::catalogue::CATALOGUE;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The catalogue of physical effects that ``diagnose`` knows.
///
/// Returns
/// -------
/// dict
///     By the effect's name: a dictionary with ``title``, ``physics``, ``equation``, ``source``,
///     ``rivals`` (effects it is easily confused with), ``check`` (what to look at first on the
///     rig), and ``parameters``: by their names tuples (unit, value at which the effect is absent,
///     meaning).
#[pyfunction]
pub fn effects<'py>(py: Python<'py>) -> PyResult<Dict<'py, Dict<'py, Bound<'py, PyAny>>>> {
    let catalogue = PyDict::new(py);
    for info in CATALOGUE {
        let parameters = PyDict::new(py);
        for parameter in info.parameters {
            parameters.set_item(parameter.name, (parameter.unit, parameter.null, parameter.meaning))?;
        }
        let entry = PyDict::new(py);
        let words = [
            ("title", info.title),
            ("physics", info.physics),
            ("equation", info.equation),
            ("source", info.source),
            ("check", info.check),
        ];
        for (key, text) in words {
            entry.set_item(key, text)?;
        }
        entry.set_item("rivals", info.rivals)?;
        entry.set_item("parameters", parameters)?;
        catalogue.set_item(info.id, entry)?;
    }
    Ok(Dict::new(catalogue))
}
