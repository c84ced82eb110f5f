//! The rig file that goes with a recording: what its user would know of the rig, and nothing of its
//! effects.

use serde::Serialize;

use crate::plant::{PlantParameters, counts10_to_kpa};

use super::error::RecordError;
use super::settings::{ControlSettings, Loop, RecordingSettings};

#[derive(Serialize)]
struct Rig {
    supply: Supply,
    ambient: Ambient,
    chamber: Chamber,
    valve: Valve,
    controller: Controller,
    sensor: Sensor,
}

#[derive(Serialize)]
struct Supply {
    pressure_kpa: f64,
}

#[derive(Serialize)]
struct Ambient {
    pressure_kpa_abs: f64,
    temperature_k: f64,
}

#[derive(Serialize)]
struct Chamber {
    radius_m: f64,
    length_m: f64,
    offset_m: f64,
}

#[derive(Serialize)]
struct Valve {
    discharge_coefficient: f64,
    critical_ratio: f64,
}

#[derive(Serialize)]
struct Controller {
    rate_hz: f64,
    kp: f64,
    kd: f64,
    saturation: f64,
    filter: f64,
}

#[derive(Serialize)]
struct Sensor {
    bits: u32,
    zero_counts: f64,
    kpa_per_count: f64,
}

/// The nominal rig as TOML. Effects, spread and nuisances are left out: they are what a fit or a
/// diagnosis must find.
///
/// # Errors
/// Only if the TOML writer refuses a number.
pub fn rig_toml(settings: &RecordingSettings) -> Result<String, RecordError> {
    let rate_hz = match settings.control_loop {
        Loop::Board { .. } => settings.control.rate_hz,
        Loop::Row | Loop::Open { .. } => settings.rate_hz,
    };
    Ok(nominal_toml(&settings.plant, &ControlSettings { rate_hz, ..settings.control })?)
}

/// The same of any plant under any control law.
pub(crate) fn nominal_toml(p: &PlantParameters, law: &ControlSettings) -> Result<String, toml::ser::Error> {
    let rig = Rig {
        supply: Supply { pressure_kpa: p.supply.pressure_kpa },
        ambient: Ambient {
            pressure_kpa_abs: p.ambient.pressure_kpa_abs,
            temperature_k: p.ambient.temperature_k,
        },
        chamber: Chamber {
            radius_m: p.chamber.radius_m,
            length_m: p.chamber.length_m,
            offset_m: p.chamber.offset_m,
        },
        // Only the product of area and discharge coefficient can be identified, so it is fixed
        // at 1.
        valve: Valve { discharge_coefficient: 1.0, critical_ratio: p.valve.flow.critical_ratio() },
        controller: Controller {
            rate_hz: law.rate_hz,
            kp: law.kp,
            kd: law.kd,
            saturation: law.saturation,
            filter: law.filter,
        },
        // The bus carries 10-bit counts whatever the converter.
        sensor: Sensor { bits: 10, zero_counts: 102.4, kpa_per_count: counts10_to_kpa(103.4) },
    };
    toml::to_string(&rig)
}
