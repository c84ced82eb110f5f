//! Data that cannot carry a diagnosis, said in a sentence before anything is fitted.

use super::blocks::{Role, block_length_s};
use super::channel::ChannelData;
use super::error::DiagnosisError;
use crate::effects::DriveInput;

/// Blocks needed to fit, to choose and to test.
const WANTED: usize = 8;
/// Smallest standard deviation of a drive that excites anything.
const DRIVE_MOVES: f64 = 0.01;
/// Smallest standard deviation of a command, Pa.
const COMMAND_MOVES_PA: f64 = 1000.0;
/// Pascals per pound per square inch over pascals per kilopascal.
const KPA_PER_PSI: f64 = 6.894_757;

/// Refuses what cannot be diagnosed; returns remarks on what can.
///
/// # Errors
/// Too short, not moving, wrong units, or columns that belong to another channel.
pub fn check(file: &str, channels: &[ChannelData]) -> Result<Vec<String>, DiagnosisError> {
    let fewest = channels.iter().map(|d| d.blocks.len()).min().unwrap_or(0);
    let tests = channels.iter().map(|d| d.blocks.iter().filter(|b| b.role == Role::Test).count()).min();
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
    let mut notes = Vec::new();
    for data in channels {
        let clipped = data.inputs.usable.iter().filter(|u| !**u).count();
        let share = clipped as f64 / data.inputs.rows() as f64;
        if share > 0.001 {
            notes.push(format!(
                "{}: {:.1} % of the readings are missing, stuck or at a limit of the sensor; nothing is compared there, and what happens beyond the limit cannot be seen.",
                data.id,
                100.0 * share
            ));
        }
        let over =
            data.inputs.measured_pa.iter().zip(&data.inputs.supply_pa).filter(|(p, s)| *p > &(*s * 1.05));
        if !matches!(data.inputs.drive, DriveInput::Command) && over.count() * 100 > data.inputs.rows() {
            notes.push(format!(
                "{}: the measured pressure is above the supply pressure of the rig file; check the supply pressure and the unit of the pressure column.",
                data.id
            ));
        }
    }
    Ok(notes)
}

/// The command and the pressure of a controlled channel agree but for a unit.
fn units(file: &str, data: &ChannelData) -> Result<(), DiagnosisError> {
    let gauge = |x: &[f64]| x.iter().map(|p| p - data.inputs.ambient_pa).collect::<Vec<f64>>();
    let (command, measured) = (gauge(&data.inputs.command_pa), gauge(&data.inputs.measured_pa));
    if deviation(&command) < COMMAND_MOVES_PA {
        return Ok(());
    }
    let (ratio, correlation) = (deviation(&measured) / deviation(&command), correlation(&command, &measured));
    for (factor, found, meant) in
        [(1.0 / KPA_PER_PSI, "psi", "kPa"), (KPA_PER_PSI, "kPa", "psi"), (0.01, "bar", "kPa")]
    {
        if correlation > 0.6 && (ratio / factor - 1.0).abs() < 0.15 {
            return Err(DiagnosisError::Units {
                file: file.to_owned(),
                channel: data.id.to_string(),
                ratio,
                explanation: format!(
                    "the pressure column looks like {found} where the command is in {meant}"
                ),
            });
        }
    }
    Ok(())
}

/// A pressure that follows another channel's command.
fn swapped(file: &str, channels: &[ChannelData]) -> Result<(), DiagnosisError> {
    for (k, data) in channels.iter().enumerate() {
        let command = |d: &ChannelData| d.inputs.command_pa.clone();
        if deviation(&command(data)) < COMMAND_MOVES_PA {
            continue;
        }
        let own = correlation(&command(data), &data.inputs.measured_pa);
        for (other_index, other) in channels.iter().enumerate() {
            if other_index == k || deviation(&command(other)) < COMMAND_MOVES_PA {
                continue;
            }
            let theirs = correlation(&command(other), &data.inputs.measured_pa);
            if own < 0.4 && theirs > 0.8 {
                return Err(DiagnosisError::Swapped {
                    file: file.to_owned(),
                    channel: data.id.to_string(),
                    other: other.id.to_string(),
                    own,
                    theirs,
                });
            }
        }
    }
    Ok(())
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

fn deviation(x: &[f64]) -> f64 {
    let m = mean(x);
    (x.iter().map(|v| (v - m) * (v - m)).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (ma, mb) = (mean(a), mean(b));
    let product: f64 = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum();
    product / (a.len().max(1) as f64 * deviation(a) * deviation(b)).max(1e-300)
}
