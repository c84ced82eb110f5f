//! `extended.toml` simulated: pressures from drives or commands alone.
//!
//! What a channel needs of its neighbours (the flow they draw from the supply, the pressure opposite, the sample before it) comes
//! from their own simulation: all channels are simulated a few times, each time with what the neighbours did the time before.

use rayon::prelude::*;

use super::channel::{ChannelData, Extended};
use super::dependence::Variable;
use super::error::DiagnosisError;
use super::extended::ExtendedFile;
use super::neighbours::Pressures;
use super::prepare::{Purpose, prepare_for};
use super::stage::share_draws;
use crate::data::{ChannelId, Recording};
use crate::effects::Series;
use crate::effects::catalogue::CATALOGUE;
use crate::rig::Rig;

/// Passes over all channels when one of them depends on the others.
const PASSES: usize = 4;

/// One simulated channel.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedChannel {
    /// Which one.
    pub id: ChannelId,
    /// What its sensor is expected to report, row by row, kPa gauge.
    pub kpa: Vec<f64>,
    /// The drive over the interval that starts at each row, -1 to 1.
    pub drive: Vec<f64>,
    /// Rows where the measured pressure may be compared with it.
    pub usable: std::sync::Arc<[bool]>,
    /// What drove it: `spool`, `separate`, `board` or `command`.
    pub driven_by: &'static str,
}

/// Simulates the channels of a recording; `name` is the file's, for messages.
///
/// # Errors
/// [`DiagnosisError`] when the recording or the file lacks something that the simulation needs.
pub fn simulate_extended(
    name: &str,
    file: &ExtendedFile,
    recording: &Recording,
    rig: &Rig,
    purpose: Purpose,
) -> Result<Vec<SimulatedChannel>, DiagnosisError> {
    let (mut channels, _) = prepare_for(recording, rig, purpose)?;
    for data in &mut channels {
        if let Some(stored) = file.channels.get(&data.id.to_string()) {
            data.inputs.noise_pa = stored.noise_kpa * 1e3;
            data.plant.command_range_pa = stored.command_range_kpa * 1e3;
        }
    }
    let models = file.models(name, &channels)?;
    let traces = settled(&mut channels, &models);
    Ok(channels
        .into_iter()
        .zip(traces)
        .map(|(data, trace)| SimulatedChannel {
            id: data.id,
            driven_by: data.driven_by(),
            kpa: trace.iter().map(|row| row[0]).collect(),
            drive: trace.iter().map(|row| row[1]).collect(),
            usable: data.inputs.usable,
        })
        .collect())
}

/// Traces (reading in kPa gauge, drive, flow drawn) of all channels, each with its neighbours as simulated.
#[must_use]
pub fn settled(channels: &mut [ChannelData], models: &[Extended]) -> Vec<Vec<[f64; 3]>> {
    let needs = |id: &str| models.iter().any(|m| m.effects.iter().any(|&e| CATALOGUE[e].id == id));
    let corrected = |by| models.iter().filter_map(|m| m.correction.as_ref()).any(|c| c.variable == by);
    let pressures = needs("chamber_coupling") || needs("sensor_crosstalk") || corrected(Variable::Opposite);
    let draws = needs("supply_sag") || corrected(Variable::OthersDraw);
    let traces = |channels: &[ChannelData]| -> Vec<Vec<[f64; 3]>> {
        channels.par_iter().zip(models).map(|(data, model)| data.trace(model)).collect()
    };
    let mut now = traces(channels);
    for _ in 0..if pressures || draws { PASSES } else { 0 } {
        if pressures {
            let simulated: Vec<(ChannelId, Series)> = channels
                .iter()
                .zip(&now)
                .map(|(data, trace)| (data.id, trace.iter().map(|row| row[0]).collect()))
                .collect();
            let simulated = Pressures::simulated(simulated);
            channels.iter_mut().for_each(|data| simulated.put_into(data));
        }
        if draws {
            share_draws(channels, models);
        }
        now = traces(channels);
    }
    now
}
