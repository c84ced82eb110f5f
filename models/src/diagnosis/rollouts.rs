//! Many simulations of one channel of an extended model: from inputs in memory, as a recording's
//! are simulated.
//!
//! One rollout at a time, on all threads: what effects remember (friction, dead times) goes
//! different ways in each, so that there are no lanes.

use super::channel::{ChannelData, Extended, NARROW, Variable};
use super::error::DiagnosisError;
use super::report::ExtendedFile;
use crate::data::ChannelId;
use crate::effects::{ChannelInputs, Disturbance, DriveInput, InputSlopes, Series, input_slopes, install};
use crate::model::{Parameter, column};
use crate::numeric::{Dual, Scalar};
use crate::parallel;
use crate::rollout::{
    BatchError, BatchGradient, BatchInputs, BatchResults, DIFFERENTIATED, Job, check_batch,
};

const PA_PER_KPA: f64 = 1e3;

/// A number with derivatives.
type Slopes = Dual<f64, NARROW>;

/// One channel of an extended model. What other channels do to it is left out.
#[derive(Debug, Clone)]
pub struct ExtendedRollouts {
    data: ChannelData,
    model: Extended,
}

impl ExtendedRollouts {
    /// Sets up a channel; it is driven by set points or by its valve's drive as `set_point` says,
    /// or else as it was calibrated. `name` is the file's, for messages.
    ///
    /// # Errors
    /// [`DiagnosisError`] when the file or its rig lacks something, or has a correction that
    /// follows other channels.
    pub fn new(
        name: &str,
        file: &ExtendedFile,
        id: ChannelId,
        set_point: Option<bool>,
    ) -> Result<Self, DiagnosisError> {
        let mut data = file.template(name, id, set_point)?;
        let model = file.models(name, std::slice::from_ref(&data))?.remove(0);
        let variable = model.correction.as_ref().map(|correction| correction.variable);
        if let Some(by @ (Variable::OthersDraw | Variable::Opposite | Variable::NeighbourDrive)) = variable {
            let problem =
                format!("{id}: its correction follows {}, which nothing simulates here", by.words());
            return Err(DiagnosisError::Reference { file: name.to_owned(), problem });
        }
        data.blocks.clear();
        data.spans.clear();
        Ok(Self { data, model })
    }

    /// What drives it: `spool`, `separate` (fill and vent), `board` (the board's loop, from
    /// commands) or `command` (a regulator).
    #[must_use]
    pub fn driven_by(&self) -> &'static str {
        self.data.driven_by()
    }

    /// The parameters of base model and effects, the latter's as in `valve_lag.time_constant`, in
    /// the order of a job's.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        self.model.parameters(&self.data.plant)
    }

    /// Their calibrated values.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.model.values
    }

    /// Ambient pressure, Pa.
    #[must_use]
    pub fn ambient_pa(&self) -> f64 {
        self.data.inputs.ambient_pa
    }

    /// Steps of the gas in an interval of this length, s.
    #[must_use]
    pub fn steps(&self, interval_s: f64) -> usize {
        let plant = &self.data.plant;
        match plant.board.as_ref().filter(|_| self.data.inputs.in_loop()) {
            Some(board) => board.steps(interval_s) * plant.steps(interval_s / board.steps(interval_s) as f64),
            None => plant.steps(interval_s),
        }
    }

    /// Simulates all jobs: what the sensor is expected to report, row by row. Drives, set points,
    /// supply, volume and its rate are taken from the inputs.
    ///
    /// # Errors
    /// As [`simulate_batch_into`](crate::rollout::simulate_batch_into), and
    /// [`BatchError::Correction`].
    pub fn simulate(
        &self,
        jobs: &[Job<'_>],
        inputs: &BatchInputs<'_>,
        results: BatchResults<'_>,
    ) -> Result<(), BatchError> {
        let BatchResults { outputs, sensitivities, unit } = results;
        let width = self.model.values.len();
        check_batch(width, jobs, inputs, outputs.len())?;
        inputs.check_late()?;
        if outputs.is_empty() {
            return Ok(());
        }
        let (rows, ambient_pa) = (inputs.rows(), self.ambient_pa());
        let expected = outputs.len() * width;
        let shared = Shared::new(inputs);
        let each = jobs.iter().enumerate().zip(outputs.chunks_mut(rows));
        let absolute = |gauge_kpa: f64| unit.of(ambient_pa + PA_PER_KPA * gauge_kpa);
        let Some(derivatives) = sensitivities else {
            parallel::map(each, |((number, job), outputs)| {
                let (data, model) = self.rollout(&shared, number, job);
                for (output, [gauge_kpa, ..]) in outputs.iter_mut().zip(data.trace(&model)) {
                    *output = absolute(gauge_kpa);
                }
            });
            return Ok(());
        };
        if expected != derivatives.len() {
            return Err(BatchError::Results { expected, found: derivatives.len() });
        }
        self.check_differentiable()?;
        let each = each.zip(derivatives.chunks_mut(rows * width));
        parallel::map(each, |(((number, job), outputs), slopes)| {
            let (data, model) = self.rollout(&shared, number, job);
            differentiate(&data, &model, width, &mut |row, first, reading| {
                outputs[row] = absolute(reading.value);
                let directions = first..width.min(first + NARROW);
                let into = &mut slopes[row * width..][directions];
                for (slope, of_kpa) in into.iter_mut().zip(reading.gradient) {
                    *slope = PA_PER_KPA * of_kpa * unit.per_pa;
                }
            });
        });
        Ok(())
    }

    /// Derivatives of a weighted sum of the pressures, exact for the discretised model. By
    /// parameters and start: a simulation with derivatives for every eight of them. By the inputs:
    /// reverse accumulation, whatever their number. `weights` has an entry `[rollout][row]`.
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate); [`BatchError::Correction`].
    pub fn gradient(
        &self,
        jobs: &[Job<'_>],
        inputs: &BatchInputs<'_>,
        weights: &[f64],
    ) -> Result<BatchGradient, BatchError> {
        let width = self.model.values.len();
        check_batch(width, jobs, inputs, weights.len())?;
        inputs.check_late()?;
        self.check_differentiable()?;
        let mut found = BatchGradient {
            parameters: vec![0.0; jobs.len() * width],
            start: vec![0.0; jobs.len()],
            inputs: std::array::from_fn(|_| vec![0.0; weights.len()]),
        };
        if weights.is_empty() {
            return Ok(found);
        }
        let shared = Shared::new(inputs);
        let rows = inputs.rows();
        let weights = weights.chunks(rows);
        let into = found.parameters.chunks_mut(width).zip(&mut found.start);
        let by_inputs: Vec<[Vec<f64>; DIFFERENTIATED.len()]> = parallel::map(
            jobs.iter().enumerate().zip(weights).zip(into),
            |(((number, job), weights), (parameters, start))| {
                let (data, model) = self.rollout(&shared, number, job);
                differentiate(&data, &model, width + 1, &mut |row, first, reading| {
                    for (direction, of_kpa) in (first..=width).zip(reading.gradient) {
                        let slope = PA_PER_KPA * weights[row] * of_kpa;
                        *parameters.get_mut(direction).unwrap_or(&mut *start) += slope;
                    }
                });
                by_inputs(&data, &model, weights)
            },
        );
        for (number, columns) in by_inputs.into_iter().enumerate() {
            for (all, column) in found.inputs.iter_mut().zip(columns) {
                all[number * rows..][..rows].copy_from_slice(&column);
            }
        }
        Ok(found)
    }

    fn check_differentiable(&self) -> Result<(), BatchError> {
        if self.model.correction.is_some() { Err(BatchError::Correction) } else { Ok(()) }
    }

    /// A rollout's channel and model.
    fn rollout(&self, shared: &Shared<'_>, number: usize, job: &Job<'_>) -> (ChannelData, Extended) {
        let of = |column: usize| shared.series(column, number);
        let drive = match &self.data.inputs.drive {
            DriveInput::Spool(_) => DriveInput::Spool(of(column::FILL)),
            DriveInput::Separate { .. } => {
                DriveInput::Separate { fill: of(column::FILL), vent: of(column::VENT) }
            }
            other => other.clone(),
        };
        let inputs = ChannelInputs {
            time_s: shared.time_s.clone(),
            interval_s: of(column::INTERVAL_S),
            duration_s: shared.time_s.last().copied().unwrap_or_default(),
            starts: [0].into(),
            anchors: [].into(),
            drive,
            command_pa: of(column::COMMAND_PA),
            supply_pa: of(column::SUPPLY_PA),
            volume_m3: of(column::INVERSE_VOLUME_PER_M3),
            volume_rate_m3_s: of(column::VOLUME_RATE_M3_S),
            // Only the first is used; no two neighbours are equal, or they would look like repeated
            // samples.
            measured_pa: (0..shared.time_s.len()).map(|row| job.start + (row % 2) as f64).collect(),
            usable: shared.usable.clone(),
            opposite_pa: Series::default(),
            sampled_before_pa: Series::default(),
            neighbour_drive: Series::default(),
            others_draw: shared.zeros.clone(),
            ..self.data.inputs.clone()
        };
        let data = ChannelData { inputs, rows: shared.rows.clone(), ..self.data.clone() };
        (data, Extended { values: job.parameters.to_vec(), ..self.model.clone() })
    }
}

/// What rollouts have in common, held once.
struct Shared<'a> {
    inputs: &'a BatchInputs<'a>,
    time_s: Series,
    zeros: Series,
    usable: std::sync::Arc<[bool]>,
    rows: std::sync::Arc<[u32]>,
    /// Columns that are the same for all.
    columns: Vec<Option<Series>>,
}

impl<'a> Shared<'a> {
    fn new(inputs: &'a BatchInputs<'a>) -> Self {
        let rows = inputs.rows();
        let interval_s = inputs.value(0, 0, column::INTERVAL_S);
        let shared = |column: usize| inputs.is_shared(column).then(|| series(inputs, column, 0));
        Self {
            time_s: (0..rows).map(|row| row as f64 * interval_s).collect(),
            zeros: vec![0.0; rows].into(),
            usable: vec![true; rows].into(),
            rows: (0..).take(rows).collect(),
            columns: (0..column::COUNT).map(shared).collect(),
            inputs,
        }
    }

    fn series(&self, column: usize, number: usize) -> Series {
        self.columns[column].clone().unwrap_or_else(|| series(self.inputs, column, number))
    }
}

/// A column of one rollout; of the volume, which the rows have one by, itself.
fn series(inputs: &BatchInputs<'_>, column: usize, number: usize) -> Series {
    let value = |row: usize| inputs.value(number, row, column);
    match column {
        column::INVERSE_VOLUME_PER_M3 => (0..inputs.rows()).map(|row| value(row).recip()).collect(),
        _ => (0..inputs.rows()).map(value).collect(),
    }
}

/// The pressure at the first row is a variable.
struct Start(Slopes);

impl Disturbance<Slopes> for Start {
    #[inline]
    fn pressure(&self, row: usize, pressure: Slopes) -> Slopes {
        if row == 0 { pressure + self.0 } else { pressure }
    }
}

/// Readings (kPa) with their derivatives in all directions (the parameters, then the start in kPa
/// per Pa), some at a time: `each` gets the row, the number of the first direction and the reading.
fn differentiate(
    data: &ChannelData,
    model: &Extended,
    directions: usize,
    each: &mut dyn FnMut(usize, usize, &Slopes),
) {
    let count = model.values.len();
    for first in (0..directions).step_by(NARROW) {
        let variable = |(i, value): (usize, &f64)| Slopes::variable(*value, i.wrapping_sub(first));
        let values: Vec<Slopes> = model.values.iter().enumerate().map(variable).collect();
        let start = Start(Slopes::variable(0.0, count.wrapping_sub(first)));
        for (row, reading) in data.run(model, &values, &start).iter().enumerate() {
            each(row, first, reading);
        }
    }
}

/// Derivatives by the columns of [`DIFFERENTIATED`], of a weighted sum of readings in Pa.
fn by_inputs(data: &ChannelData, model: &Extended, weights: &[f64]) -> [Vec<f64>; DIFFERENTIATED.len()] {
    let values: Vec<Slopes> = model.values.iter().map(|value| Slopes::constant(*value)).collect();
    let effects = install(&data.plant, &model.effects, &values);
    let InputSlopes { fill, vent, command, supply, mut volume, volume_rate } =
        input_slopes(&data.plant, &values, &effects, &data.inputs, weights);
    // Rows have one by the volume.
    for (slope, volume_m3) in volume.iter_mut().zip(data.inputs.volume_m3.iter()) {
        *slope *= -volume_m3 * volume_m3;
    }
    [fill, vent, command, supply, volume, volume_rate]
}
