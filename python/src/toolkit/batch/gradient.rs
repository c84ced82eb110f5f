use super::super::arguments::RigArgument;
use super::super::expected::Expected;
use super::super::shapes::{self, Field};
use super::super::work::Watch;
use super::given::Given;
use super::inputs::Valve;
use super::plant::{ModelArgument, Simulator};
use super::prepared::{Batch, Prepared};
use super::sums::Sums;
use super::{PA_PER_KPA, compute};
use crate::types::{Array, ArrayLike, Dict, NamedArrays};
use numpy::ndarray::IxDyn;
use pneudrive_model::model::column;
use pneudrive_model::rollout::{BatchError, BatchGradient, DIFFERENTIATED, SENSITIVITY_LANES};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Chamber-rows that are differentiated at a time: each takes some 300 bytes.
const PART: usize = 200_000;

/// Fewest chambers at a time: several lots for every thread.
const FEWEST: usize = 16 * SENSITIVITY_LANES;

const WEIGHT_RANGE: [f64; 2] = [-f64::MAX, f64::MAX];

/// Derivatives by the arguments, each in the shape that it was given in.
struct Slopes {
    parameters: Sums,
    start_kpa: Sums,
    valve: Valve<Sums>,
    command_kpa: Sums,
    supply_kpa: Sums,
    volume_m3: Sums,
}

impl Slopes {
    fn new(prepared: &Prepared<'_>) -> Self {
        let of = |field: &Field<'_>| Sums::of_rows(field.shape());
        Self {
            parameters: Sums::of_rows(prepared.parameters.shape()),
            start_kpa: Sums::of_chambers(&prepared.start_kpa.shape),
            valve: prepared.valve.map(of),
            command_kpa: of(&prepared.command_kpa),
            supply_kpa: of(&prepared.supply_kpa),
            volume_m3: of(&prepared.volume_m3),
        }
    }

    /// Adds what the chambers from `first` on contribute by their parameters and starts, of
    /// pressures in Pa.
    fn add(&mut self, first: usize, parameters: &[f64], start: &[f64]) {
        let width = parameters.len() / start.len();
        for (job, slope) in start.iter().enumerate() {
            self.start_kpa.add(first + job, 0, *slope);
            for (i, slope) in parameters[job * width..][..width].iter().enumerate() {
                self.parameters.add(first + job, i, 1.0 / PA_PER_KPA * slope);
            }
        }
    }

    /// Adds what they contribute by their inputs. `found` is of pressures in Pa, and by inputs as
    /// the models take them.
    fn add_inputs(&mut self, batch: &Batch<'_>, first: usize, found: &BatchGradient) {
        let (rows, chambers) = (batch.rows, found.start.len());
        let kpa = 1.0 / PA_PER_KPA;
        for job in 0..chambers {
            let chamber = first + job;
            for row in 0..rows {
                let of = |column: usize| {
                    let slot = DIFFERENTIATED.iter().position(|known| *known == column);
                    slot.map_or(0.0, |slot| found.inputs[slot][job * rows + row])
                };
                match &mut self.valve {
                    Valve::Spool(drive) => {
                        drive.add(chamber, row, kpa * (of(column::FILL) - of(column::VENT)));
                    }
                    Valve::Separate { fill, vent } => {
                        fill.add(chamber, row, kpa * of(column::FILL));
                        vent.add(chamber, row, kpa * of(column::VENT));
                    }
                    Valve::None => {}
                }
                self.command_kpa.add(chamber, row, of(column::COMMAND_PA));
                // What holds over an interval is the mean of its two rows, and of the volume also
                // their difference.
                let next = (row + 1).min(rows - 1);
                let supply = 0.5 * of(column::SUPPLY_PA);
                self.supply_kpa.add(chamber, row, supply);
                self.supply_kpa.add(chamber, next, supply);
                let inverse = batch.inverse_volume_per_m3.of(chamber, row);
                let by_mean = -0.5 * inverse * inverse * of(column::INVERSE_VOLUME_PER_M3);
                let by_rate = of(column::VOLUME_RATE_M3_S) / batch.interval_s;
                self.volume_m3.add(chamber, row, kpa * (by_mean - by_rate));
                self.volume_m3.add(chamber, next, kpa * (by_mean + by_rate));
            }
        }
    }
}

impl Batch<'_> {
    fn differentiate(
        &self,
        watch: &Watch,
        weight: &(dyn Fn(usize, usize) -> f64 + Sync),
        slopes: &mut Slopes,
    ) -> Result<(), BatchError> {
        watch.begin("differentiating");
        for chambers in self.parts((PART / self.rows).max(FEWEST), SENSITIVITY_LANES) {
            watch.tell(chambers.start as u64, self.chambers as u64);
            watch.checkpoint();
            let inputs = self.inputs(&chambers)?;
            let weights: Vec<f64> = chambers
                .clone()
                .flat_map(|chamber| (0..self.rows).map(move |row| weight(chamber, row)))
                .collect();
            let first = chambers.start;
            let jobs = self.jobs(chambers);
            let found = match self.simulator {
                Simulator::Lanes { subject, substeps } => {
                    subject.batch_gradient(&jobs, &inputs, *substeps, &weights)?
                }
                Simulator::Effects(rollouts) => rollouts.gradient(&jobs, &inputs, &weights)?,
            };
            slopes.add_inputs(self, first, &found);
            slopes.add(first, &found.parameters, &found.start);
        }
        Ok(())
    }
}

/// Differentiates a weighted sum of simulated pressures by everything that they follow from.
///
/// With ``pressure_kpa = simulate_batch(...)`` of the same arguments, these are the derivatives of
/// ``(weights * pressure_kpa).sum()``. With the derivatives of a loss by the pressures as weights
/// they are those of the loss: one call, whatever the number of inputs. They are exact for the
/// discretised model (reverse accumulation), not differences.
///
/// Parameters
/// ----------
/// model : {"nonlinear", "parametric", "linear"}, Parameters or ExtendedModel
/// parameters : array_like of float, shape (parameters,) or (chambers, parameters), dict, None
///     As of ``simulate_batch``, like all that is not described here.
/// interval_s : float
/// weights : array_like of float, shape (), (rows,) or (chambers, rows)
///     Finite.
/// drive, fill, vent, command_kpa, supply_kpa, volume_m3, start_kpa : array_like of float, optional
/// rig : Rig or path, optional
/// controller : bool, optional
///     The converter's rounding of readings passes derivatives through; where the loop's drive is
///     clipped they are 0.
/// substeps : int, optional
/// channel : str, optional
/// progress : callable, optional
///     Called with (chambers done, chambers in all, what is being done).
///
/// Returns
/// -------
/// dict of str to numpy.ndarray of float64
///     ``"parameters"``, ``"start_kpa"``, ``"supply_kpa"``, ``"volume_m3"``, and of ``"drive"``,
///     ``"fill"``, ``"vent"`` and ``"command_kpa"`` those that were given: by each of its values,
///     in the shape it was given in. What was given once for several chambers or rows has the sum
///     over them. What was taken from the rig, or left at 0, has shape (). Of a dict of parameters:
///     shape (parameters,), or (chambers, parameters) where any has a value per chamber. In units
///     of the weights by kPa, per unit of the argument.
///
/// Raises
/// ------
/// DataError
///     As ``simulate_batch``; weights that are not finite; a model with a smooth correction.
///
/// Notes
/// -----
/// Ports that close and flows that begin to choke have kinks; there the derivative is one of the
/// two. An ``ExtendedModel`` is differentiated forwards by its parameters, eight at a time, and
/// backwards by its inputs. Where its board's loop hunts, around play or friction, the derivatives
/// grow without bound.
#[pyfunction]
#[pyo3(signature = (model, parameters, interval_s, weights, *, drive=None, fill=None, vent=None, command_kpa=None, supply_kpa=None, volume_m3=None, start_kpa=None, rig=None, controller=None, substeps=None, channel=None, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn batch_gradient<'py>(
    py: Python<'py>,
    model: Expected<ModelArgument>,
    parameters: Option<NamedArrays<'py>>,
    interval_s: f64,
    weights: ArrayLike<'py>,
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
    channel: Option<&str>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Dict<'py, Array<'py, f64, IxDyn>>> {
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
    let mut prepared = given.prepare()?;
    let weights = Field::extract("weights", &weights.0, WEIGHT_RANGE, "")?.checked()?;
    shapes::joint(&mut prepared.chambers, &mut prepared.rows, &[&weights])?;
    prepared.check_size(1)?;
    let mut slopes = Slopes::new(&prepared);
    {
        let (batch, weights) = (prepared.batch(), weights.view());
        let weight = |chamber, row| weights.of(chamber, row);
        let small = prepared.is_small();
        let outcome =
            compute(py, progress.as_ref(), small, |watch| batch.differentiate(watch, &weight, &mut slopes))?;
        prepared.conclude(outcome)?;
    }
    let dict = PyDict::new(py);
    dict.set_item("parameters", slopes.parameters.into_array(py)?)?;
    dict.set_item("start_kpa", slopes.start_kpa.into_array(py)?)?;
    match slopes.valve {
        Valve::Spool(drive) => dict.set_item("drive", drive.into_array(py)?)?,
        Valve::Separate { fill, vent } => {
            dict.set_item("fill", fill.into_array(py)?)?;
            dict.set_item("vent", vent.into_array(py)?)?;
        }
        Valve::None => dict.set_item("command_kpa", slopes.command_kpa.into_array(py)?)?,
    }
    dict.set_item("supply_kpa", slopes.supply_kpa.into_array(py)?)?;
    dict.set_item("volume_m3", slopes.volume_m3.into_array(py)?)?;
    Ok(Dict::new(dict))
}
