use super::arguments::{self, RigArgument};
use super::convert::{self, ScoreDict};
use super::extended::ExtendedModel;
use super::parameters::Parameters;
use super::recording::Recording;
use super::work::{self, Watch};
use crate::errors::{self, PneuDriveError};
use crate::types::{Array, Dict, Matrix, Vector};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pneudrive_model::data::{self, Channel, Flags, Loaded};
use pneudrive_model::diagnosis::{self, ExtendedFile, Purpose, simulate_extended};
use pneudrive_model::experiment::{ControllerUse, Score, Setup, score, score_rows, simulation};
use pneudrive_model::report::{Table, html, significant};
use pneudrive_model::rig;
use pneudrive_model::rollout::Start;
use pneudrive_model::store::ParameterFile;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// Simulated pressures of the channels of a recording.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Simulation {
    loaded: Arc<Loaded>,
    channels: Vec<SimulatedChannel>,
}

struct SimulatedChannel {
    channel: Channel,
    /// kPa gauge; NaN where the inputs are missing.
    kpa: Vec<f64>,
    /// What was simulated, in words.
    model: String,
    score: Option<Score>,
}

const HEAD: [&str; 4] = ["channel", "model", "RMSE, kPa", "R2"];

impl Simulation {
    fn rows(&self) -> Vec<Vec<String>> {
        let line = |one: &SimulatedChannel| {
            vec![
                one.channel.id.to_string(),
                one.model.clone(),
                convert::rmse(one.score.as_ref()),
                one.score.map_or_else(|| "-".to_owned(), |score| significant(score.r2, 4)),
            ]
        };
        self.channels.iter().map(line).collect()
    }
}

#[pymethods]
impl Simulation {
    /// Names of the channels, in the order of ``pressure_kpa``.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.channels.iter().map(|one| one.channel.id.to_string()).collect()
    }

    /// Time of each row, s; float64 array of shape (rows,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        Array(PyArray1::from_slice(py, &self.loaded.recording.time_s))
    }

    /// Simulated pressures, kPa gauge; float64 array of shape (rows, channels), NaN where the inputs are missing.
    #[getter]
    fn pressure_kpa<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        let array = PyArray2::zeros(py, [self.loaded.recording.rows(), self.channels.len()], false);
        {
            let mut view = array.readwrite();
            for (column, one) in self.channels.iter().enumerate() {
                for (row, value) in one.kpa.iter().enumerate() {
                    view.as_array_mut()[[row, column]] = *value;
                }
            }
        }
        Array(array)
    }

    /// Errors against the measured pressures, by channel: dictionaries as in ``Fit.fitted``, ``None`` where nothing was measured.
    #[getter]
    fn scores<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, ScoreDict<'py>>> {
        let dict = PyDict::new(py);
        for one in &self.channels {
            dict.set_item(one.channel.id.to_string(), convert::score(py, one.score.as_ref())?)?;
        }
        Ok(Dict::new(dict))
    }

    /// The recording with simulated pressures in place of the measured ones.
    #[getter]
    fn recording(&self) -> Recording {
        let simulated = |one: &SimulatedChannel| Channel {
            // Single precision: as measured pressures are kept.
            pressure_kpa: Some(one.kpa.iter().map(|kpa| *kpa as f32).collect()),
            flags: vec![Flags::NONE; one.kpa.len()],
            ..one.channel.clone()
        };
        let channels = self.channels.iter().map(simulated).collect();
        let recording = data::Recording { channels, ..self.loaded.recording.clone() };
        Recording { loaded: Arc::new(Loaded { recording, quality: self.loaded.quality.clone() }) }
    }

    fn __repr__(&self) -> String {
        format!("Simulation\n{}", Table::text(&HEAD, &self.rows()))
    }

    fn _repr_html_(&self) -> String {
        html! { (convert::table(&HEAD, 2, &self.rows()).markup()) }.into_string()
    }
}

/// What can be simulated.
#[derive(FromPyObject)]
pub enum Simulated {
    Fitted(Py<Parameters>),
    Extended(Py<ExtendedModel>),
}

/// Simulates the channels of a recording from its commands or drives alone.
///
/// Measured pressures are not used, except for the first of each stretch to start from, and to judge the simulation by.
///
/// Parameters
/// ----------
/// recording : Recording
///     Commands (for the linear model, or with the board's loop) or drives.
/// parameters : Parameters or ExtendedModel
///     Such as ``fit(...).parameters`` or ``diagnose(...).extended_model``. Their channels must include the recording's.
/// rig : Rig or path, optional
///     By default the one the parameters were fitted with.
/// controller : {"auto", "on", "off"}, default "auto"
///     Whether the board's pressure loop is simulated: by default as it was fitted.
/// start_kpa : float, default 0.0
///     Pressure to start from where none was measured, kPa gauge.
/// progress : callable, optional
///     Called with (channels done, channels in all, what is being done).
///
/// Returns
/// -------
/// Simulation
///
/// Raises
/// ------
/// DataError
///     The recording, the rig or the parameters lack something.
#[pyfunction]
#[pyo3(signature = (recording, parameters, *, rig=None, controller="auto", start_kpa=0.0, progress=None))]
pub fn simulate(
    py: Python<'_>,
    recording: &Recording,
    parameters: Simulated,
    rig: Option<RigArgument>,
    controller: &str,
    start_kpa: f64,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Simulation> {
    let controller = arguments::controller(controller)?;
    if !start_kpa.is_finite() {
        return Err(errors::unusable(format!(
            "start_kpa is {start_kpa}; it must be a pressure in kPa gauge"
        )));
    }
    let rig = rig.map(|given| RigArgument::resolve(Some(given))).transpose()?.map(|(rig, _)| rig);
    let loaded = Arc::clone(&recording.loaded);
    let job = Job { loaded, rig, controller, start_kpa };
    match parameters {
        Simulated::Fitted(parameters) => {
            let (file, name) = (Arc::clone(&parameters.get().file), parameters.get().name.clone());
            work::run(py, progress.as_ref(), move |watch| fitted(&name, &file, job, watch))?
        }
        Simulated::Extended(model) => {
            let (file, name) = (Arc::clone(&model.get().file), model.get().name.clone());
            work::run(py, progress.as_ref(), move |watch| extended(&name, &file, job, watch))?
        }
    }
}

/// What to simulate from.
struct Job {
    loaded: Arc<Loaded>,
    /// By default the model's own.
    rig: Option<Arc<rig::Rig>>,
    controller: ControllerUse,
    start_kpa: f64,
}

fn fitted(name: &str, file: &ParameterFile, job: Job, watch: &Watch) -> PyResult<Simulation> {
    watch.begin("simulating");
    let recording = &job.loaded.recording;
    let mut channels = Vec::new();
    for channel in &recording.channels {
        watch.checkpoint();
        channels.push(fitted_channel(name, file, &job, channel)?);
        watch.tell(channels.len() as u64, recording.channels.len() as u64);
    }
    Ok(Simulation { loaded: job.loaded, channels })
}

fn fitted_channel(
    name: &str,
    file: &ParameterFile,
    job: &Job,
    channel: &Channel,
) -> PyResult<SimulatedChannel> {
    let (recording, rig) = (&job.loaded.recording, job.rig.as_deref().unwrap_or(&file.rig));
    let stored = file.channel(name, channel.id).map_err(errors::store)?;
    let controller = match job.controller {
        ControllerUse::Auto if stored.setup.controller => ControllerUse::On,
        chosen => chosen,
    };
    let drive = stored.setup.drive.unwrap_or_default();
    let setup = Setup::resolve(stored.setup.model, controller, drive, recording, channel, rig)
        .map_err(errors::unusable)?;
    let prepared = simulation(setup, recording, channel, rig, file.flow_form(), job.start_kpa)
        .map_err(errors::unusable)?;
    let values = file.values(name, channel.id, &*prepared.subject).map_err(errors::store)?;
    let series = &prepared.series[0];
    let absolute = prepared.subject.simulate(&values, series, Start::Measured, stored.substeps);
    if series.segments().iter().any(|rows| absolute[rows.clone()].iter().any(|p| !p.is_finite())) {
        return Err(runs_away(channel));
    }
    let ambient_kpa = rig.ambient_or_standard().pressure_kpa_abs;
    let kpa = absolute.iter().map(|pa| pa * 1e-3 - ambient_kpa).collect();
    let score = (channel.usable_samples() > 0).then(|| score(series, &absolute)).flatten();
    let loop_ = if setup.controller { " behind the board's loop" } else { "" };
    Ok(SimulatedChannel {
        channel: channel.clone(),
        kpa,
        model: format!("{}{loop_}", setup.model.name()),
        score,
    })
}

fn extended(name: &str, file: &ExtendedFile, job: Job, watch: &Watch) -> PyResult<Simulation> {
    watch.begin("simulating");
    let (recording, rig) = (&job.loaded.recording, job.rig.as_deref().unwrap_or(&file.rig));
    let controller = match job.controller {
        ControllerUse::On => true,
        ControllerUse::Off => false,
        ControllerUse::Auto => file.channels.values().any(|channel| channel.drive == "board"),
    };
    let purpose = Purpose::Simulate { start_kpa: job.start_kpa, controller };
    // All channels at once: neighbours act on each other.
    let simulated = simulate_extended(name, file, recording, rig, purpose).map_err(errors::unusable)?;
    let one = |simulated: diagnosis::SimulatedChannel| {
        let channel = recording.channel(simulated.id).map_err(errors::recording)?;
        if !simulated.kpa.iter().all(|kpa| kpa.is_finite()) {
            return Err(runs_away(channel));
        }
        let stored = file.channels.get(&simulated.id.to_string());
        let mut parts: Vec<&str> =
            stored.iter().flat_map(|stored| stored.effects.keys().map(String::as_str)).collect();
        if stored.is_some_and(|stored| stored.correction.is_some()) {
            parts.push("a correction");
        }
        let with = if parts.is_empty() { String::new() } else { format!(" with {}", parts.join(", ")) };
        let loop_ = if simulated.driven_by == "board" { " behind the board's loop" } else { "" };
        Ok(SimulatedChannel {
            score: score_rows(recording, channel, &simulated.kpa, &simulated.usable),
            channel: channel.clone(),
            kpa: simulated.kpa,
            model: format!("{}{with}{loop_}", file.model),
        })
    };
    let channels = simulated.into_iter().map(one).collect::<PyResult<_>>()?;
    Ok(Simulation { loaded: job.loaded, channels })
}

fn runs_away(channel: &Channel) -> PyErr {
    PneuDriveError::new_err(format!(
        "channel {}: the simulation runs away; the inputs or the rig are not what the parameters were fitted with",
        channel.id
    ))
}
