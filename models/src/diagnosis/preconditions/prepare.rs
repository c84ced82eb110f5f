//! From a recording and a rig to channels that can be simulated.

use super::shared_inputs::to_f64;
use crate::data::{Channel, Drive, Flags, Recording};
use crate::effects::{BoardLoop, ChannelInputs, DriveInput, Plant, Series};
use crate::model::{BaseModel, FlowForm, Linear, Listed, Nonlinear, ValveDrive};
use crate::rig::Rig;

use super::check::clipped_rows;
use super::shared_inputs::Common;
use crate::diagnosis::channel::{ChannelData, LONGEST_STEP_S, anchors, compared_rows, split};
use crate::diagnosis::error::DiagnosisError;
use crate::noise::noise;

/// What the channels are prepared for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Purpose {
    /// To be compared with measured pressures.
    Compare,
    /// To be simulated from drives or commands alone, from this pressure (kPa gauge) where none is
    /// measured.
    Simulate {
        /// Pressure to start from, kPa gauge.
        start_kpa: f64,
        /// Simulate the board's loop even where the drive is recorded.
        controller: bool,
    },
}

/// Everything about the channels of a recording.
///
/// # Errors
/// [`DiagnosisError`] when no channel can be simulated.
pub fn prepare(recording: &Recording, rig: &Rig) -> Result<Vec<ChannelData>, DiagnosisError> {
    Ok(prepare_for(recording, rig, Purpose::Compare)?.0)
}

/// As [`prepare`], for any purpose, with a remark on every channel that is left out.
///
/// # Errors
/// As [`prepare`].
pub fn prepare_for(
    recording: &Recording,
    rig: &Rig,
    purpose: Purpose,
) -> Result<(Vec<ChannelData>, Vec<String>), DiagnosisError> {
    let start_kpa = match purpose {
        Purpose::Compare => None,
        Purpose::Simulate { start_kpa, .. } => Some(start_kpa),
    };
    let common = Common::new(recording, rig, start_kpa);
    let mut channels = Vec::new();
    let mut reasons = Vec::new();
    for channel in &recording.channels {
        match prepare_channel(recording, rig, channel, &common, purpose) {
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
    let left_out = reasons.into_iter().map(|reason| format!("Left out: {reason}.")).collect();
    Ok((channels, left_out))
}

fn prepare_channel(
    recording: &Recording,
    rig: &Rig,
    channel: &Channel,
    common: &Common,
    purpose: Purpose,
) -> Result<ChannelData, String> {
    let rig = &rig.at(channel.id);
    let ambient_pa = rig.gas().ambient_pa;
    let rows = recording.rows();
    let (start_kpa, controller) = match purpose {
        Purpose::Compare => (0.0, false),
        Purpose::Simulate { start_kpa, controller } => (start_kpa, controller),
    };
    let unmeasured;
    let pressure = match (&channel.pressure_kpa, purpose) {
        (Some(pressure), _) => pressure,
        (None, Purpose::Compare) => {
            return Err(format!("column {} is missing", channel.id.pressure_column()));
        }
        (None, Purpose::Simulate { .. }) => {
            unmeasured = vec![f32::NAN; rows];
            &unmeasured
        }
    };
    let drive = drive_of(rig, channel, controller)?;
    let model = base_model(rig, &drive);
    let supply_pa = match common.supply_pa(channel.id.board) {
        Some(supply) => supply.clone(),
        None if model.is_regulator() => common.ambient_pa.clone(),
        None => {
            return Err(
                "the rig file has no [supply], or none is given (--rig), and the recording has no column supply_kpa or b{n}_supply_kpa"
                    .to_owned(),
            );
        }
    };
    let (volume_m3, volume_rate_m3_s) = volumes(recording, rig, channel, common);
    let command_pa: Series = match &channel.command_kpa {
        Some(command) => to_f64(command).iter().map(|c| c * 1e3 + ambient_pa).collect(),
        None => common.ambient_pa.clone(),
    };
    let counts =
        |f: &Flags, p: &f32| f.pressure_usable() && !f.contains(Flags::INPUT_MISSING) && p.is_finite();
    let mut usable: Vec<bool> = channel.flags.iter().zip(pressure).map(|(f, p)| counts(f, p)).collect();
    let mut last = pressure.iter().zip(&usable).find(|(_, u)| **u).map_or(start_kpa, |(p, _)| f64::from(*p));
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
    let measured_pa: Series = measured_kpa.iter().map(|p| p * 1e3 + ambient_pa).collect();
    for row in clipped_rows(&drive, &command_pa, &measured_pa, &usable) {
        usable[row] = false;
    }
    let step_kpa = rig.sensor.as_ref().map_or(0.0, |s| s.kpa_per_count);
    let noise_kpa = noise(&measured_kpa, &usable).max(step_kpa / 12.0_f64.sqrt() * 0.5).max(1e-4);
    let jointed = recording.joint_angle(channel.id).is_some();
    let board = rig.board().ok().map(|board| BoardLoop::new(&board));
    let mut inputs = ChannelInputs {
        time_s: common.time_s.clone(),
        interval_s: common.interval_s.clone(),
        duration_s: recording.duration_s(),
        starts: common.starts.clone(),
        anchors: [].into(),
        drive,
        supply_pa,
        volume_m3,
        volume_rate_m3_s,
        measured_pa,
        usable: usable.into(),
        opposite_pa: if jointed { Series::default() } else { common.pressures.opposite_pa(channel.id) },
        sampled_before_pa: common.pressures.sampled_before_pa(channel.id),
        neighbour_drive: neighbour_drive(recording, channel, board.as_ref()),
        others_draw: common.zeros.clone(),
        noise_pa: noise_kpa * 1e3,
        ambient_pa,
        command_pa,
    };
    if purpose == Purpose::Compare {
        inputs.anchors = anchors(&inputs);
    }
    let range = inputs.command_pa.iter().map(|c| (c - ambient_pa).abs()).fold(1.0, f64::max);
    let plant = Plant { model, board, longest_step_s: LONGEST_STEP_S, command_range_pa: range };
    let blocks = split(&inputs);
    let (rows, spans) = compared_rows(&inputs, &blocks);
    let measured_kpa = rows.iter().map(|&row| measured_kpa[row as usize]).collect();
    Ok(ChannelData { id: channel.id, plant, inputs, blocks, rows, spans, measured_kpa, noise_kpa })
}

/// The model of what is driven so.
fn base_model(rig: &Rig, drive: &DriveInput) -> BaseModel {
    let drive = match drive {
        DriveInput::Spool(_) | DriveInput::Controlled => ValveDrive::Spool,
        DriveInput::Separate { .. } => ValveDrive::Separate,
        DriveInput::Command => return BaseModel::Linear(Linear { gas: rig.gas() }),
    };
    BaseModel::Nonlinear(Nonlinear::of(&rig.constants(drive, FlowForm::Iso6358)))
}

/// Recorded drive of the channel before; without one, what a board's proportional gain makes of its
/// command and pressure.
fn neighbour_drive(recording: &Recording, channel: &Channel, board: Option<&BoardLoop>) -> Series {
    let number = before(recording, channel);
    let wanted = |c: &&Channel| c.id.board == channel.id.board && c.id.channel == number;
    let Some(other) = recording.channels.iter().find(wanted).filter(|c| c.id != channel.id) else {
        return Series::default();
    };
    match (&other.drive, &other.command_kpa, &other.pressure_kpa, board) {
        (Some(Drive::Spool(u)), ..) => to_f64(u),
        (Some(Drive::Separate { fill, vent }), ..) => {
            fill.iter().zip(vent).map(|(f, v)| f64::from(*f - *v)).collect()
        }
        (None, Some(command), Some(pressure), Some(board)) => {
            let drive = command.iter().zip(pressure).map(|(c, p)| {
                let u = f64::from(c - p) * 1e3 * board.law.gain;
                if u.is_finite() { u.clamp(-1.0, 1.0) } else { 0.0 }
            });
            drive.collect()
        }
        _ => Series::default(),
    }
}

/// Number of the channel that the board handles before this one; before channel 0 comes the last.
fn before(recording: &Recording, channel: &Channel) -> u8 {
    let same = recording.channels.iter().filter(|c| c.id.board == channel.id.board);
    let last = same.map(|c| c.id.channel).max().unwrap_or(0);
    if channel.id.channel == 0 { last } else { channel.id.channel - 1 }
}

/// What drives the channel.
fn drive_of(rig: &Rig, channel: &Channel, controller: bool) -> Result<DriveInput, String> {
    let has_loop = rig.controller.is_some() && rig.sensor.is_some() && rig.supply.is_some();
    let drive = channel.drive.as_ref().filter(|_| !controller);
    Ok(match (drive, &channel.command_kpa) {
        (Some(Drive::Spool(u)), _) => DriveInput::Spool(to_f64(u)),
        (Some(Drive::Separate { fill, vent }), _) => {
            DriveInput::Separate { fill: to_f64(fill), vent: to_f64(vent) }
        }
        (None, Some(_)) if has_loop => DriveInput::Controlled,
        (None, Some(_)) if controller => {
            return Err(
                "the rig file has no [controller], [sensor] and [supply] to simulate the board's loop with"
                    .to_owned(),
            );
        }
        (None, Some(_)) => DriveInput::Command,
        (None, None) => {
            return Err(format!(
                "neither a drive ({}) nor a command ({}) is recorded",
                channel.id.drive_column(),
                channel.id.command_column()
            ));
        }
    })
}

/// Mean volume over every interval, and its rate.
fn volumes(recording: &Recording, rig: &Rig, channel: &Channel, common: &Common) -> (Series, Series) {
    let per_rad = rig.chamber.as_ref().map_or(0.0, |c| c.volume_per_rad_m3());
    let rest_m3 = common.rest_m3(rig);
    match recording.joint_angle(channel.id) {
        Some((angle, sign)) if per_rad > 0.0 => {
            let angle = to_f64(angle);
            let rows = angle.len();
            let at = |k: usize| angle[k.min(rows - 1)];
            let volume = |(k, rest): (usize, &f64)| {
                (rest + sign * per_rad * 0.5 * (at(k) + at(k + 1))).max(0.05 * rest)
            };
            let rate = |k: usize| sign * per_rad * (at(k + 1) - at(k)) / common.interval_s[k];
            (rest_m3.iter().enumerate().map(volume).collect(), (0..rows).map(rate).collect())
        }
        _ => (rest_m3, common.zeros.clone()),
    }
}
