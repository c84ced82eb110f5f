use super::convert;
use super::rig::Rig;
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::{Array, Dict, Vector};
use numpy::PyArray1;
use pneudrive_model::data::ChannelId;
use pneudrive_model::report::{behind, html, significant};
use pneudrive_model::store::{ChannelParameters, ParameterFile};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// Fitted parameters of one or more channels, with the rig they were fitted with and where they
/// came from.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Parameters {
    pub file: Arc<ParameterFile>,
    /// What messages call it.
    pub name: String,
}

impl Parameters {
    fn channel(&self, channel: &str) -> PyResult<&ChannelParameters> {
        let id: ChannelId = channel.parse().map_err(errors::unusable)?;
        self.file.channel(&self.name, id).map_err(errors::store)
    }
}

#[pymethods]
impl Parameters {
    /// Reads a parameter file (TOML), such as ``save`` or ``pneudrive-model fit`` wrote.
    ///
    /// Raises
    /// ------
    /// DataError
    ///     It is no parameter file.
    /// FileError
    ///     It cannot be read.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let file = ParameterFile::load(&path).map_err(errors::store)?;
        Ok(Self { file: Arc::new(file), name: path.display().to_string() })
    }

    /// Writes a parameter file (TOML), which ``pneudrive-model simulate`` reads too.
    ///
    /// Raises
    /// ------
    /// FileError
    ///     It cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.file.save(&path).map_err(errors::store))
    }

    /// Names of the channels, such as ``"b0c1"``.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.file.channels.keys().map(ToString::to_string).collect()
    }

    /// The rig that the parameters were fitted with.
    #[getter]
    fn rig(&self) -> Rig {
        Rig { inner: Arc::new(self.file.rig.clone()), file: None }
    }

    /// The model of a channel: ``"linear"``, ``"nonlinear"`` or ``"parametric"``.
    fn model(&self, channel: &str) -> PyResult<&'static str> {
        Ok(self.channel(channel)?.setup.model.name())
    }

    /// The parameters of a channel by name, in the model's order and units (see
    /// ``model_parameters``).
    fn values<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Dict<'py, f64>> {
        let dict = PyDict::new(py);
        for parameter in &self.channel(channel)?.parameters {
            dict.set_item(&parameter.name, parameter.value)?;
        }
        Ok(Dict::new(dict))
    }

    /// The same as a float64 array of shape (parameters,), as ``simulate_batch`` takes it.
    fn array<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Vector<'py>> {
        let parameters = &self.channel(channel)?.parameters;
        Ok(Array(PyArray1::from_iter(py, parameters.iter().map(|parameter| parameter.value))))
    }

    /// All that the file holds, as dictionaries.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &*self.file)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        pickling::reduce(slf.as_any(), &(&slf.get().name, &*slf.get().file))
    }

    #[staticmethod]
    fn _unpickle(state: &[u8]) -> PyResult<Self> {
        let (name, file): (String, ParameterFile) = pickling::state(state)?;
        Ok(Self { file: Arc::new(file), name })
    }

    fn __repr__(&self) -> String {
        let channels: Vec<String> = self
            .file
            .channels
            .iter()
            .map(|(id, stored)| format!("{id} ({})", stored.setup.model.name()))
            .collect();
        format!("<Parameters {:?}: {}>", self.name, channels.join(", "))
    }

    pub fn _repr_html_(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .file
            .channels
            .iter()
            .flat_map(|(id, stored)| {
                stored.parameters.iter().map(move |parameter| {
                    vec![
                        id.to_string(),
                        parameter.name.clone(),
                        behind(&parameter.unit).trim().to_owned(),
                        significant(parameter.value, 5),
                        parameter.ci95.map_or_else(
                            || if parameter.determined { "-" } else { "not determined" }.to_owned(),
                            |[low, high]| format!("{} to {}", significant(low, 4), significant(high, 4)),
                        ),
                    ]
                })
            })
            .collect();
        let table = convert::table(&["channel", "parameter", "unit", "value", "95 % interval"], 3, &rows);
        html! { (table.markup()) }.into_string()
    }
}
