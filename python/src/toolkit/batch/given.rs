//! From the arguments of a call to a batch.

use super::super::arguments::RigArgument;
use super::super::expected::Expected;
use super::super::shapes::{self, Extent};
use super::PA_PER_KPA;
use super::inputs::{self, Start};
use super::plant::{ModelArgument, Plant, Wanted};
use super::prepared::Prepared;
use super::table::ParameterTable;
use crate::errors;
use crate::types::{ArrayLike, NamedArrays};
use pneudrive_model::experiment::{DriveKind, ModelKind, Setup};
use pyo3::prelude::*;

/// What all functions of batches are given.
pub struct Given<'a, 'py> {
    pub model: ModelArgument,
    pub channel: Option<&'a str>,
    pub parameters: Option<NamedArrays<'py>>,
    pub interval_s: f64,
    pub drive: Option<ArrayLike<'py>>,
    pub fill: Option<ArrayLike<'py>>,
    pub vent: Option<ArrayLike<'py>>,
    pub command_kpa: Option<ArrayLike<'py>>,
    pub supply_kpa: Option<ArrayLike<'py>>,
    pub volume_m3: Option<ArrayLike<'py>>,
    pub start_kpa: Option<ArrayLike<'py>>,
    pub rig: Option<Expected<RigArgument>>,
    pub controller: Option<bool>,
    pub substeps: Option<i64>,
}

impl<'py> Given<'_, 'py> {
    /// Checks everything that costs little to check.
    pub fn prepare(self) -> PyResult<Prepared<'py>> {
        let interval_s = self.interval_s;
        if !(1e-6..=10.0).contains(&interval_s) {
            return Err(errors::unusable(format!("interval_s is {interval_s}; it must be 1e-6 to 10 s")));
        }
        let wanted = Wanted {
            channel: self.channel,
            rig: self.rig,
            controller: self.controller,
            substeps: self.substeps,
            separate: self.fill.is_some() || self.vent.is_some(),
        };
        let plant = Plant::new(self.model, wanted)?;
        let Plant { driven_by, regulator, .. } = plant;
        let rig = &plant.rig;
        let valve = inputs::valve(self.drive.as_ref(), self.fill.as_ref(), self.vent.as_ref(), driven_by)?;
        let names: Vec<String> = plant.parameters().into_iter().map(|p| p.name).collect();
        let given = self.parameters.as_ref().map(|parameters| &parameters.0);
        let parameters = ParameterTable::extract(given, &names, plant.calibrated.as_deref())?;
        let command_kpa = inputs::command(self.command_kpa.as_ref(), driven_by)?;
        let supply_kpa = inputs::supply(self.supply_kpa.as_ref(), rig, regulator)?;
        let volume_m3 = inputs::volume(self.volume_m3.as_ref(), rig, regulator)?;
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
            ambient_pa: rig.ambient_or_standard().pressure_kpa_abs * PA_PER_KPA,
            controller: plant.controller,
            simulator: plant.simulator,
            parameters,
            valve,
            command_kpa,
            supply_kpa,
            volume_m3,
            start_kpa,
            chambers,
            rows,
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
