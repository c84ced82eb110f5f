//! A batch that was checked, and what of it threads work on.

use super::super::shapes::{Extent, Field, FieldView};
use super::inputs::{Start, Valve};
use super::plant::Simulator;
use super::table::ParameterTable;
use super::{PA_PER_KPA, SMALL};
use crate::errors;
use pneudrive_model::model::column;
use pneudrive_model::rollout::{BatchColumn, BatchError, BatchInputs, Job};
use pyo3::prelude::*;
use std::ops::Range;

/// Everything a batch needs.
pub struct Prepared<'py> {
    pub simulator: Simulator,
    pub parameters: ParameterTable,
    pub interval_s: f64,
    pub valve: Valve<Field<'py>>,
    pub command_kpa: Field<'py>,
    pub supply_kpa: Field<'py>,
    pub volume_m3: Field<'py>,
    pub supply_mean_kpa: Field<'py>,
    pub inverse_volume_per_m3: Field<'py>,
    pub volume_rate_m3_s: Field<'py>,
    pub start_kpa: Start,
    pub ambient_pa: f64,
    pub chambers: Extent,
    pub rows: Extent,
    pub controller: bool,
}

impl Prepared<'_> {
    /// Refuses what cannot be meant before memory for it is asked for: `per_row` numbers a chamber
    /// and row.
    pub fn check_size(&self, per_row: usize) -> PyResult<()> {
        const MOST: usize = 1 << 32;
        let (chambers, rows) = (self.chambers.number(), self.rows.number());
        let values = chambers.checked_mul(rows).and_then(|all| all.checked_mul(per_row));
        match values {
            Some(values) if values <= MOST => Ok(()),
            _ => Err(errors::unusable(format!(
                "{chambers} chambers by {rows} rows make too large a result; simulate in parts"
            ))),
        }
    }

    /// Whether it is done before a thread of its own would have begun.
    pub fn is_small(&self) -> bool {
        let steps = self.simulator.steps(self.interval_s);
        !self.controller && self.chambers.number() * self.rows.number() * steps <= SMALL
    }

    /// What was found, or which input was not possible: the large ones are looked at while they are
    /// simulated.
    pub fn conclude<T>(&self, outcome: Result<T, BatchError>) -> PyResult<T> {
        if matches!(outcome, Err(BatchError::Range { .. })) {
            self.valve.each().into_iter().chain([&self.command_kpa]).try_for_each(Field::check)?;
        }
        outcome.map_err(errors::unusable)
    }

    /// The same for other threads.
    pub fn batch(&self) -> Batch<'_> {
        Batch {
            simulator: &self.simulator,
            parameters: &self.parameters,
            interval_s: self.interval_s,
            valve: self.valve.map(Field::view),
            command_kpa: self.command_kpa.view(),
            supply_mean_kpa: self.supply_mean_kpa.view(),
            inverse_volume_per_m3: self.inverse_volume_per_m3.view(),
            volume_rate_m3_s: self.volume_rate_m3_s.view(),
            start_kpa: &self.start_kpa,
            ambient_pa: self.ambient_pa,
            chambers: self.chambers.number(),
            rows: self.rows.number(),
        }
    }
}

/// A [`Prepared`] without anything of Python's.
pub struct Batch<'a> {
    pub simulator: &'a Simulator,
    parameters: &'a ParameterTable,
    pub interval_s: f64,
    valve: Valve<FieldView<'a>>,
    command_kpa: FieldView<'a>,
    supply_mean_kpa: FieldView<'a>,
    pub inverse_volume_per_m3: FieldView<'a>,
    volume_rate_m3_s: FieldView<'a>,
    start_kpa: &'a Start,
    pub ambient_pa: f64,
    pub chambers: usize,
    pub rows: usize,
}

impl Batch<'_> {
    /// The inputs of some chambers, laid out as in `model::column`.
    pub fn inputs(&self, chambers: &Range<usize>) -> Result<BatchInputs<'_>, BatchError> {
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
        let (command_kpa, supply_kpa) =
            (self.command_kpa.column(chambers), self.supply_mean_kpa.column(chambers));
        columns[column::COMMAND_PA] = command_kpa.scaled(PA_PER_KPA, self.ambient_pa);
        columns[column::SUPPLY_PA] = supply_kpa.scaled(PA_PER_KPA, self.ambient_pa);
        columns[column::INVERSE_VOLUME_PER_M3] = self.inverse_volume_per_m3.column(chambers);
        columns[column::VOLUME_RATE_M3_S] = self.volume_rate_m3_s.column(chambers);
        BatchInputs::new(columns, chambers.len(), self.rows)
    }

    pub fn jobs(&self, chambers: Range<usize>) -> Vec<Job<'_>> {
        let start = |chamber| self.ambient_pa + PA_PER_KPA * self.start_kpa.of(chamber);
        chambers
            .map(|chamber| Job { parameters: self.parameters.of(chamber), start: start(chamber) })
            .collect()
    }

    /// How long a chamber takes, in steps of a Runge-Kutta scheme.
    pub fn steps(&self) -> usize {
        self.rows * self.simulator.steps(self.interval_s)
    }

    /// The chambers in parts of about `part`, a multiple of `lanes`.
    pub fn parts(&self, part: usize, lanes: usize) -> impl Iterator<Item = Range<usize>> {
        let (part, chambers) = (part.max(1).next_multiple_of(lanes), self.chambers);
        (0..chambers).step_by(part).map(move |from| from..(from + part).min(chambers))
    }
}
