//! `extended.toml` simulated: pressures from drives or commands alone.
//!
//! What a channel needs of its neighbours (the flow they draw from the supply, the pressure
//! opposite, the sample before it) comes from their own simulation: all channels are simulated a
//! few times, each time with what the neighbours did the time before.

use crate::diagnosis::channel::settled;

use crate::data::{ChannelId, Recording};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::preconditions::{Purpose, prepare_for};
use crate::diagnosis::report::ExtendedFile;
use crate::rig::Rig;

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
