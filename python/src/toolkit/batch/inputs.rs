//! The inputs of a batch, each within what can be meant.

use super::super::shapes::{self, Field};
use super::plant::DrivenBy;
use crate::arrays::shape_text;
use crate::errors;
use crate::types::ArrayLike;
use pneudrive_model::rig::Rig;
use pyo3::prelude::*;

/// Pressures that can be meant, kPa gauge.
const PRESSURE_KPA: [f64; 2] = [-101.0, 10_000.0];

/// Chamber volumes that can be meant, m^3: a cubic millimetre to ten cubic metres.
const VOLUME_M3: [f64; 2] = [1e-9, 10.0];

/// What opens the valves.
pub enum Valve<F> {
    Spool(F),
    Separate {
        fill: F,
        vent: F,
    },
    /// The linear model and the boards' loops have no use for it.
    None,
}

impl<F> Valve<F> {
    pub fn each(&self) -> Vec<&F> {
        match self {
            Self::Spool(drive) => vec![drive],
            Self::Separate { fill, vent } => vec![fill, vent],
            Self::None => vec![],
        }
    }

    pub fn map<'a, G>(&'a self, of: impl Fn(&'a F) -> G) -> Valve<G> {
        match self {
            Self::Spool(drive) => Valve::Spool(of(drive)),
            Self::Separate { fill, vent } => Valve::Separate { fill: of(fill), vent: of(vent) },
            Self::None => Valve::None,
        }
    }
}

/// What opens the valves, of what was given.
pub fn valve<'py>(
    drive: Option<&ArrayLike<'py>>,
    fill: Option<&ArrayLike<'py>>,
    vent: Option<&ArrayLike<'py>>,
    driven_by: DrivenBy,
) -> PyResult<Valve<Field<'py>>> {
    let half = [0.0, 1.0];
    match (drive, fill, vent, driven_by) {
        (None, None, None, DrivenBy::Command) => Ok(Valve::None),
        (None, None, None, _) => Err(errors::unusable("neither drive nor fill and vent are given")),
        (.., DrivenBy::Command) => Err(errors::unusable(
            "drive, fill and vent are not used by the linear model or with controller=True",
        )),
        (Some(drive), None, None, DrivenBy::Spool) => {
            Ok(Valve::Spool(Field::extract("drive", &drive.0, [-1.0, 1.0], "")?))
        }
        (None, Some(fill), Some(vent), DrivenBy::Separate) => Ok(Valve::Separate {
            fill: Field::extract("fill", &fill.0, half, "")?,
            vent: Field::extract("vent", &vent.0, half, "")?,
        }),
        (Some(_), None, None, DrivenBy::Separate) => {
            Err(errors::unusable("the channel has two valves: give fill and vent"))
        }
        (None, Some(_), Some(_), DrivenBy::Spool) => {
            Err(errors::unusable("the channel has one spool: give drive"))
        }
        _ => Err(errors::unusable("give drive, or both fill and vent")),
    }
}

pub fn command<'py>(given: Option<&ArrayLike<'py>>, driven_by: DrivenBy) -> PyResult<Field<'py>> {
    match (given, driven_by == DrivenBy::Command) {
        (Some(command), true) => Field::extract("command_kpa", &command.0, PRESSURE_KPA, "kPa"),
        (None, false) => Ok(Field::constant("command_kpa", 0.0)),
        (Some(_), false) => {
            Err(errors::unusable("command_kpa is for the linear model or with controller=True"))
        }
        (None, true) => Err(errors::unusable("command_kpa is missing: nothing says what to follow")),
    }
}

pub fn supply<'py>(given: Option<&ArrayLike<'py>>, rig: &Rig, regulator: bool) -> PyResult<Field<'py>> {
    match (given, &rig.supply) {
        (Some(given), _) => Field::extract("supply_kpa", &given.0, PRESSURE_KPA, "kPa")?.checked(),
        (None, Some(supply)) => Ok(Field::constant("supply_kpa", supply.pressure_kpa)),
        (None, None) if regulator => Ok(Field::constant("supply_kpa", 0.0)),
        (None, None) => Err(errors::unusable("supply_kpa is missing: give it, or a rig with [supply]")),
    }
}

pub fn volume<'py>(given: Option<&ArrayLike<'py>>, rig: &Rig, regulator: bool) -> PyResult<Field<'py>> {
    match (given, &rig.chamber) {
        (Some(given), _) => Field::extract("volume_m3", &given.0, VOLUME_M3, "m^3")?.checked(),
        (None, Some(chamber)) => Ok(Field::constant("volume_m3", chamber.rest_volume_m3())),
        (None, None) if regulator => Ok(Field::constant("volume_m3", 1.0)),
        (None, None) => Err(errors::unusable("volume_m3 is missing: give it, or a rig with [chamber]")),
    }
}

/// Pressures at the first row, kPa gauge, in the shape that they were given in.
pub struct Start {
    pub shape: Vec<usize>,
    kpa: Vec<f64>,
}

impl Start {
    pub fn extract(given: Option<&ArrayLike<'_>>) -> PyResult<Self> {
        let Some(given) = given else { return Ok(Self { shape: vec![], kpa: vec![0.0] }) };
        let (shape, values) = shapes::numbers("start_kpa", &given.0)?;
        if shape.len() > 1 {
            return Err(errors::unusable(format!(
                "start_kpa has shape {}; expected () or (chambers,)",
                shape_text(&shape)
            )));
        }
        let [low, high] = PRESSURE_KPA;
        match values.iter().position(|kpa| !(*kpa >= low && *kpa <= high)) {
            None => Ok(Self { shape, kpa: values.to_vec() }),
            Some(at) => Err(errors::unusable(format!(
                "start_kpa of chamber {at} is {}; it must be {low} to {high} kPa",
                values[at]
            ))),
        }
    }

    pub fn chambers(&self) -> usize {
        self.kpa.len()
    }

    pub fn of(&self, chamber: usize) -> f64 {
        self.kpa[if self.kpa.len() == 1 { 0 } else { chamber }]
    }
}
