//! What is asked of a simulation, and what comes out.

use serde::Serialize;

use crate::data::{Channel, ChannelId, Flags, Recording};
use crate::experiment::{ControllerUse, Score, Setup};
use crate::rig::Rig;

/// How a recording is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SimulationSettings<'a> {
    /// Another rig than the one that the model was calibrated with.
    pub rig: Option<&'a Rig>,
    /// Whether the board's loop is simulated: by default as it was calibrated, and where the drive
    /// is not recorded.
    pub controller: ControllerUse,
    /// Pressure to start from where none was measured, kPa gauge.
    pub start_kpa: f64,
}

/// Simulated pressures of the channels of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// The channels.
    pub channels: Vec<SimulatedChannel>,
}

/// One simulated channel.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedChannel {
    /// Which one.
    pub id: ChannelId,
    /// What was simulated.
    pub model: SimulatedModel,
    /// What its sensor is expected to report, row by row, kPa gauge; `NaN` where inputs are
    /// missing.
    pub kpa: Vec<f64>,
    /// Its errors against the measured pressures, where there are some.
    pub score: Option<Score>,
    /// The 95 % band around it, where the model's file has one.
    pub band: Option<SimulatedBand>,
}

/// A 95 % band around a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedBand {
    /// Half of its width, row by row, kPa.
    pub half_width_kpa: Vec<f64>,
    /// Share of the measured pressures that it holds, where there are some.
    pub holds: Option<f64>,
}

/// What was simulated.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SimulatedModel {
    /// The model of a fit.
    Fitted(Setup),
    /// The model of a diagnosis.
    Extended {
        /// The base model.
        model: String,
        /// `spool`, `separate`, `board` (its loop simulated) or `command` (a regulator).
        driven_by: &'static str,
        /// The effects' ids.
        effects: Vec<String>,
        /// Whether a smooth correction is part of it.
        correction: bool,
    },
}

impl SimulatedModel {
    /// In words, as in `nonlinear model behind the board's loop with transport_delay`.
    #[must_use]
    pub fn words(&self) -> String {
        let (model, in_loop, parts) = match self {
            Self::Fitted(setup) => (setup.model.name(), setup.controller, Vec::new()),
            Self::Extended { model, driven_by, effects, correction } => {
                let correction = correction.then_some("a correction");
                let parts = effects.iter().map(String::as_str).chain(correction).collect();
                (model.as_str(), *driven_by == "board", parts)
            }
        };
        let in_loop = if in_loop { " behind the board's loop" } else { "" };
        let with = if parts.is_empty() { String::new() } else { format!(" with {}", parts.join(", ")) };
        format!("{model} model{in_loop}{with}")
    }
}

impl SimulatedChannel {
    /// Lowest and highest pressure, kPa gauge.
    #[must_use]
    pub fn range_kpa(&self) -> (f64, f64) {
        let finite = self.kpa.iter().filter(|p| p.is_finite());
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
    }
}

impl Simulation {
    /// The recording with simulated pressures in place of measured ones.
    #[must_use]
    pub fn recording(&self, measured: &Recording) -> Recording {
        let with = |simulated: &SimulatedChannel| {
            let channel = measured.channels.iter().find(|channel| channel.id == simulated.id)?;
            Some(Channel {
                // Single precision: as measured pressures are kept.
                pressure_kpa: Some(simulated.kpa.iter().map(|kpa| *kpa as f32).collect()),
                flags: vec![Flags::NONE; simulated.kpa.len()],
                ..channel.clone()
            })
        };
        Recording { channels: self.channels.iter().filter_map(with).collect(), ..measured.clone() }
    }
}
