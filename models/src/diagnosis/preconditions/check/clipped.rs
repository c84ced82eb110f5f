//! A sensor that stands at its highest value while the pressure goes on rising.

use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::DriveInput;

/// The command is above it by more than this part of the pressure's range, or the drive fills by more than this.
const PUSHED: f64 = 0.05;

/// Rows at a limit of the sensor that no rig file tells: all at the highest reading, when it repeats exactly while the channel is told to
/// go higher.
#[must_use]
pub fn clipped_rows(
    drive: &DriveInput,
    command_pa: &[f64],
    measured_pa: &[f64],
    usable: &[bool],
) -> Vec<usize> {
    let used = || measured_pa.iter().zip(usable).filter(|(_, u)| **u).map(|(p, _)| *p);
    let (low, high) = used().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let pushed = |row: usize| match drive {
        DriveInput::Spool(u) => u[row] > PUSHED,
        DriveInput::Separate { fill, vent } => fill[row] - vent[row] > PUSHED,
        DriveInput::Controlled | DriveInput::Command => command_pa[row] - high > PUSHED * (high - low),
    };
    let at_top = |row: &usize| usable[*row] && measured_pa[*row].total_cmp(&high).is_eq();
    let rows: Vec<usize> = (0..measured_pa.len()).filter(at_top).collect();
    // A few rows at the highest reading are what every recording has.
    let told = rows.iter().filter(|row| pushed(**row)).count();
    if high > low && told as f64 > SETTINGS.clipped_share * measured_pa.len() as f64 {
        rows
    } else {
        Vec::new()
    }
}

/// Remarks on what cannot be compared.
///
/// # Errors
/// [`DiagnosisError::Unusable`] when that is more than half of a channel.
pub fn unusable(file: &str, data: &ChannelData) -> Result<Option<String>, DiagnosisError> {
    let count = data.inputs.usable.iter().filter(|u| !**u).count();
    let share = count as f64 / data.inputs.rows() as f64;
    if share > SETTINGS.clipped_most {
        return Err(DiagnosisError::Unusable {
            file: file.to_owned(),
            channel: data.id.to_string(),
            percent: 100.0 * share,
        });
    }
    Ok((share > 0.001).then(|| {
        format!(
            "{}: {:.1} % of the readings are missing, stuck or at a limit of the sensor; nothing is compared there, and what happens beyond the limit cannot be seen.",
            data.id,
            100.0 * share
        )
    }))
}
