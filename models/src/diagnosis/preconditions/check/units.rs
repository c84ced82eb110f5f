//! A pressure in another unit than its command.

use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::preconditions::check::gauge_pa;
use crate::diagnosis::preconditions::check::statistics::{correlation, deviation, mean};
use crate::diagnosis::settings::SETTINGS;

/// Pascals per pound per square inch over pascals per kilopascal.
const KPA_PER_PSI: f64 = 6.894_757;

/// A factor is recognised when the mean pressure over the mean command is within this part of it
/// ...
const NEAR: f64 = 0.25;
/// ... and the movements are in a ratio between these parts of it: a lag makes the pressure move
/// less.
const MOVES: [f64; 2] = [0.3, 1.5];

/// The command and the pressure of a controlled channel agree but for a unit.
///
/// # Errors
/// [`DiagnosisError::Units`] when they do not.
pub fn units(file: &str, data: &ChannelData) -> Result<(), DiagnosisError> {
    let (command, measured) =
        (gauge_pa(data, &data.inputs.command_pa), gauge_pa(data, &data.inputs.measured_pa));
    // Of a command in another unit, too, something must move.
    if deviation(&command) < 1e3 * SETTINGS.least_command_movement_kpa / 10.0
        || correlation(&command, &measured) < 0.3
    {
        return Ok(());
    }
    // A lag changes how far a pressure moves, and not its mean.
    let (means, moves) = (mean(&measured) / mean(&command), deviation(&measured) / deviation(&command));
    let factors = [
        (1.0 / KPA_PER_PSI, "psi", "kPa"),
        (KPA_PER_PSI, "kPa", "psi"),
        (0.01, "bar", "kPa"),
        (100.0, "kPa", "bar"),
    ];
    for (factor, found, meant) in factors {
        let moved = (MOVES[0]..=MOVES[1]).contains(&(moves / factor));
        if (means / factor - 1.0).abs() < NEAR && moved {
            return Err(DiagnosisError::Units {
                file: file.to_owned(),
                channel: data.id.to_string(),
                ratio: means,
                explanation: format!(
                    "the pressure column looks like {found} where the command is in {meant}"
                ),
            });
        }
    }
    Ok(())
}
