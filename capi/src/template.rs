//! The channel of an extended model as a simulation of a recording sets it up: of a recording made for it.

use pneudrive_model::data::{Channel, ChannelId, Drive, Flags, Recording, Source};
use pneudrive_model::diagnosis::{ChannelData, ExtendedChannel, ExtendedFile, Purpose, prepare_for};

use crate::error::CreateError;
use crate::inputs::Control;

/// Rows enough to be a recording.
const ROWS: usize = 16;

/// Sets up a channel as it was calibrated, or under another control.
pub fn channel(
    file: &ExtendedFile,
    stored: &ExtendedChannel,
    id: ChannelId,
    control: Control,
) -> Result<ChannelData, CreateError> {
    let column = || vec![0.0_f32; ROWS];
    let set_point = match control {
        Control::AsCalibrated => matches!(stored.drive.as_str(), "board" | "command"),
        Control::SetPoint => true,
        Control::Drive => false,
    };
    let drive = match stored.drive.as_str() {
        _ if set_point => None,
        "separate" => Some(Drive::Separate { fill: column(), vent: column() }),
        _ => Some(Drive::Spool(column())),
    };
    let channel = Channel {
        id,
        command_kpa: Some(column()),
        pressure_kpa: None,
        drive,
        flags: vec![Flags::NONE; ROWS],
    };
    let recording = Recording {
        source: Source { file: "parameters".to_owned(), sha256: String::new(), bytes: 0 },
        time_s: (0..ROWS).map(|row| 0.01 * row as f64).collect(),
        line: (0..).take(ROWS).collect(),
        breaks: Vec::new(),
        period_s: 0.01,
        channels: vec![channel],
        joints: Vec::new(),
        // The caller says what it is.
        supply_kpa: Some(column()),
    };
    let controller = set_point && stored.drive != "command";
    let (mut channels, _) =
        prepare_for(&recording, &file.rig, Purpose::Simulate { start_kpa: 0.0, controller })?;
    Ok(channels.remove(0))
}
