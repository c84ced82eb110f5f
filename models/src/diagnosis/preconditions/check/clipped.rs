//! A sensor that stands at its highest value while the pressure goes on rising.

use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::DriveInput;

/// The command is above it by more than this part of the pressure's range, or the drive fills by
/// more than this.
const PUSHED: f64 = 0.05;
/// A verdict is of less than the whole recording, and says so, where more than this part of a
/// channel's readings is missing.
const MUCH: f64 = 0.1;

/// Rows at a limit of the sensor that no rig file tells: all at the highest reading, when it
/// repeats exactly while the channel is told to go higher.
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
    let share = missing_share(data);
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

/// Words for a verdict on channels of which much is missing; empty otherwise.
#[must_use]
pub fn much_missing<'a>(channels: impl IntoIterator<Item = &'a ChannelData>) -> String {
    let worst =
        channels.into_iter().map(|data| (missing_share(data), data.id)).max_by(|a, b| a.0.total_cmp(&b.0));
    match worst.filter(|(share, _)| *share > MUCH) {
        Some((share, id)) => format!(
            " Of the readings of {id}, {:.0} % are missing, stuck or at a limit of the sensor: what happens there is not in this verdict.",
            100.0 * share
        ),
        None => String::new(),
    }
}

fn missing_share(data: &ChannelData) -> f64 {
    let count = data.inputs.usable.iter().filter(|u| !**u).count();
    count as f64 / data.inputs.rows() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel_of;

    #[test]
    fn a_verdict_on_a_recording_with_a_third_lost_says_so() {
        let (whole, _) = channel_of(600, false);
        assert_eq!(much_missing([&whole]), "");
        let with_lost = |every: usize| {
            let mut data = whole.clone();
            data.inputs.usable = (0..600).map(|row| row % every != 0).collect();
            data
        };
        assert_eq!(much_missing([&with_lost(20)]), "");
        let text = much_missing([&whole, &with_lost(3)]);
        assert!(text.contains(&format!("readings of {}, 33 % are missing", whole.id)), "{text}");
    }
}
