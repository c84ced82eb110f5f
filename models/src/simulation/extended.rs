//! Channels simulated with the extended model of a diagnosis, all at once: neighbours act on each
//! other.

use crate::data::Recording;
use crate::diagnosis::{self, Band, ExtendedFile, Purpose, rates_kpa_s, simulate_extended};
use crate::experiment::{ControllerUse, score_rows};
use crate::rig::Rig;

use super::error::SimulationError;
use super::result::{SimulatedBand, SimulatedChannel, SimulatedModel, SimulationSettings};

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
            band: stored.and_then(|c| c.band).map(|band| around(band, recording, &simulated)),
            kpa: simulated.kpa,
            score,
        });
    }
    Ok(channels)
}

/// The band around a simulated channel, and what it holds of the pressures that were measured.
fn around(band: Band, recording: &Recording, simulated: &diagnosis::SimulatedChannel) -> SimulatedBand {
    let starts: Vec<usize> = recording.segments().iter().map(|rows| rows.start).collect();
    let rates = rates_kpa_s(&recording.time_s, &simulated.kpa, &starts);
    let half_width_kpa: Vec<f64> = rates.iter().map(|rate| band.half_width_kpa(*rate)).collect();
    let measured = recording.channel(simulated.id).ok().and_then(|channel| channel.pressure_kpa.as_deref());
    let compared = measured.unwrap_or_default().iter().enumerate().filter(|(row, _)| simulated.usable[*row]);
    let (mut inside, mut count) = (0_usize, 0_usize);
    for (row, kpa) in compared {
        count += 1;
        inside += usize::from((f64::from(*kpa) - simulated.kpa[row]).abs() <= half_width_kpa[row]);
    }
    SimulatedBand { half_width_kpa, holds: (count > 0).then(|| inside as f64 / count as f64) }
}
