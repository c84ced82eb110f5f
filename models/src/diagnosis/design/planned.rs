//! A recording that has not been made: the channels as they would be under an excitation.

use super::menu::{Excitation, PERIOD_S};
use crate::diagnosis::channel::{ChannelData, compared_rows, split};
use crate::effects::{ChannelInputs, DriveInput, Series};

/// Can this channel be driven by commands alone in a simulation?
#[must_use]
pub fn realisable(data: &ChannelData) -> bool {
    data.plant.model.is_regulator() || (!data.plant.separate() && data.plant.board.is_some())
}

/// The channels under an excitation between two pressures (kPa gauge), sampled as they were;
/// nothing is measured yet.
#[must_use]
pub fn planned(channels: &[ChannelData], excitation: Excitation, range_kpa: [f64; 2]) -> Vec<ChannelData> {
    channels
        .iter()
        .enumerate()
        .map(|(k, data)| one(data, &excitation.commands(k, channels.len(), range_kpa), excitation.seconds()))
        .collect()
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of rows
fn one(data: &ChannelData, commands: &[f64], seconds: f64) -> ChannelData {
    let old = &data.inputs;
    let period = middle(&old.interval_s);
    let rows = (seconds / period).round() as usize;
    let time_s: Series = (0..rows).map(|k| k as f64 * period).collect();
    let command = |t: &f64| commands[((t / PERIOD_S + 1e-6) as usize).min(commands.len() - 1)];
    let every = |value: f64| -> Series { vec![value; rows].into() };
    let rest = |values: &Series| if values.is_empty() { Series::default() } else { every(0.0) };
    let inputs = ChannelInputs {
        command_pa: time_s.iter().map(|t| command(t) * 1e3 + old.ambient_pa).collect(),
        interval_s: every(period),
        duration_s: seconds,
        starts: [0].into(),
        anchors: [].into(),
        drive: if data.plant.model.is_regulator() { DriveInput::Command } else { DriveInput::Controlled },
        supply_pa: every(middle(&old.supply_pa)),
        volume_m3: every(middle(&old.volume_m3)),
        volume_rate_m3_s: every(0.0),
        // Only the first is used; no two neighbours are equal, or they would look like repeated
        // samples.
        measured_pa: (0..rows).map(|k| commands[0] * 1e3 + old.ambient_pa + (k % 2) as f64).collect(),
        usable: vec![true; rows].into(),
        opposite_pa: rest(&old.opposite_pa),
        sampled_before_pa: rest(&old.sampled_before_pa),
        // What the neighbours will be driven with is not planned.
        neighbour_drive: Series::default(),
        others_draw: every(0.0),
        noise_pa: old.noise_pa,
        ambient_pa: old.ambient_pa,
        time_s,
    };
    let blocks = split(&inputs);
    let (rows, spans) = compared_rows(&inputs, &blocks);
    let measured_kpa = vec![0.0; rows.len()].into();
    ChannelData { plant: data.plant.clone(), inputs, blocks, rows, spans, measured_kpa, ..*data }
}

fn middle(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    let middle = sorted.len() / 2;
    *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
}
