//! `compare`: models fitted to the first part of a recording, and judged on the rest.

use super::arguments::{self, RigArgument};
use super::comparison::Comparison;
use super::convert;
use super::expected::{Expected, Names};
use super::recording::Recording;
use super::work::{self, Watch};
use crate::errors;
use pneudrive_model::experiment::{self, CompareSettings, CompareWatch, ModelKind};
use pneudrive_model::fit::{Control, Progress};
use pyo3::prelude::*;
use std::sync::Arc;
use std::time::Instant;

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
///     Nothing can be compared, or an argument is unusable. What only some models or channels lack
///     is in ``Comparison.table``.
#[pyfunction]
#[pyo3(signature = (recording, rig=None, *, models=None, fit_seconds=None, fit_fraction=None, controller="auto", drive="auto", flow="iso6358", objective="rollout", starts=20, seed=1, measured_start=false, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn compare(
    py: Python<'_>,
    recording: Expected<Py<Recording>>,
    rig: Option<Expected<RigArgument>>,
    models: Option<Expected<Names>>,
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
        Some(Expected(Names(names))) => {
            names.iter().map(|name| arguments::model(name)).collect::<PyResult<Vec<_>>>()?
        }
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
    let loaded = Arc::clone(&recording.0.get().loaded);
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
    py.detach(|| Comparison::of(result, &loaded, &origin))
}
