//! What a step is given: a number for every channel.

use super::super::shapes;
use super::channels::{About, Follows};
use crate::arrays::shape_text;
use crate::errors;
use crate::types::ArrayLike;
use pneudrive_capi::Inputs;
use pyo3::prelude::*;

/// Pressures that can be meant, kPa gauge.
pub const PRESSURE_KPA: [f64; 2] = [-101.0, 10_000.0];

/// Chamber volumes that can be meant, m^3.
const VOLUME_M3: [f64; 2] = [1e-9, 10.0];

/// A value for every channel, of an array of shape () or (channels,).
pub fn one_each(
    name: &str,
    given: Option<&ArrayLike<'_>>,
    number: usize,
    [low, high]: [f64; 2],
) -> PyResult<Option<Vec<f64>>> {
    let Some(given) = given else { return Ok(None) };
    let (shape, values) = shapes::numbers(name, &given.0)?;
    if let Some(k) = values.iter().position(|value| !(*value >= low && *value <= high)) {
        return Err(errors::unusable(format!("{name}[{k}] is {}; it must be {low} to {high}", values[k])));
    }
    match shape[..] {
        [] => Ok(Some(vec![values[0]; number])),
        [found] if found == number => Ok(Some(values.to_vec())),
        _ => Err(errors::unusable(format!(
            "{name} has shape {}; expected () or ({number},)",
            shape_text(&shape)
        ))),
    }
}

/// Rates of volumes that can be meant, m^3/s.
const VOLUME_RATE_M3_S: [f64; 2] = [-1e3, 1e3];

/// The arguments of a step.
pub struct Given<'a, 'py> {
    pub drive: Option<&'a ArrayLike<'py>>,
    pub fill: Option<&'a ArrayLike<'py>>,
    pub vent: Option<&'a ArrayLike<'py>>,
    pub set_point_kpa: Option<&'a ArrayLike<'py>>,
    pub supply_kpa: Option<&'a ArrayLike<'py>>,
    pub volume_m3: Option<&'a ArrayLike<'py>>,
    pub volume_rate_m3_s: Option<&'a ArrayLike<'py>>,
}

impl Given<'_, '_> {
    /// The inputs of every channel, if all are given that it follows, and nothing that nobody does.
    pub fn inputs(&self, about: &[About]) -> PyResult<Vec<Inputs>> {
        let of = |name, given, range| one_each(name, given, about.len(), range);
        let drive = of("drive", self.drive, [-1.0, 1.0])?;
        let fill = of("fill", self.fill, [0.0, 1.0])?;
        let vent = of("vent", self.vent, [0.0, 1.0])?;
        let set_point = of("set_point_kpa", self.set_point_kpa, PRESSURE_KPA)?;
        let supply = of("supply_kpa", self.supply_kpa, PRESSURE_KPA)?;
        let volume = of("volume_m3", self.volume_m3, VOLUME_M3)?;
        let rate = of("volume_rate_m3_s", self.volume_rate_m3_s, VOLUME_RATE_M3_S)?;
        for (name, given, by) in [
            ("drive", &drive, Follows::Spool),
            ("fill", &fill, Follows::Separate),
            ("vent", &vent, Follows::Separate),
            ("set_point_kpa", &set_point, Follows::SetPoint),
        ] {
            match (given, about.iter().find(|one| one.follows == by)) {
                (Some(_), None) => {
                    return Err(errors::unusable(format!("{name} is not used by any of the channels")));
                }
                (None, Some(one)) => {
                    return Err(errors::unusable(format!("{name} is missing: {} follows it", one.name)));
                }
                _ => {}
            }
        }
        let all = about.iter().enumerate().map(|(k, one)| {
            let mut inputs = one.nominal;
            let put = |place: &mut f64, given: &Option<Vec<f64>>| {
                if let Some(values) = given {
                    *place = values[k];
                }
            };
            put(&mut inputs.fill, if one.follows == Follows::Spool { &drive } else { &fill });
            put(&mut inputs.vent, &vent);
            put(&mut inputs.set_point_kpa, &set_point);
            put(&mut inputs.supply_kpa, &supply);
            put(&mut inputs.volume_m3, &volume);
            put(&mut inputs.volume_rate_m3_s, &rate);
            inputs
        });
        Ok(all.collect())
    }
}
