//! Channels simulated with the extended model of a diagnosis, all at once: neighbours act on each other.

use crate::data::Recording;
use crate::diagnosis::{ExtendedFile, Purpose, simulate_extended};
use crate::experiment::{ControllerUse, score_rows};
use crate::rig::Rig;

use super::error::SimulationError;
use super::result::{SimulatedChannel, SimulatedModel, SimulationSettings};

pub(super) fn simulate(
    (name, file): (&str, &ExtendedFile),
    recording: &Recording,
    rig: &Rig,
    settings: &SimulationSettings<'_>,
) -> Result<Vec<SimulatedChannel>, SimulationError> {
    let controller = match settings.controller {
        ControllerUse::On => true,
        ControllerUse::Off => false,
        ControllerUse::Auto => file.channels.values().any(|channel| channel.drive == "board"),
    };
    let purpose = Purpose::Simulate { start_kpa: settings.start_kpa, controller };
    let mut channels = Vec::new();
    for simulated in simulate_extended(name, file, recording, rig, purpose)? {
        if !simulated.kpa.iter().all(|p| p.is_finite()) {
            return Err(SimulationError::RunsAway { channel: simulated.id });
        }
        let stored = file.channels.get(&simulated.id.to_string());
        let score =
            score_rows(recording, recording.channel(simulated.id)?, &simulated.kpa, &simulated.usable);
        channels.push(SimulatedChannel {
            id: simulated.id,
            model: SimulatedModel::Extended {
                model: file.model.clone(),
                driven_by: simulated.driven_by,
                effects: stored.map(|c| c.effects.keys().cloned().collect()).unwrap_or_default(),
                correction: stored.is_some_and(|c| c.correction.is_some()),
            },
            kpa: simulated.kpa,
            score,
        });
    }
    Ok(channels)
}
