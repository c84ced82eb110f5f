use super::arguments::{self, RigArgument};
use super::convert::{self, ScoreDict};
use super::displays;
use super::expected::{Described, Expected};
use super::extended::ExtendedModel;
use super::parameters::Parameters;
use super::recording::Recording;
use super::work::{self, Watch};
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::{Array, Dict, Matrix, Vector};
use numpy::ndarray::Ix3;
use numpy::{PyArray, PyArray1, PyArray2, PyArrayMethods};
use pneudrive_model::data::{ChannelId, Loaded};
use pneudrive_model::experiment::Score;
use pneudrive_model::report::{Colour, Table, fragment, html, significant};
use pneudrive_model::simulation::{self, CalibratedModel, SimulationSettings};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Simulated pressures of the channels of a recording.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Simulation {
    loaded: Arc<Loaded>,
    channels: Vec<Trace>,
}

/// One channel, as it is kept.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Trace {
    id: ChannelId,
    model: String,
    kpa: Vec<f64>,
    score: Option<Score>,
    band: Option<Band>,
}

/// The 95 % band around it.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Band {
    half_width_kpa: Vec<f64>,
    holds: Option<f64>,
}

const HEAD: [&str; 4] = ["channel", "model", "RMSE, kPa", "R2"];

impl Simulation {
    fn rows(&self) -> Vec<Vec<String>> {
        let line = |one: &Trace| {
            vec![
                one.id.to_string(),
                one.model.clone(),
                convert::rmse(one.score.as_ref()),
                one.score.as_ref().map_or_else(|| "-".to_owned(), |score| significant(score.r2, 4)),
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
        self.channels.iter().map(|one| one.id.to_string()).collect()
    }

    /// Time of each row, s; float64 array of shape (rows,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        Array(PyArray1::from_slice(py, &self.loaded.recording.time_s))
    }

    /// Simulated pressures, kPa gauge; float64 array of shape (rows, channels), NaN where the
    /// inputs are missing.
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

    /// The 95 % band around each simulated pressure, kPa gauge; float64 array of shape (rows,
    /// channels, 2): lowest and highest. The models of ``diagnose`` have one; NaN for those of a
    /// fit, and where the inputs are missing.
    #[getter]
    fn band_kpa<'py>(&self, py: Python<'py>) -> Array<'py, f64, Ix3> {
        let array = PyArray::zeros(py, [self.loaded.recording.rows(), self.channels.len(), 2], false);
        {
            let mut view = array.readwrite();
            for (column, one) in self.channels.iter().enumerate() {
                for (row, kpa) in one.kpa.iter().enumerate() {
                    let half_kpa = one.band.as_ref().map_or(f64::NAN, |band| band.half_width_kpa[row]);
                    view.as_array_mut()[[row, column, 0]] = kpa - half_kpa;
                    view.as_array_mut()[[row, column, 1]] = kpa + half_kpa;
                }
            }
        }
        Array(array)
    }

    /// Share of the measured pressures that the band holds, by channel: 0 to 1, ``None`` where
    /// there is no band or nothing was measured.
    #[getter]
    fn band_holds<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Option<f64>>> {
        let dict = PyDict::new(py);
        for one in &self.channels {
            dict.set_item(one.id.to_string(), one.band.as_ref().and_then(|band| band.holds))?;
        }
        Ok(Dict::new(dict))
    }

    /// Errors against the measured pressures, by channel: dictionaries as in ``Fit.fitted``,
    /// ``None`` where nothing was measured.
    #[getter]
    fn scores<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, ScoreDict<'py>>> {
        let dict = PyDict::new(py);
        for one in &self.channels {
            dict.set_item(one.id.to_string(), convert::score(py, one.score.as_ref())?)?;
        }
        Ok(Dict::new(dict))
    }

    /// Measured and simulated pressures of one channel where they can be compared: where the
    /// measured one may be used.
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
    ///     simulated): float64 arrays of shape (compared rows,).
    fn residuals<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Dict<'py, Vector<'py>>> {
        let one = self.channels.iter().find(|one| one.id.to_string() == channel).ok_or_else(|| {
            errors::unusable(format!(
                "no channel {channel} was simulated; there is {}",
                self.channels().join(", ")
            ))
        })?;
        let recording = &self.loaded.recording;
        let data = recording.channel(one.id).map_err(errors::recording)?;
        let measured = recording.pressure(data, "which a residual needs").map_err(errors::recording)?;
        let compared = |row: &usize| {
            data.flags[*row].pressure_usable() && measured[*row].is_finite() && one.kpa[*row].is_finite()
        };
        let rows: Vec<usize> = (0..recording.rows()).filter(compared).collect();
        let column =
            |value: &dyn Fn(usize) -> f64| PyArray1::from_iter(py, rows.iter().map(|row| value(*row)));
        let dict = PyDict::new(py);
        dict.set_item("t_s", column(&|row| recording.time_s[row]))?;
        dict.set_item("measured_kpa", column(&|row| f64::from(measured[row])))?;
        dict.set_item("simulated_kpa", column(&|row| one.kpa[row]))?;
        dict.set_item("residual_kpa", column(&|row| f64::from(measured[row]) - one.kpa[row]))?;
        Ok(Dict::new(dict))
    }

    /// Draws measured and simulated pressures, and their difference (needs matplotlib): see
    /// ``pneudrive_py.plots.simulation``, which takes the same keywords.
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
        slf.py().import("pneudrive_py.plots")?.call_method("simulation", (slf, channels), options)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        pickling::reduce(slf.as_any(), &(&*slf.get().loaded, &slf.get().channels))
    }

    #[staticmethod]
    fn _unpickle(state: &[u8]) -> PyResult<Self> {
        let (loaded, channels): (Loaded, Vec<Trace>) = pickling::state(state)?;
        Ok(Self { loaded: Arc::new(loaded), channels })
    }

    /// The recording with simulated pressures in place of the measured ones.
    #[getter]
    fn recording(&self) -> Recording {
        let mut loaded = (*self.loaded).clone();
        for channel in &mut loaded.recording.channels {
            if let Some(one) = self.channels.iter().find(|one| one.id == channel.id) {
                #[allow(clippy::cast_possible_truncation)] // columns are kept in single precision
                let kpa = one.kpa.iter().map(|kpa| *kpa as f32).collect();
                channel.pressure_kpa = Some(kpa);
            }
        }
        Recording::new(loaded)
    }

    fn __repr__(&self) -> String {
        format!("Simulation\n{}", Table::text(&HEAD, &self.rows()))
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        let simulated = slf.get();
        let drawn = simulated.channels.first().map(|first| {
            let (name, of) = (first.id.to_string(), simulated.channels.len());
            // Where nothing was measured there are no residuals to draw.
            let Ok(residuals) = simulated.residuals(slf.py(), &name) else { return Ok(html! {}) };
            let shown = (format!("{} model", first.model), Colour::Blue);
            displays::of_residuals(&residuals.0.into_any(), (&name, of), (&shown.0, shown.1), None)
        });
        let (table, drawn) = (convert::table(&HEAD, 2, &simulated.rows()), drawn.transpose()?);
        Ok(fragment(&html! { (table.markup()) @if let Some(drawn) = drawn { (drawn) } }).into_string())
    }
}

/// What can be simulated.
#[derive(FromPyObject)]
pub enum Simulated {
    Fitted(Py<Parameters>),
    Extended(Py<ExtendedModel>),
}

impl Described for Simulated {
    const EXPECTED: &'static str = "Parameters or an ExtendedModel";
}

/// Simulates the channels of a recording from its commands or drives alone.
///
/// Measured pressures are not used, except for the first of each stretch to start from, and to
/// judge the simulation by.
///
/// Parameters
/// ----------
/// recording : Recording
///     Commands (for the linear model, or with the board's loop) or drives.
/// parameters : Parameters or ExtendedModel
///     Such as ``fit(...).parameters`` or ``diagnose(...).extended_model``. Their channels must
///     include the recording's.
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
    recording: Expected<Py<Recording>>,
    parameters: Expected<Simulated>,
    rig: Option<Expected<RigArgument>>,
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
    let model = match parameters.0 {
        Simulated::Fitted(parameters) => {
            let Parameters { name, file, .. } = parameters.get();
            CalibratedModel::Fitted { name: name.clone(), file: Arc::clone(file) }
        }
        Simulated::Extended(model) => {
            let ExtendedModel { name, file, .. } = model.get();
            CalibratedModel::Extended { name: name.clone(), file: Arc::clone(file) }
        }
    };
    let loaded = Arc::clone(&recording.0.get().loaded);
    let simulation = {
        let loaded = Arc::clone(&loaded);
        work::run(py, progress.as_ref(), move |watch: &Watch| {
            watch.begin("simulating");
            let settings = SimulationSettings { rig: rig.as_deref(), controller, start_kpa };
            simulation::simulate(&model, &loaded.recording, &settings, &mut |done, all| {
                watch.checkpoint();
                watch.tell(done as u64, all as u64);
            })
        })?
    };
    let simulated = simulation.map_err(errors::simulation)?.channels.into_iter();
    let channels = simulated.map(|one| {
        let simulation::SimulatedChannel { id, model, kpa, score, band } = one;
        let band =
            band.map(|simulation::SimulatedBand { half_width_kpa, holds }| Band { half_width_kpa, holds });
        Trace { id, model: model.words(), kpa, score, band }
    });
    Ok(Simulation { loaded, channels: channels.collect() })
}
