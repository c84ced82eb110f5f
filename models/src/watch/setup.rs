//! A channel of a calibrated model, set up as a simulation of a recording with these columns would
//! be.

use super::sample::Columns;
use crate::data::{Channel, Drive, Flags, Joint, Recording, Source};
use crate::diagnosis::{
    ChannelData, DiagnosisError, Extended, ExtendedChannel, ExtendedFile, Purpose, prepare_for,
};

/// Rows enough to be a recording.
const ROWS: usize = 16;
/// Longest integration step, s. What it costs in exactness is the same all the time, and learnt
/// with the baseline.
const LONGEST_STEP_S: f64 = 0.005;
/// Longest step of the board's loop, s.
const LOOP_STEP_S: f64 = 0.0025;

/// Why a recording cannot be watched.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WatchError {
    /// The calibrated model, or what it lacks in the recording.
    #[error(transparent)]
    Model(#[from] DiagnosisError),
    /// None of the recording's channels is in the model.
    #[error(
        "none of the recording's channels ({recorded}) is in {file}, which holds {calibrated}; calibrate them with `fit`"
    )]
    NoChannel {
        /// The model's file.
        file: String,
        /// Channels of the recording.
        recorded: String,
        /// Channels of the model.
        calibrated: String,
    },
}

/// One channel: its plant and inputs as a template, and its calibrated model.
#[derive(Clone)]
pub struct Prepared {
    /// Plant, and inputs of a few rows.
    pub data: ChannelData,
    /// The model.
    pub model: Extended,
    /// Change of the volume per radian of its joint, m^3/rad, signed; 0 where the joint is not
    /// recorded.
    pub volume_per_rad_m3: f64,
}

/// Sets up a channel; `name` is the model file's, for messages.
pub fn prepare(
    (name, file): (&str, &ExtendedFile),
    stored: &ExtendedChannel,
    columns: Columns,
) -> Result<Prepared, WatchError> {
    let recording = template(columns);
    let purpose = Purpose::Simulate { start_kpa: 0.0, controller: false };
    let (mut channels, _) = prepare_for(&recording, &file.rig, purpose)?;
    let mut data = channels.remove(0);
    let model = file.models(name, std::slice::from_ref(&data))?.remove(0);
    data.plant.command_range_pa = 1e3 * stored.command_range_kpa;
    data.inputs.noise_pa = 1e3 * stored.noise_kpa;
    data.plant.longest_step_s = LONGEST_STEP_S;
    if let Some(board) = &mut data.plant.board {
        board.loops_per_step = whole(LOOP_STEP_S * board.rate_hz);
    }
    let sign = recording.joint_angle(columns.id).map_or(0.0, |(_, sign)| sign);
    let chamber = file.rig.at(columns.id).chamber;
    let volume_per_rad_m3 = sign * chamber.map_or(0.0, |chamber| chamber.volume_per_rad_m3());
    Ok(Prepared { data, model, volume_per_rad_m3 })
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a few loops
fn whole(loops: f64) -> usize {
    loops.floor().clamp(1.0, 1e3) as usize
}

/// A recording of nothing with these columns.
fn template(columns: Columns) -> Recording {
    let column = || vec![0.0_f32; ROWS];
    let drive = match columns {
        Columns { spool: true, .. } => Some(Drive::Spool(column())),
        Columns { separate: true, .. } => Some(Drive::Separate { fill: column(), vent: column() }),
        _ => None,
    };
    let channel = Channel {
        id: columns.id,
        command_kpa: columns.command.then(column),
        pressure_kpa: None,
        drive,
        flags: vec![Flags::NONE; ROWS],
    };
    let joint = Joint { board: columns.id.board, qu_rad: Some(column()), qv_rad: Some(column()) };
    Recording {
        source: Source { file: "recording".to_owned(), sha256: String::new(), bytes: 0 },
        time_s: (0..ROWS).map(|row| 0.01 * row as f64).collect(),
        line: (2..).take(ROWS).collect(),
        breaks: Vec::new(),
        period_s: 0.01,
        channels: vec![channel],
        joints: if columns.angle { vec![joint] } else { Vec::new() },
        supply_kpa: None,
        board_supplies: Vec::new(),
    }
}
