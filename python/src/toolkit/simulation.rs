use super::arguments::{self, RigArgument};
use super::convert;
use super::parameters::Parameters;
use super::recording::Recording;
use super::work;
use crate::errors::{self, PneuDriveError};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pneudrive_model::data::{self, Channel, Flags, Loaded};
use pneudrive_model::experiment::{ControllerUse, Score, Setup, score, simulation};
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
    setup: Setup,
    score: Option<Score>,
}

const HEAD: [&str; 4] = ["channel", "model", "RMSE, kPa", "R2"];

impl Simulation {
    fn rows(&self) -> Vec<Vec<String>> {
        let line = |one: &SimulatedChannel| {
            let loop_ = if one.setup.controller { " behind the board's loop" } else { "" };
            vec![
                one.channel.id.to_string(),
                format!("{}{loop_}", one.setup.model.name()),
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
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.loaded.recording.time_s)
    }

    /// Simulated pressures, kPa gauge; float64 array of shape (rows, channels), NaN where the inputs are missing.
    #[getter]
    fn pressure_kpa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let array = PyArray2::zeros(py, [self.loaded.recording.rows(), self.channels.len()], false);
        {
            let mut view = array.readwrite();
            for (column, one) in self.channels.iter().enumerate() {
                for (row, value) in one.kpa.iter().enumerate() {
                    view.as_array_mut()[[row, column]] = *value;
                }
            }
        }
        array
    }

    /// Errors against the measured pressures, by channel: dictionaries as in ``Fit.fitted``, ``None`` where nothing was measured.
    #[getter]
    fn scores<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for one in &self.channels {
            dict.set_item(one.channel.id.to_string(), convert::score(py, one.score.as_ref())?)?;
        }
        Ok(dict)
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

/// Simulates the channels of a recording from its commands or drives alone.
///
/// Measured pressures are not used, except for the first of each stretch to start from, and to judge the simulation by.
///
/// Parameters
/// ----------
/// recording : Recording
///     Commands (for the linear model, or with the board's loop) or drives.
/// parameters : Parameters
///     Such as ``fit(...).parameters``. Their channels must include the recording's.
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
    parameters: &Parameters,
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
    let file = Arc::clone(&parameters.file);
    let name = parameters.name.clone();
    let rig = match rig {
        None => Arc::new(file.rig.clone()),
        given => RigArgument::resolve(given)?.0,
    };
    let loaded = Arc::clone(&recording.loaded);
    work::run(py, progress.as_ref(), move |watch| {
        watch.begin("simulating");
        let (recording, mut channels) = (&loaded.recording, Vec::new());
        for channel in &recording.channels {
            watch.checkpoint();
            channels.push(one(&name, &file, recording, channel, &rig, (controller, start_kpa))?);
            watch.tell(channels.len() as u64, recording.channels.len() as u64);
        }
        Ok(Simulation { loaded, channels })
    })?
}

fn one(
    name: &str,
    file: &ParameterFile,
    recording: &data::Recording,
    channel: &Channel,
    rig: &rig::Rig,
    (controller, start_kpa): (ControllerUse, f64),
) -> PyResult<SimulatedChannel> {
    let stored = file.channel(name, channel.id).map_err(errors::store)?;
    let controller = match controller {
        ControllerUse::Auto if stored.setup.controller => ControllerUse::On,
        chosen => chosen,
    };
    let drive = stored.setup.drive.unwrap_or_default();
    let setup = Setup::resolve(stored.setup.model, controller, drive, recording, channel, rig)
        .map_err(errors::unusable)?;
    let prepared =
        simulation(setup, recording, channel, rig, file.flow_form(), start_kpa).map_err(errors::unusable)?;
    let values = file.values(name, channel.id, &*prepared.subject).map_err(errors::store)?;
    let series = &prepared.series[0];
    let absolute = prepared.subject.simulate(&values, series, Start::Measured, stored.substeps);
    if series.segments().iter().any(|rows| absolute[rows.clone()].iter().any(|p| !p.is_finite())) {
        return Err(PneuDriveError::new_err(format!(
            "channel {}: the simulation runs away; the inputs or the rig are not what the parameters were fitted with",
            channel.id
        )));
    }
    let ambient_kpa = rig.ambient_or_standard().pressure_kpa_abs;
    let kpa = absolute.iter().map(|pa| pa * 1e-3 - ambient_kpa).collect();
    let score = (channel.usable_samples() > 0).then(|| score(series, &absolute)).flatten();
    Ok(SimulatedChannel { channel: channel.clone(), kpa, setup, score })
}
