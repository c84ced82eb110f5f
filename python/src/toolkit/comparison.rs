use super::arguments::{self, RigArgument};
use super::convert;
use super::recording::Recording;
use super::work::{self, Watch};
use crate::errors;
use crate::types::{Array, Dict, Vector};
use numpy::PyArray1;
use pneudrive_model::data::{Loaded, write};
use pneudrive_model::experiment::{
    self, CompareSettings, CompareWatch, ModelKind, ModelResult, Origin, comparison_page, comparison_text,
};
use pneudrive_model::fit::{Control, Progress};
use pneudrive_model::report::{html, significant};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Models fitted on one part of a recording and judged on the rest.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Comparison {
    result: experiment::Comparison,
    loaded: Arc<Loaded>,
    origin: Origin,
}

impl Comparison {
    fn page(&self) -> PyResult<String> {
        comparison_page(&self.result, &self.loaded.recording, &self.loaded.quality, &self.origin)
            .map_err(errors::unusable)
    }
}

#[pymethods]
impl Comparison {
    /// Models, best first by the rollout error on the judging part.
    #[getter]
    fn ranking(&self) -> Vec<&'static str> {
        self.result.ranking.iter().map(|model| model.name()).collect()
    }

    /// One row per channel and model, as ``pandas.DataFrame`` takes it: columns ``channel``, ``model``, ``rollout_rmse_kpa``,
    /// ``rollout_r2``, ``rollout_iae_kpa_s``, ``one_step_r2``, ``error`` (why there is no result, else ``None``).
    #[getter]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
        type Number = fn(&ModelResult) -> Option<f64>;
        let numbers: [(&str, Number); 4] = [
            ("rollout_rmse_kpa", |m| m.rollout.map(|s| s.rmse_kpa)),
            ("rollout_r2", |m| m.rollout.map(|s| s.r2)),
            ("rollout_iae_kpa_s", |m| m.rollout.map(|s| s.iae_kpa_s)),
            ("one_step_r2", |m| m.one_step.map(|s| s.r2)),
        ];
        let all = || self.result.channels.iter().flat_map(|c| c.models.iter().map(move |m| (c.channel, m)));
        let dict = PyDict::new(py);
        dict.set_item("channel", PyList::new(py, all().map(|(id, _)| id.to_string()))?)?;
        dict.set_item("model", PyList::new(py, all().map(|(_, m)| m.model.name()))?)?;
        for (name, number) in numbers {
            let values = all().map(|(_, m)| number(m).unwrap_or(f64::NAN));
            dict.set_item(name, PyArray1::from_iter(py, values))?;
        }
        dict.set_item("error", PyList::new(py, all().map(|(_, m)| m.error.clone()))?)?;
        Ok(Dict::new(dict))
    }

    /// The rollout of one model over the judging part.
    ///
    /// Parameters
    /// ----------
    /// channel : str
    ///     Such as ``"b0c1"``.
    /// model : str
    ///     ``"linear"``, ``"nonlinear"`` or ``"parametric"``.
    ///
    /// Returns
    /// -------
    /// time_s : numpy.ndarray of float64, shape (rows,)
    /// pressure_kpa : numpy.ndarray of float64, shape (rows,)
    ///     kPa gauge; NaN where nothing was simulated.
    fn trace<'py>(
        &self,
        py: Python<'py>,
        channel: &str,
        model: &str,
    ) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let kind = arguments::model(model)?;
        let found = self.result.channels.iter().find(|c| c.channel.to_string() == channel);
        let result = found.and_then(|c| c.models.iter().find(|m| m.model == kind));
        let trace = result.and_then(|m| m.trace.as_ref()).ok_or_else(|| {
            let why =
                result.and_then(|m| m.error.clone()).unwrap_or_else(|| "it was not compared".to_owned());
            errors::unusable(format!("no rollout of the {model} model on channel {channel}: {why}"))
        })?;
        let rows = trace.first_row..trace.first_row + trace.rollout_kpa.len();
        let time_s = &self.loaded.recording.time_s[rows];
        Ok((Array(PyArray1::from_slice(py, time_s)), Array(PyArray1::from_slice(py, &trace.rollout_kpa))))
    }

    /// Everything, as dictionaries.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &self.result)
    }

    /// The page with tables and plots, one self-contained HTML file's content.
    fn html(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.page())
    }

    /// Writes the page to a file.
    ///
    /// Raises
    /// ------
    /// FileError
    ///     It cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write::text_atomically(&path, &self.page()?).map_err(errors::recording))
    }

    fn __repr__(&self) -> String {
        comparison_text(&self.result)
    }

    fn _repr_html_(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .result
            .channels
            .iter()
            .flat_map(|c| c.models.iter().map(move |m| (c.channel, m)))
            .map(|(channel, model)| {
                let r2 = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| significant(v, 3));
                vec![
                    channel.to_string(),
                    model.model.name().to_owned(),
                    model.error.clone().unwrap_or_else(|| convert::rmse(model.rollout.as_ref())),
                    r2(model.rollout.map(|score| score.r2)),
                    r2(model.one_step.map(|score| score.r2)),
                ]
            })
            .collect();
        let head = ["channel", "model", "rollout RMSE, kPa", "rollout R2", "one-step R2"];
        html! { (convert::table(&head, 2, &rows).markup()) }.into_string()
    }
}

/// Fits several models to the first part of a recording and judges them on the rest.
///
/// Parameters
/// ----------
/// recording : Recording
/// rig : Rig or path, optional
///     Without it only the linear model can be used.
/// models : sequence of str, optional
///     All three by default: ``["linear", "nonlinear", "parametric"]``.
/// fit_seconds, fit_fraction : float, optional
///     What is fitted: the first so many seconds, or this share; 80 % by default.
/// controller, drive, flow, objective, starts, seed, measured_start
///     As for ``fit``.
/// progress : callable, optional
///     Called with (searches done, searches in all, what is being done).
///
/// Returns
/// -------
/// Comparison
///
/// Raises
/// ------
/// DataError
///     Nothing can be compared, or an argument is unusable. What only some models or channels lack is in ``Comparison.table``.
#[pyfunction]
#[pyo3(signature = (recording, rig=None, *, models=None, fit_seconds=None, fit_fraction=None, controller="auto", drive="auto", flow="iso6358", objective="rollout", starts=20, seed=1, measured_start=false, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn compare(
    py: Python<'_>,
    recording: &Recording,
    rig: Option<RigArgument>,
    models: Option<Vec<String>>,
    fit_seconds: Option<f64>,
    fit_fraction: Option<f64>,
    controller: &str,
    drive: &str,
    flow: &str,
    objective: &str,
    starts: i64,
    seed: u64,
    measured_start: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Comparison> {
    let (rig, _) = RigArgument::resolve(rig)?;
    let models = match models {
        None => ModelKind::ALL.to_vec(),
        Some(names) => names.iter().map(|name| arguments::model(name)).collect::<PyResult<Vec<_>>>()?,
    };
    if models.is_empty() {
        return Err(errors::unusable("models is empty; name one at least"));
    }
    let settings = CompareSettings {
        models,
        split: arguments::split(fit_seconds, fit_fraction)?.unwrap_or(CompareSettings::default().split),
        objective: arguments::objective(objective)?,
        controller: arguments::controller(controller)?,
        drive: arguments::drive(drive)?,
        form: arguments::flow(flow)?,
        fit: arguments::fit_options(starts, seed, measured_start, false)?,
    };
    let loaded = Arc::clone(&recording.loaded);
    let origin = convert::origin(py, "compare")?;
    let work = {
        let loaded = Arc::clone(&loaded);
        move |watch: &Watch| {
            let began = Instant::now();
            let clock = || began.elapsed().as_secs_f64();
            let announce = |model: ModelKind, _| watch.begin(&format!("fitting the {} model", model.name()));
            let tell = |p: Progress| watch.tell(p.done as u64, p.total as u64);
            let control = Control { progress: &tell, cancel: watch.cancel() };
            let watch = CompareWatch { control, clock: &clock, announce: &announce };
            experiment::compare(&loaded.recording, &rig, &settings, watch)
        }
    };
    let result = work::run(py, progress.as_ref(), work)?.map_err(errors::unusable)?;
    Ok(Comparison { result, loaded, origin })
}
