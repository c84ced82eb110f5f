//! Data that cannot carry a diagnosis, said in a sentence before anything is fitted.

mod clipped;
mod statistics;
mod swapped;
mod units;

pub use clipped::clipped_rows;

use crate::diagnosis::channel::{ChannelData, Role, block_length_s};
use crate::diagnosis::error::DiagnosisError;
use crate::effects::DriveInput;
use clipped::unusable;
use statistics::deviation;
use swapped::swapped;
use units::units;

/// Blocks needed to fit, to choose and to test.
const WANTED: usize = 8;
/// Rows to compare without which a block is empty.
const LEAST_ROWS: usize = 5;
/// Smallest standard deviation of a drive that excites anything.
const DRIVE_MOVES: f64 = 0.01;
/// Smallest standard deviation of a command, Pa.
const COMMAND_MOVES_PA: f64 = 1000.0;
/// Slowest sampling from which valves and lags can be seen, Hz.
const SLOWEST_HZ: f64 = 10.0;

/// Refuses what cannot be diagnosed; returns remarks on what can.
///
/// # Errors
/// Too short, not moving, wrong units, or columns that belong to another channel.
pub fn check(file: &str, channels: &[ChannelData]) -> Result<Vec<String>, DiagnosisError> {
    for data in channels {
        let rate_hz = data.inputs.rows() as f64 / data.inputs.interval_s.iter().sum::<f64>();
        if rate_hz < SLOWEST_HZ {
            return Err(DiagnosisError::TooSlow { file: file.to_owned(), rate_hz, wanted_hz: SLOWEST_HZ });
        }
    }
    let mut notes = Vec::new();
    for data in channels {
        notes.extend(unusable(file, data)?);
    }
    // A block in which nothing is compared says nothing.
    let full = |d: &ChannelData, role: Option<Role>| {
        let blocks = d.blocks.iter().zip(&d.spans);
        blocks.filter(|(b, s)| s.len() >= LEAST_ROWS && role.is_none_or(|r| b.role == r)).count()
    };
    let fewest = channels.iter().map(|d| full(d, None)).min().unwrap_or(0);
    let tests = channels.iter().map(|d| full(d, Some(Role::Test))).min();
    if fewest < WANTED || tests.unwrap_or(0) < 2 {
        let seconds = channels.first().map_or(0.0, |d| d.inputs.duration_s);
        let block_s = block_length_s(seconds);
        return Err(DiagnosisError::TooShort {
            file: file.to_owned(),
            seconds,
            blocks: fewest,
            block_s,
            wanted: WANTED,
        });
    }
    let (mut still, mut what) = (Vec::new(), "the drive");
    for data in channels {
        let moves = match &data.inputs.drive {
            DriveInput::Spool(u) => deviation(u) > DRIVE_MOVES,
            DriveInput::Separate { fill, vent } => deviation(fill).max(deviation(vent)) > DRIVE_MOVES,
            DriveInput::Controlled | DriveInput::Command => {
                what = "the command";
                deviation(&data.inputs.command_pa) > COMMAND_MOVES_PA
            }
        };
        if !moves {
            still.push(data.id.to_string());
        }
    }
    if !still.is_empty() {
        return Err(DiagnosisError::NoExcitation { file: file.to_owned(), what, channels: still.join(", ") });
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
