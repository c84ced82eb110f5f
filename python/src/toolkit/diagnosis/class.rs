use super::super::convert;
use super::super::extended::ExtendedModel;
use super::kept::Kept;
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::Dict;
use numpy::PyArray1;
use pneudrive_model::data::write;
use pneudrive_model::diagnosis::{TRAJECTORY_FILE, json, tables};
use pneudrive_model::report::{fragment, html, paragraph};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// What a simulation gets wrong in a recording, why, and what modelling it gains.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Diagnosis {
    pub kept: Kept,
}

impl Diagnosis {
    fn report(&self) -> &json::Report {
        &self.kept.report
    }

    fn is_machine(&self) -> bool {
        self.report().machine.is_some()
    }

    fn extended(&self, k: usize) -> Option<ExtendedModel> {
        let (name, file) = self.kept.extended.get(k)?;
        let name = if self.is_machine() { name.clone() } else { "extended model".to_owned() };
        Some(ExtendedModel { file: Arc::new(file.clone()), name })
    }
}

#[pymethods]
impl Diagnosis {
    /// In a word: ``"adequate"``, ``"explained"``, ``"partly_explained"`` or ``"unexplained"``.
    #[getter]
    fn verdict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &self.report().verdict)
    }

    /// What was found, in a sentence.
    #[getter]
    fn sentence(&self) -> &str {
        &self.report().sentence
    }

    /// The causes that were named, in the order of the gain: dictionaries with ``effect``,
    /// ``channels``, ``equivalent`` (effects that explain the recording as well), ``parameters``
    /// (``value``, ``ci95``, ``unit``), ``by_channel`` (the same, channel by channel), ``p_value``,
    /// ``gain``, and ``probability`` (of all ``alternatives`` with it, 0 to 1) where explanations
    /// were weighed.
    #[getter]
    fn causes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &self.report().causes)
    }

    /// What was noticed about the data.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.report().notes.clone()
    }

    /// The whole of ``report.json`` as a dictionary.
    #[getter]
    fn report_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, self.report())
    }

    /// The model with the causes: ``simulate`` and ``diagnose(reference=...)`` take it. Of several
    /// recordings of one machine the first's.
    #[getter]
    fn extended_model(&self) -> PyResult<ExtendedModel> {
        self.extended(0).ok_or_else(|| errors::unusable("there is no extended model"))
    }

    /// The models with the causes by the names of the files that ``save`` writes:
    /// ``extended.toml``, or of several recordings of one machine one for each, such as
    /// ``extended-arm1.toml``, in the order of the recordings. ``simulate(recording, model)`` gives
    /// the residuals of one; any of them as ``diagnose(machine=...)`` says what valves, supply and
    /// sensor are.
    #[getter]
    fn extended_models<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, ExtendedModel>> {
        let dict = PyDict::new(py);
        for (k, (name, _)) in self.kept.extended.iter().enumerate() {
            dict.set_item(name, self.extended(k))?;
        }
        Ok(Dict::new(dict))
    }

    /// Explanations of the recordings, the most probable first: dictionaries with ``causes`` (ids
    /// of effects, ``"none"``, ``"something_else"``), ``probability`` and ``select_rmse_kpa``, kPa.
    #[getter]
    fn alternatives<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &self.report().alternatives)
    }

    /// The machine, where several recordings of one or one of a known one were diagnosed as such,
    /// else ``None``: ``known`` (were valves, supply and sensor given?), ``joint_rmse_before_kpa``,
    /// ``joint_rmse_after_kpa`` and ``recordings``, a list of dictionaries with ``file``, errors
    /// and discrepancies (kPa), ``load`` (by channel; ``value``, ``ci95``, ``unit``) and
    /// ``extended_model``, a key of ``extended_models``.
    #[getter]
    fn machine<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &self.report().machine)
    }

    /// Measured pressures of one channel and residuals, where they were compared.
    ///
    /// Parameters
    /// ----------
    /// channel : str
    ///     Such as ``"b0c1"``.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``t_s`` (from the start of the recording), ``measured_kpa``, and the residuals
    ///     (measured - simulated, kPa) ``base`` of the model without the causes and ``extended``
    ///     with them: float64 arrays of shape (compared rows,). ``role``: array of str, what the
    ///     row was used for: ``"fit"`` (parameters), ``"select"`` (causes) or ``"test"`` (the gain,
    ///     nothing else).
    ///
    /// Raises
    /// ------
    /// DataError
    ///     There is no such channel, or a machine was diagnosed: ``simulate`` with one of
    ///     ``extended_models`` gives its residuals.
    fn residuals<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
        if self.is_machine() {
            return Err(errors::unusable(
                "each recording of a machine has residuals of its own: simulate(recording, diagnosis.extended_models[file]).residuals(channel)",
            ));
        }
        let found = self.kept.channels.iter().find(|one| one.channel == channel).ok_or_else(|| {
            let names: Vec<&str> = self.kept.channels.iter().map(|one| one.channel.as_str()).collect();
            errors::unusable(format!("no channel {channel} was diagnosed; there is {}", names.join(", ")))
        })?;
        let dict = PyDict::new(py);
        dict.set_item("t_s", PyArray1::from_slice(py, &found.time_s))?;
        dict.set_item("measured_kpa", PyArray1::from_slice(py, &found.measured_kpa))?;
        dict.set_item("base", PyArray1::from_slice(py, &found.base_kpa))?;
        dict.set_item("extended", PyArray1::from_slice(py, &found.extended_kpa))?;
        dict.set_item("role", py.import("numpy")?.call_method1("array", (&found.role,))?)?;
        Ok(Dict::new(dict))
    }

    /// Names of the channels.
    #[getter]
    fn channels(&self) -> Vec<String> {
        match self.is_machine() {
            true => self.report().baseline.channels.keys().cloned().collect(),
            false => self.kept.channels.iter().map(|one| one.channel.clone()).collect(),
        }
    }

    /// Draws measured pressures and the residuals without and with the causes, test blocks shaded;
    /// of a machine the errors and loads of its recordings (needs matplotlib): see
    /// ``pneudrive_py.plots.diagnosis``, which takes the same keywords.
    ///
    /// Returns
    /// -------
    /// matplotlib.figure.Figure
    #[pyo3(signature = (channel=None, **options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        channel: Option<Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pneudrive_py.plots")?.call_method("diagnosis", (slf, channel), options)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        pickling::reduce(slf.as_any(), &slf.get().kept)
    }

    #[staticmethod]
    fn _unpickle(state: &[u8]) -> PyResult<Self> {
        Ok(Self { kept: pickling::state(state)? })
    }

    /// The page with tables and plots, one self-contained HTML file's content.
    fn html(&self) -> String {
        self.kept.html.clone()
    }

    /// Writes ``report.html``, ``report.json`` and ``extended_models`` into a folder, as
    /// ``pneudrive-model diagnose`` does, and ``next_experiment.csv`` where another recording would
    /// tell rivals apart.
    ///
    /// Raises
    /// ------
    /// FileError
    ///     They cannot be written.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| {
            let failed =
                |error: std::io::Error| errors::FileError::new_err(format!("{}: {error}", folder.display()));
            std::fs::create_dir_all(&folder).map_err(failed)?;
            let json = serde_json::to_string_pretty(self.report()).map_err(errors::unusable)?;
            let mut files = vec![("report.json", json), ("report.html", self.kept.html.clone())];
            for (name, model) in &self.kept.extended {
                files.push((name, toml::to_string(model).map_err(errors::unusable)?));
            }
            files.extend(self.kept.trajectory.clone().map(|trajectory| (TRAJECTORY_FILE, trajectory)));
            for (name, text) in files {
                write::text_atomically(&folder.join(name), &text).map_err(errors::recording)?;
            }
            Ok(())
        })
    }

    fn __repr__(&self) -> String {
        let report = self.report();
        let mut parts = vec![format!("Diagnosis: {}", report.sentence)];
        parts.extend(tables::text(report, true));
        parts.join("\n")
    }

    fn _repr_html_(&self) -> String {
        let report = self.report();
        let causes = tables::causes(report);
        let content = html! {
            (paragraph(&report.sentence))
            @if !causes.is_empty() { (convert::table(&tables::CAUSES, 3, &causes).markup()) }
            @if self.is_machine() {
                (convert::table(&tables::RECORDINGS, 3, &tables::recordings(report)).markup())
            }
            @if !report.alternatives.is_empty() {
                (convert::table(&tables::ALTERNATIVES, 1, &tables::alternatives(report)).markup())
            }
            (self.kept.drawn())
        };
        fragment(&content).into_string()
    }
}
