//! How a run of a poller ended, and what is to be said of it.

use crate::bus::{BoardFormat, Bus};
use crate::line::{Line, LineError};
use crate::statistics::Statistics;

/// How a poller ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished {
    /// What the run was like.
    pub statistics: Statistics,
    /// Why it ended, if the line failed; otherwise it was stopped, or its commands ended.
    pub error: Option<LineError>,
    /// Boards that did not confirm the final 0 kPa command. Those that check vent by their own
    /// command timeout; those of the original kind have none and may stay under pressure: see
    /// [`conclusion`](Self::conclusion).
    pub not_safe: Vec<u8>,
    /// Those of them that never gave an answer that was accepted, so most likely nobody is there.
    /// Bytes that were refused can be another board's.
    pub never_heard: Vec<u8>,
    /// Those of these that were sent more than 0 kPa all the same.
    pub commanded_unheard: Vec<u8>,
}

/// What is to be said of how a run ended.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Conclusion {
    /// Why it has failed: the line, then boards that may be under pressure. Empty if it has not.
    pub failures: Vec<String>,
    /// What is no failure: boards that never answered and never had a reason to be under pressure.
    pub remark: Option<String>,
}

impl Finished {
    pub(super) fn new(mut statistics: Statistics, error: Option<LineError>, not_safe: Vec<u8>) -> Self {
        for board in &mut statistics.boards {
            board.zero_kpa_confirmed = Some(!not_safe.contains(&board.board));
        }
        Self { statistics, error, not_safe, never_heard: Vec::new(), commanded_unheard: Vec::new() }
    }

    pub(super) fn with_unheard<L: Line>(mut self, bus: &Bus<L>) -> Self {
        let unheard = self.not_safe.iter().copied().filter(|&board| !bus.was_seen(board));
        self.never_heard = unheard.collect();
        let commanded = self.never_heard.iter().copied().filter(|&board| bus.may_hold_for_ever(board));
        self.commanded_unheard = commanded.collect();
        self
    }

    /// What a user has to know: whether it failed, which boards did not confirm 0 kPa, and what
    /// becomes of them.
    pub fn conclusion(&self) -> Conclusion {
        self.conclusion_of("board(s)", |board| board.to_string())
    }

    /// The same for users who know the boards as something else (`noun`), by other names.
    pub fn conclusion_of(&self, noun: &str, name: impl Fn(u8) -> String) -> Conclusion {
        let list = |boards: &[u8]| boards.iter().map(|&board| name(board)).collect::<Vec<_>>().join(", ");
        let mut failures: Vec<String> = self.error.iter().map(ToString::to_string).collect();
        failures.extend(self.unconfirmed(noun, list));
        let absent = match self.never_heard.as_slice() {
            [] => None,
            boards => Some(format!("{noun} {} never answered", list(boards))),
        };
        let Some(absent) = absent else { return Conclusion { failures, remark: None } };
        if self.commanded_unheard.is_empty() {
            let remark = Some(format!("{absent}; are there fewer boards than --devices says?"));
            return Conclusion { failures, remark };
        }
        failures.push(format!(
            "{absent}; set points were sent to {noun} {} all the same: if there is a board of the original kind that hears and \
             cannot answer, it may be under pressure: shut off the air supply before you touch it, and poll only boards that \
             are there (--devices)",
            list(&self.commanded_unheard)
        ));
        Conclusion { failures, remark: None }
    }

    /// What becomes of the boards that have answered before and did not confirm.
    fn unconfirmed(&self, noun: &str, list: impl Fn(&[u8]) -> String) -> Option<String> {
        let checks = |board: &u8| {
            let boards = &self.statistics.boards;
            boards.iter().any(|one| one.board == *board && one.frames == BoardFormat::Checked)
        };
        let heard = self.not_safe.iter().filter(|board| !self.never_heard.contains(board));
        let (checked, others): (Vec<u8>, Vec<u8>) = heard.partition(|board| checks(board));
        let mut texts = Vec::new();
        if !others.is_empty() {
            texts.push(format!(
                "0 kPa was not confirmed by {noun} {}; boards of the original kind have no command timeout and may stay under \
                 pressure; shut off the air supply or their power before anybody touches the robot",
                list(&others)
            ));
        }
        if !checked.is_empty() {
            texts.push(format!(
                "0 kPa was not confirmed by {noun} {}; they vent by their own command timeout",
                list(&checked)
            ));
        }
        (!texts.is_empty()).then(|| texts.join(". "))
    }
}
