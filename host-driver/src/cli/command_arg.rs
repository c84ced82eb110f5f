//! `--command`: set points as text.

use pneudrive_host::poller::{BoardCommand, VENTED};
use pneudrive_protocol::{CHANNELS, SensorScale};
use std::str::FromStr;

/// One `--command`.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandArg {
    /// `None` for all boards.
    board: Option<usize>,
    command: BoardCommand,
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
        let values: Vec<_> = values
            .split(',')
            .map(|value| {
                let kpa: f64 =
                    value.trim().parse().map_err(|_| format!("\"{value}\" is no number of kPa"))?;
                SensorScale::ORIGINAL.counts(kpa).map_err(|error| error.to_string())
            })
            .collect::<Result<_, _>>()?;
        let command = match values[..] {
            [all] => [all; CHANNELS],
            _ => values.try_into().map_err(|values: Vec<_>| {
                format!("expected one pressure or {CHANNELS} separated by commas, got {}", values.len())
            })?,
        };
        Ok(Self { board, command })
    }
}

/// The commands of `devices` boards: 0 kPa, changed by each argument in turn.
pub fn commands(args: &[CommandArg], devices: usize) -> Result<Vec<BoardCommand>, String> {
    let mut commands = vec![VENTED; devices];
    for arg in args {
        match arg.board {
            None => commands.fill(arg.command),
            Some(board) => {
                *commands.get_mut(board).ok_or_else(|| {
                    format!(
                        "--command for board {board}, but --devices {devices} means boards 0 to {}",
                        devices - 1
                    )
                })? = arg.command;
            }
        }
    }
    Ok(commands)
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
        let all = commands(&args, 2).unwrap();
        assert_eq!(all, [counts([221; 4]), counts([102, 162, 221, 281])]);
        assert!(commands(&args, 1).unwrap_err().contains("board 1"));
    }

    #[test]
    fn what_cannot_be_commanded_is_named() {
        let refuse = |text: &str| text.parse::<CommandArg>().unwrap_err();
        assert!(refuse("NaN").contains("NaN"));
        assert!(refuse("-100").contains("-100 kPa"));
        assert!(refuse("776").contains("776 kPa"));
        assert!(refuse("1,2").contains("got 2"));
        assert!(refuse("x:1").contains("\"x\" is no board number"));
        assert!(refuse("1,2,,4").contains("\"\" is no number"));
    }
}
