use super::arguments::{self, RigArgument};
use super::convert::{self, ScoreDict};
use super::displays;
use super::expected::Expected;
use super::parameters::Parameters;
use super::recording::Recording;
use super::work::{self, Watch};
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::{Array, Dict, Matrix};
use numpy::PyArray2;
use pneudrive_model::data::{ChannelId, Loaded};
use pneudrive_model::experiment::{FitSettings, FittedChannel, Score, fit_channels};
use pneudrive_model::fit::{Control, Progress};
use pneudrive_model::report::{Colour, PreEscaped, Table, fragment, html, significant};
use pneudrive_model::store::ParameterFile;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// The fit of one model to the channels of a recording.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Fit {
    parameters: Arc<ParameterFile>,
    loaded: Arc<Loaded>,
    channels: Vec<Kept>,
}

/// One channel's fit, as it is kept.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Kept {
    channel: ChannelId,
    model: String,
    fitted: Option<Score>,
    held_out: Option<Score>,
    free: Vec<String>,
    covariance: Vec<Vec<f64>>,
    agreeing_starts: usize,
    starts: usize,
    condition: f64,
    /// Everything, as JSON.
    json: String,
}

impl Kept {
    fn of(fitted: FittedChannel) -> PyResult<Self> {
        let json = serde_json::to_string(&fitted).map_err(errors::unusable)?;
        let FittedChannel { channel, setup, fit, fitted, held_out } = fitted;
        Ok(Self {
            channel,
            model: setup.model.name().to_owned(),
            fitted,
            held_out,
            free: fit.free,
            covariance: fit.covariance,
            agreeing_starts: fit.agreeing_starts,
            starts: fit.starts.len(),
            condition: fit.condition,
            json,
        })
    }
}

impl Fit {
    fn channel(&self, name: &str) -> PyResult<&Kept> {
        let id: ChannelId = name.parse().map_err(errors::unusable)?;
        self.channels.iter().find(|fit| fit.channel == id).ok_or_else(|| {
            errors::unusable(format!("no channel {name} was fitted; there is {}", self.names().join(", ")))
        })
    }

    fn names(&self) -> Vec<String> {
        self.channels.iter().map(|fit| fit.channel.to_string()).collect()
    }

    fn scores<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Kept) -> Option<&Score>,
    ) -> PyResult<Dict<'py, ScoreDict<'py>>> {
        let dict = PyDict::new(py);
        for fit in &self.channels {
            dict.set_item(fit.channel.to_string(), convert::score(py, of(fit))?)?;
        }
        Ok(Dict::new(dict))
    }

    /// One line per channel: (channel, error on the fitted part, on the rest, starts, condition
    /// number).
    fn summary(&self) -> Vec<Vec<String>> {
        let line = |fit: &Kept| {
            vec![
                fit.channel.to_string(),
                convert::rmse(fit.fitted.as_ref()),
                convert::rmse(fit.held_out.as_ref()),
                format!("{} of {}", fit.agreeing_starts, fit.starts),
                significant(fit.condition, 2),
            ]
        };
        self.channels.iter().map(line).collect()
    }
}

const SUMMARY: [&str; 5] =
    ["channel", "RMSE fitted, kPa", "RMSE rest, kPa", "starts agree", "condition number"];

#[pymethods]
impl Fit {
    /// Names of the fitted channels.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.names()
    }

    /// The parameters, as ``simulate`` takes them.
    #[getter]
    fn parameters(&self) -> Parameters {
        Parameters { file: Arc::clone(&self.parameters), name: "fit".to_owned() }
    }

    /// Errors of the rollouts on the fitted part, by channel: dictionaries with ``r2``,
    /// ``rmse_kpa``, ``mae_kpa``, ``iae_kpa_s`` (integral of the absolute error), ``largest_kpa``,
    /// ``samples``, ``seconds``.
    #[getter]
    fn fitted<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, ScoreDict<'py>>> {
        self.scores(py, |fit| fit.fitted.as_ref())
    }

    /// The same on the rest of the recording; ``None`` where everything was fitted.
    #[getter]
    fn held_out<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, ScoreDict<'py>>> {
        self.scores(py, |fit| fit.held_out.as_ref())
    }

    /// Names of a channel's free parameters, and their covariance.
    ///
    /// Returns
    /// -------
    /// names : list of str
    /// covariance : numpy.ndarray of float64, shape (free, free)
    ///     In the parameters' units, corrected for correlated residuals; infinite where the data
    ///     determine nothing.
    fn covariance<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<(Vec<String>, Matrix<'py>)> {
        let fit = self.channel(channel)?;
        let covariance = PyArray2::from_vec2(py, &fit.covariance).map_err(errors::unusable)?;
        Ok((fit.free.clone(), Array(covariance)))
    }

    /// The recording that was fitted.
    #[getter]
    fn recording(&self) -> Recording {
        Recording { loaded: Arc::clone(&self.loaded), events: Arc::default() }
    }

    /// Measured and simulated pressures of one channel where they can be compared.
    ///
    /// Parameters
    /// ----------
    /// channel : str
    ///     Such as ``"b0c1"``.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``t_s``, ``measured_kpa``, ``simulated_kpa`` and ``residual_kpa`` (measured -
    ///     simulated): float64 arrays of shape (compared rows,); ``role``: array of str, ``"fit"``
    ///     where the parameters were fitted and ``"held out"`` where they were not.
    fn residuals<'py>(slf: &Bound<'py, Self>, channel: &str) -> PyResult<Bound<'py, PyAny>> {
        slf.get().channel(channel)?;
        slf.py().import("pneudrive_py.tables")?.call_method1("fit_residuals", (slf, channel))
    }

    /// Length of the part that was fitted, s, from the first row on.
    #[getter]
    fn fit_seconds(&self) -> f64 {
        self.parameters.settings.fit_seconds
    }

    /// Draws measured and simulated pressures, the fitted part shaded, and their difference (needs
    /// matplotlib): see ``pneudrive_py.plots.fit``, which takes the same keywords.
    ///
    /// Returns
    /// -------
    /// matplotlib.figure.Figure
    #[pyo3(signature = (channels=None, **options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        channels: Option<Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pneudrive_py.plots")?.call_method("fit", (slf, channels), options)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        pickling::reduce(slf.as_any(), &(&*slf.get().parameters, &*slf.get().loaded, &slf.get().channels))
    }

    #[staticmethod]
    fn _unpickle(state: &[u8]) -> PyResult<Self> {
        let (parameters, loaded, channels): (ParameterFile, Loaded, Vec<Kept>) = pickling::state(state)?;
        Ok(Self { parameters: Arc::new(parameters), loaded: Arc::new(loaded), channels })
    }

    /// Writes the parameters to a file (TOML), as ``Parameters.save``.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.parameters.save(&path).map_err(errors::store))
    }

    /// Everything about the fits, by channel: parameters with intervals, starts, what is not
    /// determined and why.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
        let dict = PyDict::new(py);
        for fit in &self.channels {
            dict.set_item(fit.channel.to_string(), convert::parsed(py, &fit.json)?)?;
        }
        Ok(Dict::new(dict))
    }

    fn __repr__(&self) -> String {
        let model = self.channels.first().map_or("no", |fit| fit.model.as_str());
        format!("Fit of the {model} model\n{}", Table::text(&SUMMARY, &self.summary()))
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        let fit = slf.get();
        let summary = convert::table(&SUMMARY, 1, &fit.summary());
        let parameters = PreEscaped(fit.parameters()._repr_html_());
        let drawn = fit.channels.first().map(|first| {
            let (name, of) = (first.channel.to_string(), fit.channels.len());
            let residuals = match Self::residuals(slf, &name) {
                Ok(residuals) => residuals,
                // What cannot be simulated is displayed all the same.
                Err(error) => return Ok(displays::not_drawn(error)),
            };
            let model = format!("{} model", first.model);
            let shaded = Some(("fit", "fitted"));
            displays::of_residuals(&residuals, (&name, of), (&model, Colour::Blue), shaded)
        });
        let drawn = drawn.transpose()?;
        let content = html! { (summary.markup()) (parameters) @if let Some(drawn) = drawn { (drawn) } };
        Ok(fragment(&content).into_string())
    }
}

/// Fits a model to every channel of a recording.
///
/// Parameters
/// ----------
/// recording : Recording
/// rig : Rig or path, optional
///     Without it only the linear model can be used.
/// model : {"nonlinear", "parametric", "linear"}, default "nonlinear"
///     Valve and chamber from first principles; Tassa et al. 2013; first-order lag of the command.
/// fit_seconds, fit_fraction : float, optional
///     Fit only the first so many seconds, or this share, and judge on the rest. Everything is
///     fitted by default.
/// controller : {"auto", "on", "off"}, default "auto"
///     Whether the board's own pressure loop is simulated: by default where the drive is not
///     recorded.
/// drive : {"auto", "spool", "separate"}, default "auto"
///     Kind of valve; by default as the columns say.
/// flow : {"iso6358", "printed"}, default "iso6358"
///     Form of the flow function.
/// objective : {"rollout", "rate"}, default "rollout"
///     Compare simulated pressures, or rates (fast, biased by noise).
/// starts : int, default 20
///     Number of starts, 1 to 10000.
/// seed : int, default 1
///     The same seed gives the same result.
/// measured_start : bool, default False
///     Take the pressure at the start of each stretch as measured instead of fitting it.
/// profiles : bool, default False
///     Profile-likelihood intervals too (slower).
/// progress : callable, optional
///     Called with (searches done, searches in all, what is being done).
///
/// Returns
/// -------
/// Fit
///
/// Raises
/// ------
/// DataError
///     The recording or the rig lacks something, or an argument is unusable.
/// FitError
///     A channel cannot be fitted.
#[pyfunction]
#[pyo3(signature = (recording, rig=None, *, model="nonlinear", fit_seconds=None, fit_fraction=None, controller="auto", drive="auto", flow="iso6358", objective="rollout", starts=20, seed=1, measured_start=false, profiles=false, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn fit(
    py: Python<'_>,
    recording: Expected<Py<Recording>>,
    rig: Option<Expected<RigArgument>>,
    model: &str,
    fit_seconds: Option<f64>,
    fit_fraction: Option<f64>,
    controller: &str,
    drive: &str,
    flow: &str,
    objective: &str,
    starts: i64,
    seed: u64,
    measured_start: bool,
    profiles: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Fit> {
    let (rig, rig_file) = RigArgument::resolve(rig)?;
    let settings = FitSettings {
        model: arguments::model(model)?,
        split: arguments::split(fit_seconds, fit_fraction)?,
        objective: arguments::objective(objective)?,
        controller: arguments::controller(controller)?,
        drive: arguments::drive(drive)?,
        form: arguments::flow(flow)?,
        fit: arguments::fit_options(starts, seed, measured_start, profiles)?,
    };
    let loaded = Arc::clone(&recording.0.get().loaded);
    let kept = Arc::clone(&loaded);
    let provenance = convert::provenance(py, "fit", &loaded.recording.source, rig_file)?;
    let work = move |watch: &Watch| {
        watch.begin(&format!("fitting the {} model", settings.model.name()));
        let tell = |p: Progress| watch.tell(p.done as u64, p.total as u64);
        let control = Control { progress: &tell, cancel: watch.cancel() };
        let channels = fit_channels(&loaded.recording, &rig, &settings, control)?;
        let mut file = ParameterFile::of(&loaded.recording, &rig, &settings, &channels)?;
        file.provenance = provenance;
        Ok((file, channels))
    };
    let (file, channels) = work::run(py, progress.as_ref(), work)?.map_err(errors::fit)?;
    let channels = channels.into_iter().map(Kept::of).collect::<PyResult<_>>()?;
    Ok(Fit { parameters: Arc::new(file), loaded: kept, channels })
}
