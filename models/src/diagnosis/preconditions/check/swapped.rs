//! A pressure that follows another channel's input, or its own the wrong way round.

use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::preconditions::check::statistics::{correlation, deviation};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::{DriveInput, Series};

/// Delays at which a pressure may follow, s.
const DELAYS_S: [f64; 6] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8];
/// Rows that are looked at, at most.
const MOST_ROWS: usize = 20_000;
/// Rows over which the rate of pressure is taken.
const RATE_ROWS: usize = 6;

/// Looks at every channel.
///
/// # Errors
/// [`DiagnosisError::Swapped`] or [`DiagnosisError::Reversed`].
pub fn swapped(file: &str, channels: &[ChannelData]) -> Result<(), DiagnosisError> {
    let commanded =
        channels.iter().all(|d| deviation(&d.inputs.command_pa) > 1e3 * SETTINGS.least_command_movement_kpa);
    let told: Vec<Series> = channels
        .iter()
        .map(|d| if commanded { d.inputs.command_pa.clone() } else { averaged(&drive(d)).into() })
        .collect();
    let seen: Vec<Series> = channels
        .iter()
        .map(|d| if commanded { d.inputs.measured_pa.clone() } else { rate(&d.inputs.measured_pa).into() })
        .collect();
    let (not_own, other) = if commanded {
        (SETTINGS.own_correlation, SETTINGS.other_correlation)
    } else {
        (SETTINGS.own_rate_correlation, SETTINGS.other_rate_correlation)
    };
    let period_s = channels.first().map_or(1.0, |d| d.inputs.duration_s / d.inputs.rows().max(1) as f64);
    for (k, data) in channels.iter().enumerate() {
        let own = following(&told[k], &seen[k], period_s);
        for j in (0..channels.len()).filter(|j| *j != k) {
            let theirs = following(&told[j], &seen[k], period_s);
            if own < not_own && theirs > other {
                return Err(DiagnosisError::Swapped {
                    file: file.to_owned(),
                    channel: data.id.to_string(),
                    other: channels[j].id.to_string(),
                    what: if commanded { "command" } else { "drive" },
                    own,
                    theirs,
                });
            }
        }
        if own < -other {
            let what = if commanded { "command" } else { "drive" };
            return Err(DiagnosisError::Reversed {
                file: file.to_owned(),
                channel: data.id.to_string(),
                what,
                correlation: own,
            });
        }
    }
    Ok(())
}

/// The largest correlation, in size, at any of the delays.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of rows
fn following(told: &[f64], seen: &[f64], period_s: f64) -> f64 {
    let stride = told.len().div_ceil(MOST_ROWS).max(1);
    let at = |delay_s: &f64| {
        let rows = ((delay_s / period_s).round() as usize).min(told.len() / 2);
        let early: Vec<f64> = told[..told.len() - rows].iter().step_by(stride).copied().collect();
        let late: Vec<f64> = seen[rows..].iter().step_by(stride).copied().collect();
        correlation(&early, &late)
    };
    DELAYS_S.iter().map(at).fold(0.0, |most: f64, c| if c.abs() > most.abs() { c } else { most })
}

/// Fill minus vent.
fn drive(data: &ChannelData) -> Series {
    match &data.inputs.drive {
        DriveInput::Spool(u) => u.clone(),
        DriveInput::Separate { fill, vent } => fill.iter().zip(vent.iter()).map(|(f, v)| f - v).collect(),
        DriveInput::Controlled | DriveInput::Command => data.inputs.command_pa.clone(),
    }
}

/// Change of the pressure over some rows.
fn rate(pressure: &[f64]) -> Vec<f64> {
    pressure.windows(RATE_ROWS + 1).map(|w| w[RATE_ROWS] - w[0]).collect()
}

/// Mean over the same rows.
fn averaged(drive: &[f64]) -> Vec<f64> {
    drive.windows(RATE_ROWS + 1).map(|w| w[..RATE_ROWS].iter().sum::<f64>() / RATE_ROWS as f64).collect()
}
