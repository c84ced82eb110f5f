use super::arguments::RigArgument;
use super::convert;
use super::expected::{Described, Expected};
use super::extended::ExtendedModel;
use super::recording::Recording;
use super::work::{self, Watch};
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::Dict;
use numpy::PyArray1;
use pneudrive_model::data::{self, write};
use pneudrive_model::diagnosis::{
    self as library, ChannelData, EXTENDED_FILE, Extended, ExtendedFile, Request, Role, TRAJECTORY_FILE,
    json, page,
};
use pneudrive_model::report::{Table, html, number, paragraph, significant};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// What a simulation gets wrong in a recording, why, and what modelling it gains.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Diagnosis {
    kept: Kept,
}

/// A diagnosis, as it is kept.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Kept {
    report: json::Report,
    extended: ExtendedFile,
    html: String,
    /// The next experiment, where one would tell more.
    trajectory: Option<String>,
    channels: Vec<Residuals>,
}

/// One channel's, at the compared rows.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Residuals {
    channel: String,
    time_s: Vec<f64>,
    measured_kpa: Vec<f64>,
    base_kpa: Vec<f64>,
    extended_kpa: Vec<f64>,
    /// What the row's block was used for.
    role: Vec<String>,
}

impl Kept {
    fn of(diagnosis: library::Diagnosis, footer: &str) -> PyResult<Self> {
        let html = page::page(&diagnosis, footer).map_err(errors::unusable)?;
        let models = diagnosis.base.iter().zip(&diagnosis.extended_models);
        let channels = diagnosis.channels.iter().zip(models);
        let channels = channels.map(|(data, (base, extended))| Residuals::of(data, base, extended)).collect();
        let library::Diagnosis { report, extended, plan, .. } = diagnosis;
        Ok(Self { report, extended, html, trajectory: plan.map(|plan| plan.trajectory), channels })
    }
}

impl Residuals {
    fn of(data: &ChannelData, base: &Extended, extended: &Extended) -> Self {
        let mut role = vec![String::new(); data.rows.len()];
        for (block, span) in data.blocks.iter().zip(&data.spans) {
            let word = match block.role {
                Role::Fit => "fit",
                Role::Select => "select",
                Role::Test => "test",
            };
            role[span.clone()].fill(word.to_owned());
        }
        Self {
            channel: data.id.to_string(),
            time_s: data.rows.iter().map(|row| data.inputs.time_s[*row as usize]).collect(),
            measured_kpa: data.measured_kpa.to_vec(),
            base_kpa: data.residuals(base),
            extended_kpa: data.residuals(extended),
            role,
        }
    }
}

const HEAD: [&str; 6] =
    ["cause", "channels", "size [95 %]", "test error, kPa", "gain [95 %]", "fits as well"];

impl Diagnosis {
    fn report(&self) -> &json::Report {
        &self.kept.report
    }

    fn extended_text(&self) -> PyResult<String> {
        toml::to_string(&self.kept.extended).map_err(errors::unusable)
    }

    fn rows(&self) -> Vec<Vec<String>> {
        self.report().causes.iter().map(line).collect()
    }
}

/// One cause as a line of a table.
fn line(cause: &json::Cause) -> Vec<String> {
    let size = |(name, estimate): (&String, &json::Estimate)| match estimate.ci95 {
        Some([low, high]) => format!(
            "{name} {} [{}, {}]{}",
            significant(estimate.value, 3),
            significant(low, 3),
            significant(high, 3),
            convert::unit(&estimate.unit)
        ),
        None => format!("{name} not identifiable here"),
    };
    let gain = &cause.gain;
    vec![
        cause.effect.clone(),
        cause.channels.join(", "),
        cause.parameters.iter().map(size).collect::<Vec<_>>().join("; "),
        format!("{} to {}", number(gain.test_rmse_before_kpa, 2), number(gain.test_rmse_after_kpa, 2)),
        format!("{:.0} % [{:.0}, {:.0}]", 100.0 * gain.reduction, 100.0 * gain.ci95[0], 100.0 * gain.ci95[1]),
        if cause.equivalent.is_empty() { "-".to_owned() } else { cause.equivalent.join(", ") },
    ]
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

    /// The causes that were named, in the order of the gain: dictionaries with ``effect``, ``channels``, ``equivalent`` (effects
    /// that explain the recording as well), ``parameters`` (``value``, ``ci95``, ``unit``), ``p_value``, ``gain``.
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

    /// The model with the causes: ``simulate`` and ``diagnose(reference=...)`` take it.
    #[getter]
    fn extended_model(&self) -> ExtendedModel {
        ExtendedModel { file: Arc::new(self.kept.extended.clone()), name: "extended model".to_owned() }
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
    ///     ``t_s`` (from the start of the recording), ``measured_kpa``, and the residuals (measured - simulated, kPa) ``base`` of the model
    ///     without the causes and ``extended`` with them: float64 arrays of shape (compared rows,). ``role``: array of str, what the row
    ///     was used for: ``"fit"`` (parameters), ``"select"`` (causes) or ``"test"`` (the gain, nothing else).
    fn residuals<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
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
        self.kept.channels.iter().map(|one| one.channel.clone()).collect()
    }

    /// Draws measured pressures and the residuals without and with the causes, test blocks shaded (needs matplotlib): see ``pneudrive_py.plots.diagnosis``, which takes the same keywords.
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

    /// Writes ``report.html``, ``report.json`` and ``extended.toml`` into a folder, as ``pneudrive-model diagnose`` does, and
    /// ``next_experiment.csv`` where another recording would tell rivals apart.
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
            let mut files = vec![
                (EXTENDED_FILE, self.extended_text()?),
                ("report.json", json),
                ("report.html", self.kept.html.clone()),
            ];
            files.extend(self.kept.trajectory.clone().map(|trajectory| (TRAJECTORY_FILE, trajectory)));
            for (name, text) in files {
                write::text_atomically(&folder.join(name), &text).map_err(errors::recording)?;
            }
            Ok(())
        })
    }

    fn __repr__(&self) -> String {
        let sentence = self.sentence();
        if self.report().causes.is_empty() {
            return format!("Diagnosis: {sentence}");
        }
        format!("Diagnosis: {sentence}\n{}", Table::text(&HEAD, &self.rows()))
    }

    fn _repr_html_(&self) -> String {
        let table = convert::table(&HEAD, 3, &self.rows());
        let causes = !self.report().causes.is_empty();
        html! { (paragraph(self.sentence())) @if causes { (table.markup()) } }.into_string()
    }
}

/// One recording, or several of one rig.
#[derive(FromPyObject)]
pub enum Recordings {
    One(Py<Recording>),
    Several(Vec<Py<Recording>>),
}

impl Described for Recordings {
    const EXPECTED: &'static str = "a Recording or a sequence of Recordings";
}

impl Described for Reference {
    const EXPECTED: &'static str = "an ExtendedModel or the path of extended.toml";
}

impl Recordings {
    /// All as one, and what was noticed about their quality.
    fn joined(self) -> PyResult<(data::Recording, Vec<String>)> {
        let all = match self {
            Self::One(one) => vec![one],
            Self::Several(all) => all,
        };
        let mut joined: Option<data::Recording> = None;
        let mut remarks = Vec::new();
        for loaded in all.iter().map(|recording| &recording.get().loaded) {
            let next = loaded.recording.clone();
            let of = |sentence| {
                if all.len() == 1 { sentence } else { format!("{}: {sentence}", next.source.file) }
            };
            remarks.extend(loaded.quality.sentences().into_iter().map(of));
            joined = Some(match joined {
                None => next,
                Some(first) => first.followed_by(next).map_err(errors::unusable)?,
            });
        }
        let joined = joined.ok_or_else(|| errors::unusable("recordings is empty: nothing to diagnose"))?;
        Ok((joined, remarks))
    }
}

/// A calibrated model, or the path of one.
#[derive(FromPyObject)]
pub enum Reference {
    Model(Py<ExtendedModel>),
    Path(PathBuf),
}

impl Reference {
    /// What messages call it, and its content.
    fn resolve(self) -> PyResult<(String, Arc<ExtendedFile>)> {
        match self {
            Self::Model(model) => Ok((model.get().name.clone(), Arc::clone(&model.get().file))),
            Self::Path(path) => {
                let file = ExtendedFile::load(&path).map_err(errors::unusable)?;
                Ok((path.display().to_string(), Arc::new(file)))
            }
        }
    }
}

/// Says what the simulation gets wrong in a recording, why, and how much better it is once the cause is modelled.
///
/// Parameters
/// ----------
/// recording : Recording or sequence of Recording
///     Thirty seconds or more. Several recordings of one rig, with the same channels and columns, are diagnosed together.
/// rig : Rig or path, optional
///     Without it the channels are taken for regulators and compared with the linear model.
/// reference : ExtendedModel or path, optional
///     ``extended.toml`` of an earlier diagnosis of the same rig, or a file that ``Parameters.save`` wrote. The question is then which
///     calibrated parameter has moved; without it, which physical effect the model lacks.
/// highest_kpa : float, optional
///     Highest pressure that a suggested next experiment may command, kPa gauge; by default the highest in the recordings.
/// progress : callable, optional
///     Called with (steps done, 0, what is being done).
///
/// Returns
/// -------
/// Diagnosis
///
/// Raises
/// ------
/// DataError
///     The data cannot carry a diagnosis, recordings do not belong together, or the reference does not fit.
///
/// Notes
/// -----
/// docs/diagnosis.md says how causes are decided upon, and what that has been measured to find. All cores are used; where several
/// processes share a machine, set the environment variable ``RAYON_NUM_THREADS`` for each.
#[pyfunction]
#[pyo3(signature = (recording, rig=None, *, reference=None, highest_kpa=None, progress=None))]
pub fn diagnose(
    py: Python<'_>,
    recording: Expected<Recordings>,
    rig: Option<Expected<RigArgument>>,
    reference: Option<Expected<Reference>>,
    highest_kpa: Option<f64>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Diagnosis> {
    let (rig, rig_file) = RigArgument::resolve(rig)?;
    if let Some(kpa) = highest_kpa.filter(|kpa| !(*kpa > 0.0 && kpa.is_finite())) {
        return Err(errors::unusable(format!(
            "highest_kpa is {kpa}; it must be a pressure above 0 kPa gauge"
        )));
    }
    let (recording, remarks) = recording.0.joined()?;
    let provenance = convert::provenance(py, "diagnose", &recording.source, rig_file)?;
    let reference = reference.map(|given| given.0.resolve()).transpose()?;
    let work = move |watch: &Watch| {
        let tell = |what: &str, _: u64| {
            watch.checkpoint();
            if what.is_empty() { watch.advance() } else { watch.begin(what) }
        };
        let reference = reference.as_ref().map(|(name, file)| (name.as_str(), &**file));
        let request = Request { reference, highest_kpa };
        let mut diagnosis = library::diagnose(&recording, &rig, request, &tell)?;
        diagnosis.report.notes.extend(remarks);
        diagnosis.extended.provenance = Some(provenance);
        Ok(diagnosis)
    };
    let origin = convert::origin(py, "diagnose")?;
    let footer = format!("{} | {} | {}", origin.program, origin.created, origin.command);
    let outcome: Result<_, library::DiagnosisError> = work::run(py, progress.as_ref(), work)?;
    let diagnosis = outcome.map_err(errors::unusable)?;
    Ok(Diagnosis { kept: py.detach(|| Kept::of(diagnosis, &footer))? })
}
