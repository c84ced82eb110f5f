//! From a recording and a rig to channels that can be simulated.

use crate::data::{Channel, Drive, Recording};
use crate::effects::{BoardLoop, ChannelInputs, DriveInput, Kind, Plant};
use crate::model::{FlowForm, FlowFunction, Gas, ValveDrive};
use crate::rig::Rig;

use super::blocks::split;
use super::channel::{ChannelData, compared_rows};
use super::error::DiagnosisError;

/// Longest integration step, s. The verdict is checked against half of it.
pub const LONGEST_STEP_S: f64 = 0.005;
/// Longest step of the board's loop while causes are looked for, s. A board's loop is much faster than a chamber: several loops are
/// simulated as one, and only what is reported is fitted and judged with every one of them.
const SEARCH_STEP_S: f64 = 0.0025;
/// Critical ratio of a rig that gives none.
const CRITICAL_RATIO: f64 = 0.3;
/// Volume of a rig that gives none, m^3: only its product with the openings matters.
const VOLUME_M3: f64 = 1e-4;
/// Rows on each side over which a neighbour's pressure is averaged.
const SMOOTH_ROWS: usize = 2;

/// Everything about the channels of a recording.
///
/// # Errors
/// [`DiagnosisError`] when no channel can be simulated, or the recording is too short to be split.
pub fn prepare(recording: &Recording, rig: &Rig) -> Result<Vec<ChannelData>, DiagnosisError> {
    let mut channels = Vec::new();
    let mut reasons = Vec::new();
    for channel in &recording.channels {
        match prepare_channel(recording, rig, channel) {
            Ok(data) => channels.push(data),
            Err(reason) => reasons.push(format!("{}: {reason}", channel.id)),
        }
    }
    if channels.is_empty() {
        return Err(DiagnosisError::NoUsableChannel {
            file: recording.source.file.clone(),
            reasons: reasons.join("; "),
        });
    }
    Ok(channels)
}

fn prepare_channel(recording: &Recording, rig: &Rig, channel: &Channel) -> Result<ChannelData, String> {
    let Some(pressure) = &channel.pressure_kpa else {
        return Err(format!("column {} is missing", channel.id.pressure_column()));
    };
    let ambient = rig.ambient_or_standard();
    let ambient_pa = ambient.pressure_kpa_abs * 1e3;
    let rows = recording.rows();
    let drive = match (&channel.drive, &channel.command_kpa) {
        (Some(Drive::Spool(u)), _) => DriveInput::Spool(to_f64(u)),
        (Some(Drive::Separate { fill, vent }), _) => {
            DriveInput::Separate { fill: to_f64(fill), vent: to_f64(vent) }
        }
        (None, Some(_)) if rig.controller.is_some() && rig.supply.is_some() => DriveInput::Controlled,
        (None, Some(_)) => DriveInput::Command,
        (None, None) => {
            return Err(format!(
                "neither a drive ({}) nor a command ({}) is recorded",
                channel.id.drive_column(),
                channel.id.command_column()
            ));
        }
    };
    let kind = match drive {
        DriveInput::Spool(_) | DriveInput::Controlled => Kind::Nonlinear(ValveDrive::Spool),
        DriveInput::Separate { .. } => Kind::Nonlinear(ValveDrive::Separate),
        DriveInput::Command => Kind::Linear,
    };
    let supply_pa = match (&recording.supply_kpa, &rig.supply) {
        (Some(measured), _) => measured.iter().map(|p| f64::from(*p) * 1e3 + ambient_pa).collect(),
        (None, Some(supply)) => vec![supply.pressure_kpa * 1e3 + ambient_pa; rows],
        (None, None) if kind == Kind::Linear => vec![ambient_pa; rows],
        (None, None) => {
            return Err("the rig file has no [supply] and the recording no column supply_kpa".to_owned());
        }
    };
    let (volume_m3, volume_rate_m3_s, interval_s) = volumes(recording, rig, channel);
    let command_pa: Vec<f64> = match &channel.command_kpa {
        Some(command) => command.iter().map(|c| f64::from(*c) * 1e3 + ambient_pa).collect(),
        None => vec![ambient_pa; rows],
    };
    let usable: Vec<bool> =
        channel.flags.iter().zip(pressure).map(|(f, p)| f.pressure_usable() && p.is_finite()).collect();
    let mut last = pressure.iter().zip(&usable).find(|(_, u)| **u).map_or(0.0, |(p, _)| f64::from(*p));
    let measured_kpa: Vec<f64> = pressure
        .iter()
        .zip(&usable)
        .map(|(p, u)| {
            if *u {
                last = f64::from(*p);
            }
            last
        })
        .collect();
    let step_kpa = rig.sensor.as_ref().map_or(0.0, |s| s.kpa_per_count);
    let noise_kpa = noise(&measured_kpa, &usable).max(step_kpa / 12.0_f64.sqrt() * 0.5).max(1e-4);
    let origin = recording.time_s.first().copied().unwrap_or(0.0);
    let mut starts = recording.breaks.clone();
    starts.insert(0, 0);
    let inputs = ChannelInputs {
        time_s: recording.time_s.iter().map(|t| t - origin).collect(),
        interval_s,
        duration_s: recording.duration_s(),
        starts,
        drive,
        supply_pa,
        volume_m3,
        volume_rate_m3_s,
        measured_pa: measured_kpa.iter().map(|p| p * 1e3 + ambient_pa).collect(),
        usable,
        opposite_pa: opposite(recording, channel),
        sampled_before_pa: sampled_before(recording, channel),
        others_draw: vec![0.0; rows],
        noise_pa: noise_kpa * 1e3,
        ambient_pa,
        command_pa,
    };
    let valve = rig.valve.as_ref();
    let critical_ratio = valve.map_or(CRITICAL_RATIO, |v| v.critical_ratio);
    let range = inputs.command_pa.iter().map(|c| (c - ambient_pa).abs()).fold(1.0, f64::max);
    let plant = Plant {
        kind,
        gas: Gas { temperature_k: ambient.temperature_k, ambient_pa, ..Gas::default() },
        flow: FlowFunction::new(critical_ratio, FlowForm::Iso6358),
        critical_ratio,
        discharge_coefficient: valve.map_or(1.0, |v| v.discharge_coefficient),
        board: board_loop(rig),
        longest_step_s: LONGEST_STEP_S,
        command_range_pa: range,
    };
    let blocks = split(&inputs);
    let (rows, spans) = compared_rows(&inputs, &blocks);
    let measured_kpa = rows.iter().map(|&row| measured_kpa[row as usize]).collect();
    Ok(ChannelData { id: channel.id, plant, inputs, blocks, rows, spans, measured_kpa, noise_kpa })
}

/// Simulates the boards' loops several at a time, or each of them.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at least one, and a rate is below 1e9
pub fn loops_together(channels: &mut [ChannelData], together: bool) {
    for board in channels.iter_mut().filter_map(|data| data.plant.board.as_mut()) {
        let most = (SEARCH_STEP_S * board.rate_hz * (1.0 + 1e-9)).max(1.0) as usize;
        board.loops_per_step = if together { most } else { 1 };
    }
}

fn to_f64(values: &[f32]) -> Vec<f64> {
    values.iter().map(|v| f64::from(*v)).collect()
}

fn board_loop(rig: &Rig) -> Option<BoardLoop> {
    let (controller, sensor) = (rig.controller.as_ref()?, rig.sensor.as_ref()?);
    let pa_per_count = sensor.kpa_per_count * 1e3;
    Some(BoardLoop {
        rate_hz: controller.rate_hz,
        gain_per_pa: controller.kp / controller.saturation / pa_per_count,
        damping_per_pa: controller.kd / controller.saturation / pa_per_count,
        filter: controller.filter,
        lowest_pa: sensor.kpa(0.0) * 1e3,
        highest_pa: sensor.kpa(sensor.full_scale_counts()) * 1e3,
        loops_per_step: 1,
    })
}

/// Mean volume, its rate and the length of every interval.
fn volumes(recording: &Recording, rig: &Rig, channel: &Channel) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let rows = recording.rows();
    let interval: Vec<f64> = (0..rows)
        .map(|k| match recording.time_s.get(k + 1) {
            Some(next) if !recording.breaks.contains(&(k + 1)) => next - recording.time_s[k],
            _ => recording.period_s,
        })
        .collect();
    let rest = rig.chamber.as_ref().map_or(VOLUME_M3, |c| c.rest_volume_m3());
    let per_rad = rig.chamber.as_ref().map_or(0.0, |c| c.volume_per_rad_m3());
    match recording.joint_angle(channel.id) {
        Some((angle, sign)) if per_rad > 0.0 => {
            let at = |k: usize| f64::from(angle[k.min(rows - 1)]);
            let floor = 0.05 * rest;
            let volume = (0..rows).map(|k| (rest + sign * per_rad * 0.5 * (at(k) + at(k + 1))).max(floor));
            let rate = (0..rows).map(|k| sign * per_rad * (at(k + 1) - at(k)) / interval[k]);
            (volume.collect(), rate.collect(), interval)
        }
        _ => (vec![rest; rows], vec![0.0; rows], interval),
    }
}

/// Smoothed pressure of the chamber on the other side of the joint, unless the joint is measured.
fn opposite(recording: &Recording, channel: &Channel) -> Vec<f64> {
    if recording.joint_angle(channel.id).is_some() {
        return Vec::new();
    }
    neighbour(recording, channel, channel.id.channel ^ 1, SMOOTH_ROWS)
}

/// Pressure of the channel that the converter samples before this one; channel 0 follows the board's last.
fn sampled_before(recording: &Recording, channel: &Channel) -> Vec<f64> {
    let last =
        recording.channels.iter().filter(|c| c.id.board == channel.id.board).map(|c| c.id.channel).max();
    let before = if channel.id.channel == 0 { last.unwrap_or(0) } else { channel.id.channel - 1 };
    if before == channel.id.channel { Vec::new() } else { neighbour(recording, channel, before, 0) }
}

fn neighbour(recording: &Recording, channel: &Channel, number: u8, smooth: usize) -> Vec<f64> {
    let wanted = |c: &&Channel| c.id.board == channel.id.board && c.id.channel == number;
    let Some(pressure) = recording.channels.iter().find(wanted).and_then(|c| c.pressure_kpa.as_ref()) else {
        return Vec::new();
    };
    let mut last = 0.0;
    let held: Vec<f64> = pressure
        .iter()
        .map(|p| {
            if p.is_finite() {
                last = f64::from(*p) * 1e3;
            }
            last
        })
        .collect();
    (0..held.len())
        .map(|k| {
            let window = &held[k.saturating_sub(smooth)..(k + smooth + 1).min(held.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

/// Noise of a measurement from what a parabola over nine samples leaves, in the quieter quarter of the recording (where the
/// lower quartile of chi-squared with six degrees of freedom, 3.455, stands for its mean).
fn noise(measured: &[f64], usable: &[bool]) -> f64 {
    const N: usize = 9;
    const QUARTILE: f64 = 3.455 / 6.0;
    let x: Vec<f64> = (0..N).map(|k| k as f64 - 4.0).collect();
    let square: Vec<f64> = x.iter().map(|v| v * v - 60.0 / 9.0).collect();
    let (sx, sq) = (60.0, square.iter().map(|v| v * v).sum::<f64>());
    let mut variances: Vec<f64> = measured
        .chunks_exact(N)
        .zip(usable.chunks_exact(N))
        .filter(|(_, u)| u.iter().all(|u| *u))
        .map(|(y, _)| {
            let mean = y.iter().sum::<f64>() / N as f64;
            let dot = |w: &[f64]| y.iter().zip(w).map(|(y, w)| (y - mean) * w).sum::<f64>();
            let total: f64 = y.iter().map(|v| (v - mean) * (v - mean)).sum();
            (total - dot(&x).powi(2) / sx - dot(&square).powi(2) / sq).max(0.0) / 6.0
        })
        .collect();
    if variances.is_empty() {
        return 0.0;
    }
    variances.sort_by(f64::total_cmp);
    (variances[variances.len() / 4] / QUARTILE).sqrt()
}
