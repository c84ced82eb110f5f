//! More boards than their address switches can tell apart.

use pneudrive_rig::Rig;
use thiserror::Error;

/// A rig file has more boards than are accepted.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "{file}:{line}: [bus] boards = {boards}: must be 1 to {most}; boards with more than a two-way address switch need {option}"
)]
pub struct TooMany {
    /// The file.
    pub file: String,
    /// The line of the number.
    pub line: usize,
    /// The number.
    pub boards: u16,
    /// How many are accepted.
    pub most: u16,
    /// What accepts more.
    pub option: String,
}

/// Checks the number of boards that `rig` says. With a mistyped number, addresses without a board
/// are polled, which takes longer than polling all boards that are there. So more than `most`
/// boards need `option`.
///
/// # Errors
/// There are more.
pub fn few_enough(rig: &Rig, most: u16, option: &str) -> Result<(), TooMany> {
    match rig.bus().boards {
        Some(boards) if boards > most => Err(TooMany {
            file: rig.file().to_owned(),
            line: rig.line("bus.boards").unwrap_or(1),
            boards,
            most,
            option: option.to_owned(),
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_boards_than_switches_tell_apart_have_to_be_asked_for() {
        let rig = Rig::parse("rig.toml", "[bus]\nboards = 40\n").unwrap();
        assert_eq!(
            few_enough(&rig, 4, "--max-devices").unwrap_err().to_string(),
            "rig.toml:2: [bus] boards = 40: must be 1 to 4; boards with more than a two-way address switch need --max-devices"
        );
        assert_eq!(few_enough(&rig, 40, "--max-devices"), Ok(()));
        assert_eq!(few_enough(&Rig::parse("rig.toml", "").unwrap(), 4, "--max-devices"), Ok(()));
    }
}
