use super::convert;
use super::rig::Rig;
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::Dict;
use pneudrive_model::diagnosis::{ExtendedChannel, ExtendedFile};
use pneudrive_model::report::{html, significant};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// A model with the effects that a diagnosis found, for the channels of one rig.
///
/// ``Diagnosis.extended_model``, or what ``ExtendedModel.load`` reads. ``simulate`` simulates it;
/// as ``diagnose(reference=...)`` it is what a later recording of the same rig is compared with.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct ExtendedModel {
    pub file: Arc<ExtendedFile>,
    /// What messages call it.
    pub name: String,
}

impl ExtendedModel {
    fn channel(&self, channel: &str) -> PyResult<&ExtendedChannel> {
        self.file.channels.get(channel).ok_or_else(|| {
            errors::unusable(format!(
                "{}: no channel {channel}; it holds {}",
                self.name,
                self.channels().join(", ")
            ))
        })
    }
}

#[pymethods]
impl ExtendedModel {
    /// Reads ``extended.toml`` of a diagnosis, or a parameter file that ``Parameters.save`` wrote:
    /// a model without effects.
    ///
    /// Raises
    /// ------
    /// DataError
    ///     It is neither, or holds what a diagnosis does not simulate.
    /// FileError
    ///     It cannot be read.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let name = path.display().to_string();
        std::fs::File::open(&path).map_err(|error| errors::FileError::new_err(format!("{name}: {error}")))?;
        let file = ExtendedFile::load(&path).map_err(errors::unusable)?;
        Ok(Self { file: Arc::new(file), name })
    }

    /// Writes the file (TOML), which ``pneudrive-model simulate`` and ``diagnose --reference`` read
    /// too.
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
        self.file.channels.keys().cloned().collect()
    }

    /// The base model: ``"nonlinear"`` or ``"linear"``.
    #[getter]
    fn model(&self) -> &str {
        &self.file.model
    }

    /// The rig that it was fitted with.
    #[getter]
    fn rig(&self) -> Rig {
        Rig { inner: Arc::new(self.file.rig.clone()), file: None }
    }

    /// Parameters of a channel's base model by name, in the units of ``model_parameters``.
    fn values<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Dict<'py, f64>> {
        let dict = PyDict::new(py);
        for (name, value) in &self.channel(channel)?.parameters {
            dict.set_item(name, value)?;
        }
        Ok(Dict::new(dict))
    }

    /// Effects at work in a channel, and by name their parameters in the units of ``effects``.
    fn effects<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Dict<'py, Dict<'py, f64>>> {
        let dict = PyDict::new(py);
        for (effect, parameters) in &self.channel(channel)?.effects {
            dict.set_item(effect, parameters)?;
        }
        Ok(Dict::new(dict))
    }

    /// The file's text (TOML).
    fn to_toml(&self) -> PyResult<String> {
        toml::to_string(&*self.file).map_err(errors::unusable)
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
        let (name, file): (String, ExtendedFile) = pickling::state(state)?;
        Ok(Self { file: Arc::new(file), name })
    }

    fn __repr__(&self) -> String {
        let channel = |(id, stored): (&String, &ExtendedChannel)| {
            let effects: Vec<&str> = stored.effects.keys().map(String::as_str).collect();
            let corrected = if stored.correction.is_some() { " and a correction" } else { "" };
            match effects.is_empty() {
                true => format!("{id}{corrected}"),
                false => format!("{id} with {}{corrected}", effects.join(", ")),
            }
        };
        let channels: Vec<String> = self.file.channels.iter().map(channel).collect();
        format!("<ExtendedModel {:?}, {}: {}>", self.name, self.file.model, channels.join("; "))
    }

    fn _repr_html_(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .file
            .channels
            .iter()
            .flat_map(|(id, stored)| {
                let base = stored.parameters.iter().map(move |value| (id, self.file.model.as_str(), value));
                let effects = stored.effects.iter().flat_map(move |(effect, parameters)| {
                    parameters.iter().map(move |value| (id, effect.as_str(), value))
                });
                base.chain(effects)
            })
            .map(|(id, part, (name, value))| {
                vec![id.clone(), part.to_owned(), name.clone(), significant(*value, 5)]
            })
            .collect();
        html! { (convert::table(&["channel", "part", "parameter", "value"], 3, &rows).markup()) }
            .into_string()
    }
}
