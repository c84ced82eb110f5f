mod channels;
mod inputs;

use self::channels::Channels;
use self::inputs::{Given, PRESSURE_KPA, one_each};
use super::arguments;
use super::expected::{Expected, Names};
use super::extended::ExtendedModel;
use super::parameters::Parameters;
use super::shapes;
use super::simulation::Simulated;
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::{Array, ArrayLike, Vector};
use numpy::PyArray1;
use pneudrive_capi::Outputs;
use pneudrive_model::diagnosis::ExtendedFile;
use pneudrive_model::simulation::CalibratedModel;
use pneudrive_model::store::ParameterFile;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What `_unpickle` makes the same object of.
#[derive(Serialize, Deserialize)]
struct Pickle<F> {
    name: String,
    file: F,
    channels: Vec<String>,
    step_s: f64,
    control: String,
    state: Vec<f64>,
}

/// Calibrated channels, simulated step by step: a plant for a controller, or a model that a
/// controller looks ahead with.
///
/// A step is what ``simulate`` does between two rows of a recording, with the same numbers, effects
/// of a diagnosis included. Each channel is simulated for itself: what other channels do to it
/// (``chamber_coupling``, ``sensor_crosstalk``, ``supply_sag`` by others) is left out. It can be
/// pickled and copied, uses no threads of its own, and may be used in a forked child.
///
/// Parameters
/// ----------
/// model : Parameters or ExtendedModel
///     Such as ``fit(...).parameters`` or ``diagnose(...).extended_model``; one without a smooth
///     correction.
/// channels : sequence of str, optional
///     Such as ``["b0c0", "b0c1"]``; by default all of the model's.
/// step_s : float, default 0.01
///     Length of a step, 1e-5 to 1 s; a whole number of the board's loops where a set point drives.
/// control : {"calibrated", "drive", "set_point"}, default "calibrated"
///     What a step is given: the valve's drive, or a set point that the board's loop inside follows
///     (the model's rig needs ``[controller]`` and ``[sensor]``); by default what drove the channel
///     when it was calibrated.
///
/// Raises
/// ------
/// DataError
///     No such channel, or a step or a control that the model cannot have.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Stepper {
    model: CalibratedModel,
    control: String,
    step_s: f64,
    channels: Channels,
}

impl Stepper {
    fn make(model: CalibratedModel, names: &[String], step_s: f64, control: &str) -> PyResult<Self> {
        let channels = Channels::new(&model, names, step_s, arguments::control(control)?)?;
        Ok(Self { model, control: control.to_owned(), step_s, channels })
    }

    fn each<'py>(&self, py: Python<'py>, of: impl Fn(&Outputs) -> f64) -> Vector<'py> {
        Array(PyArray1::from_vec(py, self.channels.outputs(of)))
    }
}

#[pymethods]
impl Stepper {
    #[new]
    #[pyo3(signature = (model, *, channels=None, step_s=0.01, control="calibrated"))]
    fn new(
        model: Expected<Simulated>,
        channels: Option<Expected<Names>>,
        step_s: f64,
        control: &str,
    ) -> PyResult<Self> {
        let (model, all) = match model.0 {
            Simulated::Fitted(parameters) => {
                let Parameters { name, file, .. } = parameters.get();
                let all: Vec<String> = file.channels.keys().map(ToString::to_string).collect();
                (CalibratedModel::Fitted { name: name.clone(), file: Arc::clone(file) }, all)
            }
            Simulated::Extended(model) => {
                let ExtendedModel { name, file, .. } = model.get();
                let all = file.channels.keys().cloned().collect();
                (CalibratedModel::Extended { name: name.clone(), file: Arc::clone(file) }, all)
            }
        };
        let names = channels.map_or(all, |Expected(Names(names))| names);
        Self::make(model, &names, step_s, control)
    }

    /// Begins at rest, at time 0.
    ///
    /// Parameters
    /// ----------
    /// pressure_kpa : array_like of float, shape () or (channels,), default 0.0
    ///     kPa gauge.
    #[pyo3(signature = (pressure_kpa=None))]
    fn start(&self, pressure_kpa: Option<ArrayLike<'_>>) -> PyResult<()> {
        let kpa = one_each("pressure_kpa", pressure_kpa.as_ref(), self.channels.number(), PRESSURE_KPA)?;
        self.channels.start(|k| kpa.as_ref().map_or(0.0, |kpa| kpa[k]))
    }

    /// Advances by a step over which the inputs hold.
    ///
    /// Parameters
    /// ----------
    /// drive : array_like of float, shape () or (channels,), optional
    ///     Of spool valves, -1 (vent) to 1 (fill).
    /// fill, vent : array_like of float, shape () or (channels,), optional
    ///     Of separate valves, 0 (closed) to 1 (open).
    /// set_point_kpa : array_like of float, shape () or (channels,), optional
    ///     For channels that follow set points, kPa gauge. As on the bus, the board follows it from
    ///     its second loop in the step on.
    /// supply_kpa : array_like of float, shape () or (channels,), optional
    ///     Mean supply pressure over the step, kPa gauge; by default the rig's.
    /// volume_m3 : array_like of float, shape () or (channels,), optional
    ///     Mean chamber volume over the step, m^3; by default the rig's, of the straight joint.
    /// volume_rate_m3_s : array_like of float, shape () or (channels,), default 0.0
    ///     Its rate, m^3/s.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of float64, shape (channels,)
    ///     Pressures in the chambers at the end of the step, kPa gauge.
    ///
    /// Raises
    /// ------
    /// DataError
    ///     An input that is missing, not possible, or not used by any channel: nothing was
    ///     advanced. A pressure that runs away: set ``state`` to one of before, or ``start``.
    #[pyo3(signature = (*, drive=None, fill=None, vent=None, set_point_kpa=None, supply_kpa=None, volume_m3=None, volume_rate_m3_s=None))]
    #[allow(clippy::too_many_arguments)] // keywords of the Python method
    fn step<'py>(
        &self,
        py: Python<'py>,
        drive: Option<ArrayLike<'py>>,
        fill: Option<ArrayLike<'py>>,
        vent: Option<ArrayLike<'py>>,
        set_point_kpa: Option<ArrayLike<'py>>,
        supply_kpa: Option<ArrayLike<'py>>,
        volume_m3: Option<ArrayLike<'py>>,
        volume_rate_m3_s: Option<ArrayLike<'py>>,
    ) -> PyResult<Vector<'py>> {
        let given = Given {
            drive: drive.as_ref(),
            fill: fill.as_ref(),
            vent: vent.as_ref(),
            set_point_kpa: set_point_kpa.as_ref(),
            supply_kpa: supply_kpa.as_ref(),
            volume_m3: volume_m3.as_ref(),
            volume_rate_m3_s: volume_rate_m3_s.as_ref(),
        };
        let inputs = given.inputs(self.channels.about())?;
        // The lock is taken and given back without the interpreter's: whoever waits for one has not
        // the other.
        py.detach(|| self.channels.step(&inputs))?;
        Ok(self.pressure_kpa(py))
    }

    /// Names of the channels, in the order of all arrays.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.channels.about().iter().map(|one| one.name.clone()).collect()
    }

    /// Length of a step, s.
    #[getter]
    fn step_s(&self) -> f64 {
        self.step_s
    }

    /// ``"calibrated"``, ``"drive"`` or ``"set_point"``.
    #[getter]
    fn control(&self) -> &str {
        &self.control
    }

    /// Time since the start, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.channels.outputs(|outputs| outputs.time_s)[0]
    }

    /// Pressures in the chambers, kPa gauge; float64 array of shape (channels,).
    #[getter]
    fn pressure_kpa<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.each(py, |outputs| outputs.pressure_kpa)
    }

    /// What the boards report, kPa gauge; float64 array of shape (channels,).
    #[getter]
    fn reading_kpa<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.each(py, |outputs| outputs.reading_kpa)
    }

    /// Drives of the valves in the last step, -1 to 1, fill minus vent of separate ones; float64
    /// array of shape (channels,), NaN of the linear model.
    #[getter]
    fn drive<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.each(py, |outputs| outputs.drive)
    }

    /// The whole state, a float64 array of shape (n,): with it a stepper of the same model,
    /// channels, step and control goes on with the same numbers.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        Ok(Array(PyArray1::from_vec(py, self.channels.save()?)))
    }

    #[setter]
    fn set_state(&self, state: ArrayLike<'_>) -> PyResult<()> {
        let (_, values) = shapes::numbers("state", &state.0)?;
        self.channels.restore(&values)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let this = slf.get();
        let (channels, step_s, control, state) =
            (this.channels(), this.step_s, this.control.clone(), this.channels.save()?);
        match &this.model {
            CalibratedModel::Fitted { name, file } => {
                let fitted = Pickle { name: name.clone(), file: &**file, channels, step_s, control, state };
                pickling::reduce(slf.as_any(), &(Some(fitted), None::<Pickle<&ExtendedFile>>))
            }
            CalibratedModel::Extended { name, file } => {
                let extended = Pickle { name: name.clone(), file: &**file, channels, step_s, control, state };
                pickling::reduce(slf.as_any(), &(None::<Pickle<&ParameterFile>>, Some(extended)))
            }
        }
    }

    #[staticmethod]
    fn _unpickle(state: &[u8]) -> PyResult<Self> {
        type Either = (Option<Pickle<ParameterFile>>, Option<Pickle<ExtendedFile>>);
        fn made<F>(
            pickle: Pickle<F>,
            model: impl FnOnce(String, Arc<F>) -> CalibratedModel,
        ) -> PyResult<Stepper> {
            let Pickle { name, file, channels, step_s, control, state } = pickle;
            let stepper = Stepper::make(model(name, Arc::new(file)), &channels, step_s, &control)?;
            stepper.channels.restore(&state)?;
            Ok(stepper)
        }
        match pickling::state::<Either>(state)? {
            (Some(pickle), _) => made(pickle, |name, file| CalibratedModel::Fitted { name, file }),
            (None, Some(pickle)) => made(pickle, |name, file| CalibratedModel::Extended { name, file }),
            (None, None) => Err(errors::unusable("the pickle holds no model")),
        }
    }

    fn __repr__(&self) -> String {
        let about = self.channels.about().iter().zip(self.channels.outputs(|outputs| outputs.pressure_kpa));
        let channels: Vec<String> = about.map(|(one, kpa)| format!("{} {kpa:.2} kPa", one.name)).collect();
        format!("<Stepper at {:.3} s: {}>", self.time_s(), channels.join(", "))
    }
}
