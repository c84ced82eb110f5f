//! `--command`: set points as text.

use pneudrive_host::Calibration;
use pneudrive_host::poller::{BoardCommand, VENTED};
use pneudrive_protocol::{CHANNELS, SensorScale};
use std::str::FromStr;

/// One `--command`.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandArg {
    /// `None` for all boards.
    board: Option<usize>,
    /// kPa gauge, as given.
    kpa: [f64; CHANNELS],
}

impl FromStr for CommandArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (board, values) = match text.split_once(':') {
            Some((board, values)) => {
                let board = board.trim().parse().map_err(|_| format!("\"{board}\" is no board number"))?;
                (Some(board), values)
            }
            None => (None, text),
        };
        let values: Vec<f64> = values
            .split(',')
            .map(|value| value.trim().parse().map_err(|_| format!("\"{value}\" is no number of kPa")))
            .collect::<Result<_, _>>()?;
        let kpa = match values[..] {
            [all] => [all; CHANNELS],
            _ => values.try_into().map_err(|values: Vec<_>| {
                format!("expected one pressure or {CHANNELS} separated by commas, got {}", values.len())
            })?,
        };
        Ok(Self { board, kpa })
    }
}

/// The commands of `devices` boards: 0 kPa, changed by each argument in turn.
pub fn commands(
    args: &[CommandArg],
    devices: usize,
    calibration: &Calibration,
) -> Result<Vec<BoardCommand>, String> {
    let mut commands = vec![VENTED; devices];
    for arg in args {
        if let Some(board) = arg.board.filter(|&board| board >= devices) {
            let last = devices - 1;
            return Err(format!(
                "--command for board {board}, but --devices {devices} means boards 0 to {last}"
            ));
        }
        for (board, command) in commands.iter_mut().enumerate() {
            if arg.board.is_none_or(|only| only == board) {
                *command = arg.counts(calibration.of(u8::try_from(board).unwrap_or(u8::MAX)))?;
            }
        }
    }
    Ok(commands)
}

impl CommandArg {
    fn counts(&self, scales: [SensorScale; CHANNELS]) -> Result<BoardCommand, String> {
        let mut command = VENTED;
        for ((counts, scale), &kpa) in command.iter_mut().zip(scales).zip(&self.kpa) {
            *counts = scale.counts(kpa).map_err(|error| format!("--command: {error}"))?;
        }
        Ok(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_protocol::Counts;

    fn counts(values: [u16; 4]) -> BoardCommand {
        values.map(|value| Counts::new(value).unwrap())
    }

    #[test]
    fn later_arguments_change_earlier_ones() {
        let args: Vec<CommandArg> =
            ["100", "1:0,50,100,150"].iter().map(|text| text.parse().unwrap()).collect();
        let all = commands(&args, 2, &Calibration::default()).unwrap();
        assert_eq!(all, [counts([221; 4]), counts([102, 162, 221, 281])]);
        assert!(commands(&args, 1, &Calibration::default()).unwrap_err().contains("board 1"));
    }

    #[test]
    fn what_cannot_be_commanded_is_named() {
        let refuse = |text: &str| {
            let parsed = text.parse::<CommandArg>();
            parsed.and_then(|arg| commands(&[arg], 1, &Calibration::default())).unwrap_err()
        };
        assert!(refuse("NaN").contains("NaN"));
        assert!(refuse("-100").contains("-100 kPa"));
        assert!(refuse("776").contains("776 kPa"));
        assert!(refuse("1,2").contains("got 2"));
        assert!(refuse("x:1").contains("\"x\" is no board number"));
        assert!(refuse("1,2,,4").contains("\"\" is no number"));
    }
}
