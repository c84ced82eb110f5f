//! The simulation of a whole recording.

use crate::data::Recording;

use super::calibrated::CalibratedModel;
use super::error::SimulationError;
use super::result::{Simulation, SimulationSettings};
use super::{extended, fitted};

/// Simulates the channels of a recording from commands or drives alone. Measured pressures are not
/// used, except for the first of each stretch to start from, and to judge the simulation by.
/// `progress` is told after each channel how many are done, and of how many.
///
/// # Errors
/// [`SimulationError`] when recording, rig or model lack something, or a pressure runs away.
pub fn simulate(
    model: &CalibratedModel,
    recording: &Recording,
    settings: &SimulationSettings<'_>,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Simulation, SimulationError> {
    let rig = settings.rig.unwrap_or(model.rig());
    let channels = match model {
        CalibratedModel::Fitted { name, file } => {
            fitted::simulate((name, file), recording, rig, settings, progress)?
        }
        CalibratedModel::Extended { name, file } => {
            extended::simulate((name, file), recording, rig, settings)?
        }
    };
    Ok(Simulation { channels })
}
