//! `pneudrive-model export jax`

use std::fmt::Write as _;
use std::path::PathBuf;

use pneudrive_model::diagnosis::{ExtendedChannel, ExtendedFile};
use pneudrive_model::experiment::ModelKind;
use pneudrive_model::model::{FlowForm, Model, Nonlinear, ValveDrive};
use pneudrive_model::rig::Rig;
use pneudrive_model::simulation::CalibratedModel;
use pneudrive_model::store::{ChannelParameters, ParameterFile};

use super::{Failure, From};

/// The model, which needs nothing but JAX; Python's own `pneudrive_py.jax` has it from the same
/// file.
const MODEL: &str = include_str!("../../../../python/python/pneudrive_py/_jax_model.py");

/// Runge-Kutta steps per interval of what a diagnosis calibrated.
const SUBSTEPS: usize = 4;

/// A Python package of the chambers' rates in JAX, for `jit`, `vmap` and `grad`
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
pneudrive-model export jax --parameters nonlinear.toml --out chambers\n  \
python3 -c 'import chambers; c = chambers.CHANNELS[\"b0c0\"]; print(c.dp(100.0, 0.3))'\n\n\
The package needs JAX and nothing else: copy it to where your simulation is. It has the nonlinear model, as a pure function of pressure, \
drive, volume and parameters. Effects that a diagnosis found, and the board's loop, have states of their own: they are refused here, and \
are in `export c`, `mujoco` and `fmu`.")]
pub struct Args {
    /// Parameter file that `fit` wrote, or extended.toml that `diagnose` wrote
    #[arg(long, value_name = "FILE.toml")]
    parameters: PathBuf,
    /// Package to write: a folder with a name that Python can import
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let name = self.out.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if name.is_empty() || !letters || name.starts_with(|c: char| c.is_ascii_digit()) {
            return Err(Failure::input(format!(
                "--out {}: Python cannot import a package of that name; use letters, digits and _",
                self.out.display()
            )));
        }
        let name = name.to_owned();
        let from = From { parameters: self.parameters, out: self.out };
        let model = from.load()?;
        let channels = match &model {
            CalibratedModel::Fitted { file, .. } => fitted(file)?,
            CalibratedModel::Extended { file, .. } => extended(file)?,
        };
        let constants = constants(model.rig())?;
        from.make_folder()?;
        from.text("model.py", MODEL)?;
        from.text("__init__.py", &package(&name, &channels, &constants))
    }
}

/// A channel: its name, its parameters in the model's order, and how intervals are divided.
struct Channel {
    name: String,
    theta: Vec<f64>,
    substeps: usize,
}

fn fitted(file: &ParameterFile) -> Result<Vec<Channel>, Failure> {
    if file.flow_form() == FlowForm::Printed {
        return Err(Failure::input(
            "the fit used the printed flow function; export jax has that of ISO 6358",
        ));
    }
    let one = |(id, stored): (_, &ChannelParameters)| -> Result<Channel, Failure> {
        let (name, model) = (format!("{id}"), stored.setup.model);
        if model != ModelKind::Nonlinear {
            return Err(Failure::input(format!(
                "{name} is the {} model; export jax has the nonlinear one: fit that",
                model.name()
            )));
        }
        let theta = stored.parameters.iter().map(|p| p.value).collect();
        Ok(Channel { name, theta, substeps: stored.substeps })
    };
    file.channels.iter().map(one).collect()
}

fn extended(file: &ExtendedFile) -> Result<Vec<Channel>, Failure> {
    if file.model != "nonlinear" {
        return Err(Failure::input(format!(
            "the base model is {}; export jax has the nonlinear one",
            file.model
        )));
    }
    file.channels.iter().map(|(name, channel)| extended_channel(name, channel)).collect()
}

fn extended_channel(name: &str, channel: &ExtendedChannel) -> Result<Channel, Failure> {
    let mut more: Vec<&str> = channel.effects.keys().map(String::as_str).collect();
    more.extend(channel.correction.as_ref().map(|_| "its smooth correction"));
    if !more.is_empty() {
        return Err(Failure::input(format!(
            "{name} has {}, which a pure function of the pressure cannot hold; export c, mujoco and fmu have it",
            more.join(", ")
        )));
    }
    let drive = match channel.drive.as_str() {
        "command" => {
            return Err(Failure::input(format!(
                "{name} is a regulator, which follows commands; it has no drive"
            )));
        }
        "separate" => ValveDrive::Separate,
        _ => ValveDrive::Spool,
    };
    let order = Nonlinear { drive, ..Nonlinear::default() }.parameters();
    let value = |parameter: &str| {
        let missing = || Failure::input(format!("{name} has no parameter {parameter}"));
        channel.parameters.get(parameter).copied().ok_or_else(missing)
    };
    let theta = order.iter().map(|p| value(&p.name)).collect::<Result<_, _>>()?;
    Ok(Channel { name: name.to_owned(), theta, substeps: SUBSTEPS })
}

/// The constants as Python's keywords.
fn constants(rig: &Rig) -> Result<String, Failure> {
    let missing = |table| Failure::input(format!("the rig has no [{table}], which the chamber's rate needs"));
    let supply = rig.supply.as_ref().ok_or_else(|| missing("supply"))?;
    let chamber = rig.chamber.as_ref().ok_or_else(|| missing("chamber"))?;
    let (ambient, valve) = (rig.ambient_or_standard(), rig.valve.clone().unwrap_or_default());
    Ok(format!(
        "supply_kpa={:?}, volume_m3={:?}, ambient_kpa_abs={:?}, temperature_k={:?}, critical_ratio={:?}, \
discharge_coefficient={:?}",
        supply.pressure_kpa,
        chamber.rest_volume_m3(),
        ambient.pressure_kpa_abs,
        ambient.temperature_k,
        valve.critical_ratio,
        valve.discharge_coefficient
    ))
}

fn package(name: &str, channels: &[Channel], constants: &str) -> String {
    let mut text = format!(
        "\"\"\"Calibrated chambers in JAX, written by `pneudrive-model export jax`::\n\n    \
import {name}\n\n    \
channel = {name}.CHANNELS[\"{}\"]\n    \
channel.dp(100.0, 0.3)                        # kPa/s at 100 kPa gauge and a drive of 0.3\n    \
channel.rollout(0.0, drives, 0.01)            # kPa gauge at rows 10 ms apart\n\n\
`dp` and `rollout` of this package are the same with everything as an argument, for `grad` by parameters or volume.\n\"\"\"\n\n\
from typing import NamedTuple\n\n\
from .model import Constants, dp, rollout\n\n\
__all__ = [\"CHANNELS\", \"Channel\", \"Constants\", \"dp\", \"rollout\"]\n\n\n\
class Channel(NamedTuple):\n    \
\"\"\"A chamber with its valve.\"\"\"\n\n    \
#: Parameters, as `dp` takes them.\n    theta: tuple\n    \
#: What is fixed about it.\n    constants: Constants\n    \
#: Runge-Kutta steps per interval that the calibration used.\n    substeps: int\n\n    \
def dp(self, p_kpa, drive, volume_m3=None, volume_rate_m3_s=0.0):\n        \
\"\"\"Rate of the pressure, kPa/s; the volume is that at rest unless given.\"\"\"\n        \
volume = self.constants.volume_m3 if volume_m3 is None else volume_m3\n        \
return dp(p_kpa, drive, volume, volume_rate_m3_s, self.theta, self.constants)\n\n    \
def rollout(self, start_kpa, drive, interval_s, **inputs):\n        \
\"\"\"Pressures under a course of drives, kPa gauge; `inputs` as of the function `rollout`.\"\"\"\n        \
inputs.setdefault(\"substeps\", self.substeps)\n        \
return rollout(start_kpa, drive, interval_s, self.theta, self.constants, **inputs)\n\n\n\
CONSTANTS = Constants({constants})\n\n\
#: Calibrated channels by name.\nCHANNELS = {{\n",
        channels.first().map_or("b0c0", |channel| channel.name.as_str())
    );
    for Channel { name, theta, substeps } in channels {
        let _ = writeln!(text, "    \"{name}\": Channel(({}), CONSTANTS, {substeps}),", join(theta));
    }
    text + "}\n"
}

/// Numbers as Python reads them back to the bit.
fn join(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", ")
}
