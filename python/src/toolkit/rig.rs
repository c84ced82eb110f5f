use super::convert;
use crate::errors;
use pneudrive_model::report::html;
use pneudrive_model::rig;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// What a machine is made of: supply, chambers, valves, the boards' control loop, sensors.
///
/// Parameters
/// ----------
/// **tables : dict
///     The tables of a rig file, such as ``supply={"pressure_kpa": 550.0}``: ``supply``,
///     ``ambient``, ``chamber``, ``valve``, ``controller``, ``sensor``, and ``boards`` with what
///     boards and channels have of their own, as in ``boards={"0": {"channels": {"3": {"chamber":
///     {"volume_m3": 1e-4}}}}}``. All are optional; keys carry their units. See ``Rig.load`` for
///     files.
///
/// Raises
/// ------
/// DataError
///     An unknown table or key, or a value outside its range.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Rig {
    pub inner: Arc<rig::Rig>,
    /// The file it was read from.
    pub file: Option<String>,
}

impl Rig {
    fn toml(&self) -> PyResult<String> {
        toml::to_string(&*self.inner).map_err(errors::unusable)
    }
}

#[pymethods]
impl Rig {
    #[new]
    #[pyo3(signature = (**tables))]
    fn new(py: Python<'_>, tables: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let Some(tables) = tables else { return Ok(Self { inner: Arc::default(), file: None }) };
        let unusable = |error: PyErr| errors::unusable(error.value(py));
        let value = convert::value(tables.as_any()).map_err(unusable)?;
        let text = toml::to_string(&value).map_err(errors::unusable)?;
        // The text is ours: its lines would tell nothing.
        let inner = rig::Rig::parse("Rig", &text).map_err(|error| match error {
            rig::RigError::File(error) => errors::unusable(format!("Rig: {}", error.sentence())),
            other => errors::rig(other),
        })?;
        Ok(Self { inner: Arc::new(inner), file: None })
    }

    /// Reads a rig file.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A TOML file.
    ///
    /// Returns
    /// -------
    /// Rig
    ///
    /// Raises
    /// ------
    /// DataError
    ///     An unknown table or key, or a value outside its range; the message names it.
    /// FileError
    ///     The file cannot be read.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let inner = rig::Rig::load(&path).map_err(errors::rig)?;
        Ok(Self { inner: Arc::new(inner), file: Some(path.display().to_string()) })
    }

    /// A rig from the text of a rig file.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     TOML.
    /// name : str, default "rig"
    ///     What error messages call it.
    #[staticmethod]
    #[pyo3(signature = (text, name="rig"))]
    fn parse(text: &str, name: &str) -> PyResult<Self> {
        let inner = rig::Rig::parse(name, text).map_err(errors::rig)?;
        Ok(Self { inner: Arc::new(inner), file: None })
    }

    /// The machine as one channel has it: of each table the channel's own, else its board's, else
    /// that of all.
    ///
    /// Parameters
    /// ----------
    /// channel : str
    ///     Such as ``"b0c1"``.
    ///
    /// Returns
    /// -------
    /// Rig
    ///     Without ``boards``.
    fn at(&self, channel: &str) -> PyResult<Self> {
        let inner = self.inner.at(channel.parse().map_err(errors::unusable)?);
        Ok(Self { inner: Arc::new(inner), file: self.file.clone() })
    }

    /// The rig file's text (TOML).
    fn to_toml(&self) -> PyResult<String> {
        self.toml()
    }

    /// The tables as a dictionary of dictionaries.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &*self.inner)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    /// Rigs can be sent to other processes.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("parse")?, (slf.get().toml()?,)))
    }

    fn __repr__(&self) -> PyResult<String> {
        let tables: toml::Table = self.toml()?.parse().map_err(errors::unusable)?;
        let names: Vec<&str> = tables.keys().map(String::as_str).collect();
        let file = self.file.as_ref().map(|file| format!(" {file:?}")).unwrap_or_default();
        Ok(format!("<Rig{file}: {}>", if names.is_empty() { "empty".to_owned() } else { names.join(", ") }))
    }

    fn _repr_html_(&self) -> PyResult<String> {
        Ok(html! { pre { (self.toml()?) } }.into_string())
    }
}
