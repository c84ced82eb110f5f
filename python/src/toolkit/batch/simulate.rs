use super::super::arguments::RigArgument;
use super::super::expected::Expected;
use super::super::work::Watch;
use super::given::Given;
use super::plant::{ModelArgument, Simulator};
use super::precision::Precision;
use super::prepared::Batch;
use super::{PA_PER_KPA, compute};
use crate::errors;
use crate::types::{ArrayLike, NamedArrays};
use numpy::ndarray::{Dimension, Ix2, Ix3};
use numpy::{Element, PyArray, PyArrayMethods, dtype};
use pneudrive_model::rollout::{BATCH_LANES, BatchError, BatchResults, BatchUnit, SINGLE_LANES};
use pyo3::prelude::*;

/// Runge-Kutta steps after which signals are looked for: some tenths of a second.
const PART_STEPS: usize = 4_000_000;

/// Where results go: kPa gauge `[chamber][row]`.
enum Room<'a> {
    Double {
        pressures: &'a mut [f64],
        /// If asked for, kPa per unit of the parameter, `[chamber][row][parameter]`.
        derivatives: Option<&'a mut [f64]>,
    },
    Single(&'a mut [f32]),
}

impl Batch<'_> {
    fn simulate(&self, watch: &Watch, mut room: Room<'_>) -> Result<(), BatchError> {
        watch.begin("simulating");
        let count = self.simulator.parameters().len();
        let lanes = if matches!(room, Room::Single(_)) { SINGLE_LANES } else { BATCH_LANES };
        let unit = BatchUnit { zero_pa: self.ambient_pa, per_pa: 1.0 / PA_PER_KPA };
        for chambers in self.parts(PART_STEPS / self.steps(), lanes) {
            watch.tell(chambers.start as u64, self.chambers as u64);
            watch.checkpoint();
            let inputs = self.inputs(&chambers)?;
            let rows = chambers.start * self.rows..chambers.end * self.rows;
            let jobs = self.jobs(chambers);
            match &mut room {
                Room::Double { pressures, derivatives } => {
                    let sensitivities =
                        derivatives.as_mut().map(|all| &mut all[rows.start * count..rows.end * count]);
                    let results = BatchResults { sensitivities, outputs: &mut pressures[rows], unit };
                    match self.simulator {
                        Simulator::Lanes { subject, substeps } => {
                            subject.batch(&jobs, &inputs, *substeps, results)?;
                        }
                        Simulator::Effects(rollouts) => rollouts.simulate(&jobs, &inputs, results)?,
                    }
                }
                Room::Single(pressures) => {
                    let Simulator::Lanes { subject, substeps } = self.simulator else { continue };
                    subject.batch_single(&jobs, &inputs, *substeps, &mut pressures[rows], unit)?;
                }
            }
        }
        Ok(())
    }
}

/// Simulates many chambers at once, each with parameters, inputs and a start of its own.
///
/// Arrays broadcast as in NumPy: what is given once holds for all chambers, or for all rows. Inputs
/// of row k hold from row k to row k + 1; supply and volume change linearly in between. The last
/// row's inputs have no effect on the result.
///
/// Parameters
/// ----------
/// model : {"nonlinear", "parametric", "linear"}, Parameters or ExtendedModel
///     A model by its name, or one that was calibrated, such as ``fit(...).parameters`` or
///     ``diagnose(...).extended_model``: with its rig, its effects, and what drove it. What other
///     channels do to the chambers is left out.
/// parameters : array_like of float, shape (parameters,) or (chambers, parameters), dict, None
///     In the order and units of ``model_parameters``; of a dict by name, each of shape () or
///     (chambers,). ``None``, and what a dict leaves out, are the values of a calibrated model.
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
///     Ambient pressure and temperature, valve constants, and what is not given above. Not for a
///     calibrated model, which has its own.
/// controller : bool, optional
///     Simulate the boards' pressure loops, which follow ``command_kpa``, in front of the valves;
///     needs ``[controller]`` and ``[sensor]`` of the rig. By default not, and for a calibrated
///     model as it was calibrated.
/// substeps : int, optional
///     Runge-Kutta steps per interval (per loop of the board with ``controller``), 1 to 1000; by
///     default 1, or what a fit chose. Not for an ``ExtendedModel``, which steps by 2.5 ms at most.
/// sensitivities : bool, default False
///     Return derivatives by the parameters, too. They are exact for the discretised model, not
///     differences. ``batch_gradient`` has those by everything else.
/// dtype : {numpy.float64, numpy.float32}, default numpy.float64
///     Of the result. In float32 the simulation itself is in single precision, about twice as fast:
///     pressures are within 0.02 kPa of those in float64 over 20,000 rows.
/// channel : str, optional
///     Of a calibrated model, such as ``"b0c1"``; by default its only one.
/// progress : callable, optional
///     Called with (parts done, parts in all, what is being done).
///
/// Returns
/// -------
/// pressure_kpa : numpy.ndarray of ``dtype``, shape (chambers, rows)
///     kPa gauge. Not finite where a simulation ran away.
/// sensitivity : numpy.ndarray of float64, shape (chambers, rows, parameters), only with
/// ``sensitivities``
///     Derivatives of the pressures by the parameters, kPa per unit of the parameter.
///
/// Raises
/// ------
/// DataError
///     Shapes that do not fit, values that are not finite or not possible, something missing;
///     float32 with ``sensitivities``, ``controller`` or effects; ``sensitivities`` of a model with
///     a smooth correction.
///
/// Notes
/// -----
/// Rows of 10 ms and one substep suffice for chambers of 0.1 litre and more behind valves of a few
/// mm^2; compare with twice as many substeps when in doubt. An ``ExtendedModel`` gives what
/// ``simulate`` gives for a recording of the same inputs, chamber by chamber instead of many in
/// lockstep: 30 to 120 times as long a row (docs/performance.md). All cores are used; the
/// environment variable ``RAYON_NUM_THREADS`` limits them. Contiguous arrays of float64, and of
/// float32 with shape (chambers, rows), are not copied: no other thread may change them meanwhile.
#[pyfunction]
#[pyo3(signature = (model, parameters, interval_s, *, drive=None, fill=None, vent=None, command_kpa=None, supply_kpa=None, volume_m3=None, start_kpa=None, rig=None, controller=None, substeps=None, sensitivities=false, dtype=None, channel=None, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn simulate_batch<'py>(
    py: Python<'py>,
    model: Expected<ModelArgument>,
    parameters: Option<NamedArrays<'py>>,
    interval_s: f64,
    drive: Option<ArrayLike<'py>>,
    fill: Option<ArrayLike<'py>>,
    vent: Option<ArrayLike<'py>>,
    command_kpa: Option<ArrayLike<'py>>,
    supply_kpa: Option<ArrayLike<'py>>,
    volume_m3: Option<ArrayLike<'py>>,
    start_kpa: Option<ArrayLike<'py>>,
    rig: Option<Expected<RigArgument>>,
    controller: Option<bool>,
    substeps: Option<i64>,
    sensitivities: bool,
    dtype: Option<Precision>,
    channel: Option<&str>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let given = Given {
        model: model.0,
        channel,
        parameters,
        interval_s,
        drive,
        fill,
        vent,
        command_kpa,
        supply_kpa,
        volume_m3,
        start_kpa,
        rig,
        controller,
        substeps,
    };
    let prepared = given.prepare()?;
    let precision = dtype.unwrap_or_default();
    if precision == Precision::Single && sensitivities {
        return Err(errors::unusable("sensitivities are computed in float64 only: leave dtype out"));
    }
    if precision == Precision::Single && matches!(prepared.simulator, Simulator::Effects(_)) {
        return Err(errors::unusable("effects are simulated in float64 only: leave dtype out"));
    }
    if precision == Precision::Single && prepared.controller {
        // A reading that single precision rounds to the next count of the converter changes the
        // drive.
        return Err(errors::unusable(
            "boards' loops (controller=True) are simulated in float64 only: leave dtype out",
        ));
    }
    let (chambers, rows) = (prepared.chambers.number(), prepared.rows.number());
    let count = prepared.simulator.parameters().len();
    prepared.check_size(if sensitivities { count + 1 } else { 1 })?;
    let small = prepared.is_small();
    if precision == Precision::Single {
        let pressures: Bound<'py, PyArray<f32, Ix2>> = empty(py, (chambers, rows))?;
        {
            let (batch, mut pressures) = (prepared.batch(), pressures.readwrite());
            let room = Room::Single(pressures.as_slice_mut()?);
            let outcome = compute(py, progress.as_ref(), small, |watch| batch.simulate(watch, room))?;
            prepared.conclude(outcome)?;
        }
        return Ok(pressures.into_any());
    }
    let pressures: Bound<'py, PyArray<f64, Ix2>> = empty(py, (chambers, rows))?;
    let derivatives: Option<Bound<'py, PyArray<f64, Ix3>>> =
        if sensitivities { Some(empty(py, (chambers, rows, count))?) } else { None };
    {
        let (batch, mut pressures) = (prepared.batch(), pressures.readwrite());
        let mut derivatives = derivatives.as_ref().map(PyArrayMethods::readwrite);
        let derivatives = match &mut derivatives {
            Some(derivatives) => Some(derivatives.as_slice_mut()?),
            None => None,
        };
        let room = Room::Double { pressures: pressures.as_slice_mut()?, derivatives };
        let outcome = compute(py, progress.as_ref(), small, |watch| batch.simulate(watch, room))?;
        prepared.conclude(outcome)?;
    }
    match derivatives {
        None => Ok(pressures.into_any()),
        Some(derivatives) => Ok((pressures, derivatives).into_pyobject(py)?.into_any()),
    }
}

/// `numpy.empty`: for large arrays NumPy asks the system for huge pages, which cost few page
/// faults, and nobody writes zeros first.
fn empty<'py, T: Element, D: Dimension>(
    py: Python<'py>,
    shape: impl IntoPyObject<'py>,
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    let array = py.import("numpy")?.call_method1("empty", (shape, dtype::<T>(py)))?;
    Ok(array.cast_into()?)
}
