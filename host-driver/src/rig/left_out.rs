//! Boards that a rig file describes and nobody polls: their limits would hold for nothing, without
//! a word.

use pneudrive_protocol::CHANNELS;
use pneudrive_rig::Rig;
use thiserror::Error;

/// A board that a rig file describes and that is not among those of the bus.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "{file}:{line}: [boards.{board}] {}, but {said} means {}; boards are numbered from 0",
    if *limits { "has limits" } else { "is described" },
    polled(*boards)
)]
pub struct LeftOut {
    /// The file.
    pub file: String,
    /// The line of the board's table.
    pub line: usize,
    /// The board: the first that is left out with limits, or else the first that is.
    pub board: u8,
    /// Whether it has limits.
    pub limits: bool,
    /// What says how many boards there are.
    pub said: String,
    /// How many.
    pub boards: u16,
}

/// What `rig` says of boards that are not polled. `given` are the boards of the bus and where their
/// number was said, if it was said beside the file: who does so may leave some out, and is to be
/// told where those have limits.
///
/// # Errors
/// The file describes a board that its own number of boards excludes, or more than board 0 where
/// nobody says how many there are.
pub fn left_out(rig: &Rig, given: Option<(u16, &str)>) -> Result<Option<LeftOut>, LeftOut> {
    match (given, rig.bus().boards) {
        (Some((boards, said)), _) => Ok(first(rig, boards, said).filter(|left_out| left_out.limits)),
        (None, Some(boards)) => first(rig, boards, &format!("[bus] boards = {boards}")).map_or(Ok(None), Err),
        (None, None) => first(rig, 1, "no [bus] boards").map_or(Ok(None), Err),
    }
}

fn first(rig: &Rig, boards: u16, said: &str) -> Option<LeftOut> {
    let limited = |board: &u8| {
        let of_channel = |channel| rig.line(&format!("boards.{board}.channels.{channel}.limits")).is_some();
        rig.line(&format!("boards.{board}.limits")).is_some() || (0..CHANNELS).any(of_channel)
    };
    let out: Vec<u8> = rig.boards().into_iter().filter(|&board| u16::from(board) >= boards).collect();
    let board = out.iter().copied().find(limited).or(out.first().copied())?;
    Some(LeftOut {
        file: rig.file().to_owned(),
        line: rig.line(&format!("boards.{board}")).unwrap_or(1),
        board,
        limits: limited(&board),
        said: said.to_owned(),
        boards,
    })
}

fn polled(boards: u16) -> String {
    match boards {
        0 | 1 => "board 0 alone".to_owned(),
        _ => format!("boards 0 to {}", boards - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITED: &str = "[boards.2]\nname = \"arm\"\n[boards.3.channels.1.limits]\nmax_kpa = 50.0\n";

    fn found(bus: &str, given: Option<(u16, &str)>) -> Result<Option<LeftOut>, String> {
        let rig = Rig::parse("rig.toml", &format!("{bus}\n{LIMITED}")).unwrap();
        left_out(&rig, given).map_err(|refused| refused.to_string())
    }

    #[test]
    fn a_file_that_contradicts_itself_is_refused() {
        let refused = |bus| found(bus, None).unwrap_err();
        assert_eq!(
            refused("bus.boards = 1"),
            "rig.toml:4: [boards.3] has limits, but [bus] boards = 1 means board 0 alone; boards are numbered from 0"
        );
        assert!(refused("bus.boards = 3").contains("[bus] boards = 3 means boards 0 to 2"));
        assert!(refused("").contains("[boards.3] has limits, but no [bus] boards means board 0 alone"));
        assert_eq!(found("bus.boards = 4", None), Ok(None));
        let named = Rig::parse("rig.toml", "bus.boards = 1\nboards.1.name = \"arm\"").unwrap();
        assert!(left_out(&named, None).unwrap_err().to_string().contains("[boards.1] is described, but"));
    }

    #[test]
    fn who_narrows_on_purpose_is_told_of_limits_alone() {
        let told = found("bus.boards = 4", Some((3, "--devices 3"))).unwrap().unwrap();
        assert!(told.to_string().contains("[boards.3] has limits, but --devices 3 means boards 0 to 2"));
        assert_eq!(found("bus.boards = 1", Some((4, "--devices 4"))), Ok(None));
        let named = Rig::parse("rig.toml", "boards.1.name = \"arm\"").unwrap();
        assert_eq!(left_out(&named, Some((1, "--devices 1"))), Ok(None));
    }
}
