//! Channels simulated with the parameters of a fit, each on its own.

use crate::data::{Channel, Recording};
use crate::experiment::{ControllerUse, Setup, score, simulation};
use crate::rig::Rig;
use crate::rollout::Start;
use crate::store::ParameterFile;

use super::error::SimulationError;
use super::result::{SimulatedChannel, SimulatedModel, SimulationSettings};

pub(super) fn simulate(
    file: (&str, &ParameterFile),
    recording: &Recording,
    rig: &Rig,
    settings: &SimulationSettings<'_>,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Vec<SimulatedChannel>, SimulationError> {
    let mut channels = Vec::with_capacity(recording.channels.len());
    for channel in &recording.channels {
        channels.push(simulate_channel(file, recording, channel, rig, settings)?);
        progress(channels.len(), recording.channels.len());
    }
    Ok(channels)
}

fn simulate_channel(
    (name, file): (&str, &ParameterFile),
    recording: &Recording,
    channel: &Channel,
    rig: &Rig,
    settings: &SimulationSettings<'_>,
) -> Result<SimulatedChannel, SimulationError> {
    let stored = file.channel(name, channel.id)?;
    let controller = match settings.controller {
        ControllerUse::Auto if stored.setup.controller => ControllerUse::On,
        chosen => chosen,
    };
    let drive = stored.setup.drive.unwrap_or_default();
    let setup = Setup::resolve(stored.setup.model, controller, drive, recording, channel, rig)?;
    let prepared = simulation(setup, recording, channel, rig, file.flow_form(), settings.start_kpa)?;
    let values = file.values(name, channel.id, &prepared.subject)?;
    let series = &prepared.series[0];
    let absolute_pa = prepared.subject.simulate(&values, series, Start::Measured, stored.substeps);
    if series.segments().iter().any(|rows| absolute_pa[rows.clone()].iter().any(|p| !p.is_finite())) {
        return Err(SimulationError::RunsAway { channel: channel.id });
    }
    let ambient_kpa = rig.ambient_or_standard().pressure_kpa_abs;
    Ok(SimulatedChannel {
        id: channel.id,
        model: SimulatedModel::Fitted(setup),
        kpa: absolute_pa.iter().map(|pa| pa * 1e-3 - ambient_kpa).collect(),
        score: (channel.usable_samples() > 0).then(|| score(series, &absolute_pa)).flatten(),
        band: None,
    })
}
