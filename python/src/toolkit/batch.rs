use super::arguments::{self, RigArgument};
use super::expected::Expected;
use super::pool::Pool;
use super::shapes::{self, Extent, Field, FieldView, ParameterTable};
use super::work::{self, Watch};
use crate::arrays::shape_text;
use crate::errors;
use crate::types::{ArrayLike, Dict, NamedArrays};
use numpy::ndarray::{Dimension, Ix2, Ix3};
use numpy::{PyArray, PyArrayMethods};
use pneudrive_model::experiment::{DriveKind, ModelKind, Setup, Subject, subject};
use pneudrive_model::model::{FlowForm, column};
use pneudrive_model::rig::Rig;
use pneudrive_model::rollout::{
    BATCH_LANES, BatchColumn, BatchError, BatchInputs, BatchResults, BatchUnit, Job,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::Range;

const PA_PER_KPA: f64 = 1e3;

/// Runge-Kutta steps after which signals are looked for: some tenths of a second.
const PART_STEPS: usize = 4_000_000;

/// Chamber-rows below which a thread of its own costs more than the simulation.
const SMALL: usize = 20_000;

/// Pressures that can be meant, kPa gauge.
const PRESSURE_KPA: [f64; 2] = [-101.0, 10_000.0];

/// Chamber volumes that can be meant, m^3: a cubic millimetre to ten cubic metres.
const VOLUME_M3: [f64; 2] = [1e-9, 10.0];

/// Everything a batch needs, checked.
struct Batch<'a> {
    subject: &'a Subject,
    parameters: ParameterTable,
    interval_s: f64,
    valve: Valve<FieldView<'a>>,
    command_kpa: FieldView<'a>,
    supply_kpa: FieldView<'a>,
    inverse_volume_per_m3: FieldView<'a>,
    volume_rate_m3_s: FieldView<'a>,
    start_kpa: Vec<f64>,
    ambient_pa: f64,
    chambers: usize,
    rows: usize,
    substeps: usize,
}

/// What opens the valves.
enum Valve<F> {
    Spool(F),
    Separate {
        fill: F,
        vent: F,
    },
    /// The linear model and the boards' loops have no use for it.
    None,
}

impl<'py> Valve<Field<'py>> {
    fn fields(&self) -> Vec<&Field<'py>> {
        match self {
            Self::Spool(drive) => vec![drive],
            Self::Separate { fill, vent } => vec![fill, vent],
            Self::None => vec![],
        }
    }

    fn view(&self) -> Valve<FieldView<'_>> {
        match self {
            Self::Spool(drive) => Valve::Spool(drive.view()),
            Self::Separate { fill, vent } => Valve::Separate { fill: fill.view(), vent: vent.view() },
            Self::None => Valve::None,
        }
    }
}

impl Batch<'_> {
    /// The inputs of some chambers, laid out as in `model::column`.
    fn columns(&self, chambers: &Range<usize>) -> Vec<BatchColumn<'_>> {
        let mut columns = vec![BatchColumn::constant(0.0); column::COUNT];
        columns[column::INTERVAL_S] = BatchColumn::constant(self.interval_s);
        match &self.valve {
            Valve::Spool(drive) => {
                columns[column::FILL] = drive.column(chambers);
                columns[column::VENT] = drive.column(chambers).scaled(-1.0, 0.0);
            }
            Valve::Separate { fill, vent } => {
                columns[column::FILL] = fill.column(chambers);
                columns[column::VENT] = vent.column(chambers);
            }
            Valve::None => {}
        }
        let (command_kpa, supply_kpa) = (self.command_kpa.column(chambers), self.supply_kpa.column(chambers));
        columns[column::COMMAND_PA] = command_kpa.scaled(PA_PER_KPA, self.ambient_pa);
        columns[column::SUPPLY_PA] = supply_kpa.scaled(PA_PER_KPA, self.ambient_pa);
        columns[column::INVERSE_VOLUME_PER_M3] = self.inverse_volume_per_m3.column(chambers);
        columns[column::VOLUME_RATE_M3_S] = self.volume_rate_m3_s.column(chambers);
        columns
    }

    /// Writes kPa gauge [chamber][row], and kPa per unit of the parameter [chamber][row][parameter] if asked for.
    fn run(
        &self,
        watch: &Watch,
        pressures: &mut [f64],
        mut derivatives: Option<&mut [f64]>,
    ) -> Result<(), BatchError> {
        watch.begin("simulating");
        let count = self.subject.parameters().len();
        let steps = self.rows * self.substeps * self.subject.ticks(self.interval_s);
        let part = (PART_STEPS / steps).max(1).next_multiple_of(BATCH_LANES);
        for from in (0..self.chambers).step_by(part) {
            watch.tell(from as u64, self.chambers as u64);
            watch.checkpoint();
            let chambers = from..(from + part).min(self.chambers);
            let inputs = BatchInputs::new(self.columns(&chambers), chambers.len(), self.rows)?;
            let start = |chamber| self.ambient_pa + PA_PER_KPA * self.start_kpa(chamber);
            let rows = from * self.rows..chambers.end * self.rows;
            let jobs: Vec<Job<'_>> = chambers
                .map(|chamber| Job { parameters: self.parameters.of(chamber), start: start(chamber) })
                .collect();
            let results = BatchResults {
                sensitivities: derivatives
                    .as_mut()
                    .map(|derivatives| &mut derivatives[rows.start * count..rows.end * count]),
                outputs: &mut pressures[rows],
                unit: BatchUnit { zero_pa: self.ambient_pa, per_pa: 1.0 / PA_PER_KPA },
            };
            self.subject.batch(&jobs, &inputs, self.substeps, results)?;
        }
        Ok(())
    }

    fn start_kpa(&self, chamber: usize) -> f64 {
        self.start_kpa[if self.start_kpa.len() == 1 { 0 } else { chamber }]
    }
}

/// Simulates many chambers at once, each with parameters, inputs and a start of its own.
///
/// Arrays broadcast as in NumPy: what is given once holds for all chambers, or for all rows. Inputs of row k hold from row k to
/// row k + 1; supply and volume change linearly in between. The last row's inputs have no effect on the result.
///
/// Parameters
/// ----------
/// model : {"nonlinear", "parametric", "linear"}
/// parameters : array_like of float, shape (parameters,) or (chambers, parameters), or dict
///     In the order and units of ``model_parameters``; of a dict by name, each of shape () or (chambers,).
/// interval_s : float
///     Time between two rows, s.
/// drive : array_like of float, shape (rows,) or (chambers, rows), optional
///     Spool valves: -1 (vent) to 1 (fill).
/// fill, vent : array_like of float, shape (rows,) or (chambers, rows), optional
///     Instead of ``drive``: separate valves, 0 (closed) to 1 (open).
/// command_kpa : array_like of float, shape (rows,) or (chambers, rows), optional
///     Set points, kPa gauge, for the linear model or with ``controller``.
/// supply_kpa : array_like of float, shape (), (rows,) or (chambers, rows), optional
///     Supply pressure, kPa gauge; by default the rig's.
/// volume_m3 : array_like of float, shape (), (rows,) or (chambers, rows), optional
///     Chamber volume, m^3; by default the rig's, of the straight joint.
/// start_kpa : array_like of float, shape () or (chambers,), default 0.0
///     Pressure at the first row, kPa gauge.
/// rig : Rig or path, optional
///     Ambient pressure and temperature, valve constants, and what is not given above.
/// controller : bool, default False
///     Simulate the boards' pressure loops, which follow ``command_kpa``, in front of the valves; needs ``[controller]`` and
///     ``[sensor]`` of the rig.
/// substeps : int, default 1
///     Runge-Kutta steps per interval (per loop of the board with ``controller``), 1 to 1000.
/// sensitivities : bool, default False
///     Return derivatives, too. They are exact for the discretised model, not differences.
/// progress : callable, optional
///     Called with (parts done, parts in all, what is being done).
///
/// Returns
/// -------
/// pressure_kpa : numpy.ndarray of float64, shape (chambers, rows)
///     kPa gauge. Not finite where a simulation ran away.
/// sensitivity : numpy.ndarray of float64, shape (chambers, rows, parameters), only with ``sensitivities``
///     Derivatives of the pressures by the parameters, kPa per unit of the parameter.
///
/// Raises
/// ------
/// DataError
///     Shapes that do not fit, values that are not finite or not possible, something missing.
///
/// Notes
/// -----
/// Rows of 10 ms and one substep suffice for chambers of 0.1 litre and more behind valves of a few mm^2; compare with twice as
/// many substeps when in doubt. All cores are used; the environment variable ``RAYON_NUM_THREADS`` limits them. Contiguous arrays
/// of float64 are not copied: no other thread may change them meanwhile.
#[pyfunction]
#[pyo3(signature = (model, parameters, interval_s, *, drive=None, fill=None, vent=None, command_kpa=None, supply_kpa=None, volume_m3=None, start_kpa=None, rig=None, controller=false, substeps=1, sensitivities=false, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn simulate_batch<'py>(
    py: Python<'py>,
    model: &str,
    parameters: NamedArrays<'py>,
    interval_s: f64,
    drive: Option<ArrayLike<'py>>,
    fill: Option<ArrayLike<'py>>,
    vent: Option<ArrayLike<'py>>,
    command_kpa: Option<ArrayLike<'py>>,
    supply_kpa: Option<ArrayLike<'py>>,
    volume_m3: Option<ArrayLike<'py>>,
    start_kpa: Option<ArrayLike<'py>>,
    rig: Option<Expected<RigArgument>>,
    controller: bool,
    substeps: i64,
    sensitivities: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (rig, _) = RigArgument::resolve(rig)?;
    let model = arguments::model(model)?;
    if !(1e-6..=10.0).contains(&interval_s) {
        return Err(errors::unusable(format!("interval_s is {interval_s}; it must be 1e-6 to 10 s")));
    }
    if !(1..=1000).contains(&substeps) {
        return Err(errors::unusable(format!("substeps is {substeps}; it must be 1 to 1000")));
    }
    let by_command = model == ModelKind::Linear || controller;
    let separate = fill.is_some() || vent.is_some();
    let valve = valve(drive.as_ref(), fill.as_ref(), vent.as_ref(), by_command)?;
    let setup = setup(model, controller, separate);
    let subject = subject(setup, &rig, FlowForm::Iso6358).map_err(errors::unusable)?;
    let names: Vec<String> = subject.parameters().into_iter().map(|p| p.name).collect();
    let parameters = ParameterTable::extract(&parameters.0, &names)?;

    let command_kpa = match (&command_kpa, by_command) {
        (Some(command), true) => Field::extract("command_kpa", &command.0, PRESSURE_KPA, "kPa")?,
        (None, false) => Field::constant("command_kpa", 0.0),
        (Some(_), false) => {
            return Err(errors::unusable("command_kpa is for the linear model or with controller=True"));
        }
        (None, true) => return Err(errors::unusable("command_kpa is missing: nothing says what to follow")),
    };
    let supply_kpa = supply(supply_kpa.as_ref(), &rig, model)?;
    let volume_m3 = volume(volume_m3.as_ref(), &rig, model)?;
    let start_kpa = start(start_kpa.as_ref())?;

    let (mut chambers, mut rows) = (Extent::new("chambers"), Extent::new("rows"));
    chambers.join("parameters", parameters.chambers())?;
    chambers.join("start_kpa", start_kpa.len())?;
    let mut fields = valve.fields();
    fields.extend([&command_kpa, &supply_kpa, &volume_m3]);
    shapes::joint(&mut chambers, &mut rows, &fields)?;
    let (supply_mean, inverse_volume) =
        (supply_kpa.pairwise(mean), volume_m3.pairwise(|here, there| mean(here, there).recip()));
    let volume_rate_m3_s = volume_m3.pairwise(|here, there| (there - here) / interval_s);
    let batch = Batch {
        subject: &subject,
        parameters,
        interval_s,
        valve: valve.view(),
        command_kpa: command_kpa.view(),
        supply_kpa: supply_mean.view(),
        inverse_volume_per_m3: inverse_volume.view(),
        volume_rate_m3_s: volume_rate_m3_s.view(),
        start_kpa,
        ambient_pa: rig.ambient_or_standard().pressure_kpa_abs * PA_PER_KPA,
        chambers: chambers.number(),
        rows: rows.number(),
        substeps: usize::try_from(substeps).unwrap_or(1),
    };
    let (chambers, rows, count) = (batch.chambers, batch.rows, names.len());
    check_size(chambers, rows, if sensitivities { count + 1 } else { 1 })?;
    let pressures: Bound<'py, PyArray<f64, Ix2>> = empty(py, (chambers, rows))?;
    let derivatives: Option<Bound<'py, PyArray<f64, Ix3>>> =
        if sensitivities { Some(empty(py, (chambers, rows, count))?) } else { None };
    {
        let mut pressures = pressures.readwrite();
        let mut derivatives = derivatives.as_ref().map(PyArrayMethods::readwrite);
        let pressures = pressures.as_slice_mut()?;
        let derivatives = match &mut derivatives {
            Some(derivatives) => Some(derivatives.as_slice_mut()?),
            None => None,
        };
        let small =
            progress.is_none() && chambers * rows * substeps.unsigned_abs() as usize <= SMALL && !controller;
        let outcome = if small {
            let pool = Pool::of_this_process()?;
            py.detach(|| pool.run(|| batch.run(&Watch::default(), pressures, derivatives)))
        } else {
            work::run_scoped(py, progress.as_ref(), |watch| batch.run(watch, pressures, derivatives))?
        };
        if matches!(outcome, Err(BatchError::Range { .. })) {
            valve.fields().into_iter().chain([&command_kpa]).try_for_each(Field::check)?;
        }
        outcome.map_err(errors::unusable)?;
    }
    match derivatives {
        None => Ok(pressures.into_any()),
        Some(derivatives) => Ok((pressures, derivatives).into_pyobject(py)?.into_any()),
    }
}

fn mean(here: f64, there: f64) -> f64 {
    0.5 * (here + there)
}

/// `numpy.empty`: for large arrays NumPy asks the system for huge pages, which cost few page faults, and nobody writes zeros first.
fn empty<'py, D: Dimension>(
    py: Python<'py>,
    shape: impl IntoPyObject<'py>,
) -> PyResult<Bound<'py, PyArray<f64, D>>> {
    let array = py.import("numpy")?.call_method1("empty", (shape,))?;
    Ok(array.cast_into()?)
}

fn setup(model: ModelKind, controller: bool, separate: bool) -> Setup {
    let kind = if separate { DriveKind::Separate } else { DriveKind::Spool };
    let linear = model == ModelKind::Linear;
    Setup { model, drive: (!linear).then_some(kind), controller: controller && !linear }
}

/// What opens the valves, of what was given.
fn valve<'py>(
    drive: Option<&ArrayLike<'py>>,
    fill: Option<&ArrayLike<'py>>,
    vent: Option<&ArrayLike<'py>>,
    by_command: bool,
) -> PyResult<Valve<Field<'py>>> {
    let half = [0.0, 1.0];
    match (drive, fill, vent) {
        (None, None, None) if by_command => Ok(Valve::None),
        (None, None, None) => Err(errors::unusable("neither drive nor fill and vent are given")),
        _ if by_command => Err(errors::unusable(
            "drive, fill and vent are not used by the linear model or with controller=True",
        )),
        (Some(drive), None, None) => Ok(Valve::Spool(Field::extract("drive", &drive.0, [-1.0, 1.0], "")?)),
        (None, Some(fill), Some(vent)) => Ok(Valve::Separate {
            fill: Field::extract("fill", &fill.0, half, "")?,
            vent: Field::extract("vent", &vent.0, half, "")?,
        }),
        _ => Err(errors::unusable("give drive, or both fill and vent")),
    }
}

fn supply<'py>(given: Option<&ArrayLike<'py>>, rig: &Rig, model: ModelKind) -> PyResult<Field<'py>> {
    match (given, &rig.supply) {
        (Some(given), _) => Field::extract("supply_kpa", &given.0, PRESSURE_KPA, "kPa")?.checked(),
        (None, Some(supply)) => Ok(Field::constant("supply_kpa", supply.pressure_kpa)),
        (None, None) if model == ModelKind::Linear => Ok(Field::constant("supply_kpa", 0.0)),
        (None, None) => Err(errors::unusable("supply_kpa is missing: give it, or a rig with [supply]")),
    }
}

fn volume<'py>(given: Option<&ArrayLike<'py>>, rig: &Rig, model: ModelKind) -> PyResult<Field<'py>> {
    match (given, &rig.chamber) {
        (Some(given), _) => Field::extract("volume_m3", &given.0, VOLUME_M3, "m^3")?.checked(),
        (None, Some(chamber)) => Ok(Field::constant("volume_m3", chamber.rest_volume_m3())),
        (None, None) if model == ModelKind::Linear => Ok(Field::constant("volume_m3", 1.0)),
        (None, None) => Err(errors::unusable("volume_m3 is missing: give it, or a rig with [chamber]")),
    }
}

fn start(given: Option<&ArrayLike<'_>>) -> PyResult<Vec<f64>> {
    let Some(given) = given else { return Ok(vec![0.0]) };
    let (shape, values) = shapes::numbers("start_kpa", &given.0)?;
    if shape.len() > 1 {
        return Err(errors::unusable(format!(
            "start_kpa has shape {}; expected () or (chambers,)",
            shape_text(&shape)
        )));
    }
    let [low, high] = PRESSURE_KPA;
    match values.iter().position(|kpa| !(*kpa >= low && *kpa <= high)) {
        None => Ok(values.to_vec()),
        Some(at) => Err(errors::unusable(format!(
            "start_kpa of chamber {at} is {}; it must be {low} to {high} kPa",
            values[at]
        ))),
    }
}

/// Refuses what cannot be meant before memory for it is asked for.
fn check_size(chambers: usize, rows: usize, per_row: usize) -> PyResult<()> {
    const MOST: usize = 1 << 32;
    let values = chambers.checked_mul(rows).and_then(|all| all.checked_mul(per_row));
    match values {
        Some(values) if values <= MOST => Ok(()),
        _ => Err(errors::unusable(format!(
            "{chambers} chambers by {rows} rows make too large a result; simulate in parts"
        ))),
    }
}

/// One parameter's description.
type Parameter<'py> = Dict<'py, Bound<'py, PyAny>>;

/// The parameters of a model, in the order that ``simulate_batch`` takes them.
///
/// Parameters
/// ----------
/// model : {"nonlinear", "parametric", "linear"}
/// drive : {"spool", "separate"}, default "spool"
///     Kind of valve.
///
/// Returns
/// -------
/// list of dict
///     ``name``, ``unit``, ``lower``, ``nominal``, ``upper``, ``meaning``.
#[pyfunction]
#[pyo3(signature = (model, drive="spool"))]
pub fn model_parameters<'py>(py: Python<'py>, model: &str, drive: &str) -> PyResult<Vec<Parameter<'py>>> {
    let separate = arguments::drive(drive)? == DriveKind::Separate;
    let setup = setup(arguments::model(model)?, false, separate);
    let subject = subject(setup, &Rig::default(), FlowForm::Iso6358).map_err(errors::unusable)?;
    let describe = |parameter: pneudrive_model::model::Parameter| {
        let dict = PyDict::new(py);
        dict.set_item("name", parameter.name)?;
        dict.set_item("unit", parameter.unit)?;
        dict.set_item("lower", parameter.lower)?;
        dict.set_item("nominal", parameter.nominal)?;
        dict.set_item("upper", parameter.upper)?;
        dict.set_item("meaning", parameter.meaning)?;
        Ok(Dict::new(dict))
    };
    subject.parameters().into_iter().map(describe).collect()
}
