//! The channel of an extended model without a recording: set up as a simulation of one would.

use crate::data::{Channel, ChannelId, Drive, Flags, Recording, Source};

use super::channel::ChannelData;
use super::error::DiagnosisError;
use super::preconditions::{Purpose, prepare_for};
use super::report::ExtendedFile;

/// Rows enough to be a recording.
const ROWS: usize = 16;
const PERIOD_S: f64 = 0.01;
const PA_PER_KPA: f64 = 1e3;

impl ExtendedFile {
    /// A channel whose inputs say how it is driven, and nothing else: they are a few rows at rest.
    /// It is driven by set points or by its valve's drive as `set_point` says, or else as it was
    /// calibrated. `name` is the file's, for messages.
    ///
    /// # Errors
    /// [`DiagnosisError`] when the file has no such channel, or its rig lacks what the drive needs.
    pub fn template(
        &self,
        name: &str,
        id: ChannelId,
        set_point: Option<bool>,
    ) -> Result<ChannelData, DiagnosisError> {
        let problem = |problem: String| DiagnosisError::Reference { file: name.to_owned(), problem };
        let stored = self.channels.get(&id.to_string()).ok_or_else(|| {
            let known: Vec<&str> = self.channels.keys().map(String::as_str).collect();
            problem(format!("no channel {id}; it holds {}", known.join(", ")))
        })?;
        let column = || vec![0.0_f32; ROWS];
        let regulator = stored.drive == "command";
        let set_point = set_point.unwrap_or(regulator || stored.drive == "board");
        let drive = match stored.drive.as_str() {
            _ if set_point => None,
            "command" => {
                return Err(problem(format!("{id} is a regulator: it follows a set point and has no drive")));
            }
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
            source: Source { file: name.to_owned(), sha256: String::new(), bytes: 0 },
            time_s: (0..ROWS).map(|row| PERIOD_S * row as f64).collect(),
            line: (0..).take(ROWS).collect(),
            breaks: Vec::new(),
            period_s: PERIOD_S,
            channels: vec![channel],
            joints: Vec::new(),
            // The caller says what it is.
            supply_kpa: Some(column()),
            board_supplies: Vec::new(),
        };
        let purpose = Purpose::Simulate { start_kpa: 0.0, controller: set_point && !regulator };
        let (mut channels, _) = prepare_for(&recording, &self.rig, purpose)?;
        let mut data = channels.remove(0);
        data.plant.command_range_pa = PA_PER_KPA * stored.command_range_kpa;
        data.inputs.noise_pa = PA_PER_KPA * stored.noise_kpa;
        Ok(data)
    }
}
