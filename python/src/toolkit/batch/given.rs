//! From the arguments of a call to a batch.

use super::super::arguments::{self, RigArgument};
use super::super::expected::Expected;
use super::super::shapes::{self, Extent};
use super::PA_PER_KPA;
use super::inputs::{self, Start};
use super::prepared::Prepared;
use super::table::ParameterTable;
use crate::errors;
use crate::types::{ArrayLike, NamedArrays};
use pneudrive_model::experiment::{DriveKind, ModelKind, Setup, subject};
use pneudrive_model::model::FlowForm;
use pyo3::prelude::*;

/// What all functions of batches are given.
pub struct Given<'a, 'py> {
    pub model: &'a str,
    pub parameters: NamedArrays<'py>,
    pub interval_s: f64,
    pub drive: Option<ArrayLike<'py>>,
    pub fill: Option<ArrayLike<'py>>,
    pub vent: Option<ArrayLike<'py>>,
    pub command_kpa: Option<ArrayLike<'py>>,
    pub supply_kpa: Option<ArrayLike<'py>>,
    pub volume_m3: Option<ArrayLike<'py>>,
    pub start_kpa: Option<ArrayLike<'py>>,
    pub rig: Option<Expected<RigArgument>>,
    pub controller: bool,
    pub substeps: i64,
}

impl<'py> Given<'_, 'py> {
    /// Checks everything that costs little to check.
    pub fn prepare(self) -> PyResult<Prepared<'py>> {
        let (rig, _) = RigArgument::resolve(self.rig)?;
        let (model, interval_s) = (arguments::model(self.model)?, self.interval_s);
        if !(1e-6..=10.0).contains(&interval_s) {
            return Err(errors::unusable(format!("interval_s is {interval_s}; it must be 1e-6 to 10 s")));
        }
        let substeps = self.substeps;
        if !(1..=1000).contains(&substeps) {
            return Err(errors::unusable(format!("substeps is {substeps}; it must be 1 to 1000")));
        }
        let by_command = model.is_regulator() || self.controller;
        let separate = self.fill.is_some() || self.vent.is_some();
        let valve = inputs::valve(self.drive.as_ref(), self.fill.as_ref(), self.vent.as_ref(), by_command)?;
        let setup = setup(model, self.controller, separate);
        let subject = subject(setup, &rig, FlowForm::Iso6358).map_err(errors::unusable)?;
        let names: Vec<String> = subject.parameters().into_iter().map(|p| p.name).collect();
        let parameters = ParameterTable::extract(&self.parameters.0, &names)?;
        let command_kpa = inputs::command(self.command_kpa.as_ref(), by_command)?;
        let supply_kpa = inputs::supply(self.supply_kpa.as_ref(), &rig, model)?;
        let volume_m3 = inputs::volume(self.volume_m3.as_ref(), &rig, model)?;
        let start_kpa = Start::extract(self.start_kpa.as_ref())?;

        let (mut chambers, mut rows) = (Extent::new("chambers"), Extent::new("rows"));
        chambers.join("parameters", parameters.chambers())?;
        chambers.join("start_kpa", start_kpa.chambers())?;
        let mut fields = valve.each();
        fields.extend([&command_kpa, &supply_kpa, &volume_m3]);
        shapes::joint(&mut chambers, &mut rows, &fields)?;
        Ok(Prepared {
            interval_s,
            supply_mean_kpa: supply_kpa.pairwise(mean),
            inverse_volume_per_m3: volume_m3.pairwise(|here, there| mean(here, there).recip()),
            volume_rate_m3_s: volume_m3.pairwise(|here, there| (there - here) / interval_s),
            subject,
            parameters,
            valve,
            command_kpa,
            supply_kpa,
            volume_m3,
            start_kpa,
            ambient_pa: rig.ambient_or_standard().pressure_kpa_abs * PA_PER_KPA,
            chambers,
            rows,
            substeps: usize::try_from(substeps).unwrap_or(1),
            controller: self.controller,
        })
    }
}

fn mean(here: f64, there: f64) -> f64 {
    0.5 * (here + there)
}

pub fn setup(model: ModelKind, controller: bool, separate: bool) -> Setup {
    let kind = if separate { DriveKind::Separate } else { DriveKind::Spool };
    let linear = model.is_regulator();
    Setup { model, drive: (!linear).then_some(kind), controller: controller && !linear }
}
