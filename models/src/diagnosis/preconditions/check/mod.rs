//! Data that cannot carry a diagnosis, said in a sentence before anything is fitted.

mod clipped;
mod restless;
mod statistics;
mod swapped;
mod units;

pub use clipped::{clipped_rows, much_missing};

use crate::diagnosis::channel::{ChannelData, Role, block_length_s};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::DriveInput;
use clipped::unusable;
use restless::restless;
use statistics::deviation;
use swapped::swapped;
use units::units;

/// Rows to compare without which a block is empty.
const LEAST_ROWS: usize = 5;

/// What is taken for granted where neither recording nor rig file says how the pressure is made.
pub const AS_REGULATORS: &str = "No drive is recorded and the rig file (--rig) has no [controller], or there is none: channels are taken for pressure regulators.";

/// Refuses what cannot be diagnosed; returns remarks on what can.
///
/// # Errors
/// Too short, not moving, wrong units, or columns that belong to another channel.
pub fn check(file: &str, channels: &[ChannelData]) -> Result<Vec<String>, DiagnosisError> {
    for data in channels {
        let rate_hz = data.inputs.rows() as f64 / data.inputs.interval_s.iter().sum::<f64>();
        if rate_hz < SETTINGS.slowest_hz {
            return Err(DiagnosisError::TooSlow {
                file: file.to_owned(),
                rate_hz,
                wanted_hz: SETTINGS.slowest_hz,
            });
        }
    }
    let mut notes = Vec::new();
    if channels.iter().any(|data| matches!(data.inputs.drive, DriveInput::Command)) {
        notes.push(AS_REGULATORS.to_owned());
    }
    for data in channels {
        notes.extend(unusable(file, data)?);
        notes.extend(restless(data));
    }
    // A block in which nothing is compared says nothing.
    let full = |d: &ChannelData, role: Option<Role>| {
        let blocks = d.blocks.iter().zip(&d.spans);
        blocks.filter(|(b, s)| s.len() >= LEAST_ROWS && role.is_none_or(|r| b.role == r)).count()
    };
    let fewest = channels.iter().map(|d| full(d, None)).min().unwrap_or(0);
    let tests = channels.iter().map(|d| full(d, Some(Role::Test))).min();
    if fewest < usize::from(SETTINGS.least_blocks) || tests.unwrap_or(0) < 2 {
        let seconds = channels.first().map_or(0.0, |d| d.inputs.duration_s);
        let block_s = block_length_s(seconds);
        return Err(DiagnosisError::TooShort {
            file: file.to_owned(),
            seconds,
            blocks: fewest,
            block_s,
            wanted: usize::from(SETTINGS.least_blocks),
        });
    }
    let (mut still, mut moving, mut what) = (Vec::new(), Vec::new(), "the drive");
    for data in channels {
        let moves = match &data.inputs.drive {
            DriveInput::Spool(u) => deviation(u) > SETTINGS.least_drive_movement,
            DriveInput::Separate { fill, vent } => {
                deviation(fill).max(deviation(vent)) > SETTINGS.least_drive_movement
            }
            DriveInput::Controlled | DriveInput::Command => {
                what = "the command";
                deviation(&data.inputs.command_pa) > 1e3 * SETTINGS.least_command_movement_kpa
            }
        };
        if moves {
            moving.push(data.id);
        } else {
            still.push(data.id.to_string());
        }
    }
    if !still.is_empty() {
        let channels = still.join(", ");
        return Err(DiagnosisError::NoExcitation { file: file.to_owned(), what, channels, moving });
    }
    for data in channels {
        units(file, data)?;
    }
    swapped(file, channels)?;
    for data in channels {
        let over = data
            .inputs
            .measured_pa
            .iter()
            .zip(data.inputs.supply_pa.iter())
            .filter(|(p, s)| *p > &(*s * 1.05));
        if !matches!(data.inputs.drive, DriveInput::Command) && over.count() * 100 > data.inputs.rows() {
            notes.push(format!(
                "{}: the measured pressure is above the supply pressure of the rig file; check the supply pressure and the unit of the pressure column.",
                data.id
            ));
        }
    }
    Ok(notes)
}

/// Gauge pressures, Pa.
fn gauge_pa(data: &ChannelData, pressures: &[f64]) -> Vec<f64> {
    pressures.iter().map(|p| p - data.inputs.ambient_pa).collect()
}
