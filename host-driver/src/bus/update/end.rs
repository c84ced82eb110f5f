//! The end of an update: from the commit until the board says which program it runs for good.
//!
//! What the board says decides what it is told next, so that it does not matter which request or
//! answer was lost, nor how many.

use super::{UpdateError, UpdateProgress, Updated};
use crate::bus::{Bus, ExchangeError, PageError};
use crate::line::Line;
use pneudrive_protocol::Address;
use pneudrive_protocol::pages::{Running, Update, UpdateOutcome, UpdateReply, UpdateState};

/// Flash takes 13 s at its worst for the longest program, usually one. The trial follows.
const WRITE_NS: u64 = 20_000_000_000;
/// From the new program's first answer until the board runs for good what it will: the trial, and a
/// start.
const TRIAL_NS: u64 = Update::TRIAL_S * 1_000_000_000 + 3_000_000_000;
/// Between two questions.
const ASK_AGAIN_NS: u64 = 10_000_000;

/// What is known so far.
struct End {
    /// What the board said before the update.
    before: UpdateState,
    /// Of the new program.
    crc: u32,
    /// The board has said that it has the commit.
    heard: bool,
    /// The new program has answered.
    tried: bool,
    /// It was told to stay, whether or not it has heard that.
    confirmed: bool,
    /// By then the board has said how it ends, or is lost.
    until_ns: u64,
}

impl<L: Line> Bus<L> {
    /// Commits what was sent, and confirms the program when it answers.
    pub(super) fn end_update(
        &mut self,
        board: u8,
        before: UpdateState,
        crc: u32,
        progress: &mut impl FnMut(UpdateProgress),
    ) -> Result<Updated, UpdateError> {
        let asked = Address::of_board(board);
        let until_ns = self.line.now_ns() + WRITE_NS + TRIAL_NS;
        let mut end = End { before, crc, heard: false, tried: false, confirmed: false, until_ns };
        loop {
            let last = match self.ask_how_it_ends(board, &mut end, progress) {
                Ok(Some(updated)) => return Ok(updated),
                Ok(None) => None,
                Err(UpdateError::Page(error)) => Some(error),
                Err(error) => return Err(error),
            };
            let has_failed = matches!(last, Some(PageError::Exchange(ExchangeError::Line(_))));
            if has_failed || self.line.now_ns() >= end.until_ns {
                return Err(UpdateError::Lost { asked, confirmed: end.confirmed, last });
            }
            self.line.sleep_until(self.line.now_ns() + ASK_AGAIN_NS);
        }
    }

    /// Asks the board where it is, and tells it what is next. `None`: it is to be asked again.
    fn ask_how_it_ends(
        &mut self,
        board: u8,
        end: &mut End,
        progress: &mut impl FnMut(UpdateProgress),
    ) -> Result<Option<Updated>, UpdateError> {
        let asked = Address::of_board(board);
        let state = self.update_state(board)?;
        if state.outcome == UpdateOutcome::Pending {
            end.heard = true;
            return Ok(None);
        }
        if state.running.is_trial() {
            return self.confirm(board, end, progress);
        }
        let is_kept = matches!(state.running, Running::First | Running::Second);
        if is_kept && self.running_crc(board)? == end.crc {
            self.has_restarted(board);
            return Ok(Some(Updated::Done));
        }
        match state.outcome {
            // What it says of an update before this one, it does not say of this one.
            outcome if outcome == end.before.outcome && !end.heard => {}
            UpdateOutcome::None | UpdateOutcome::Pending => {}
            UpdateOutcome::NotVented => return Err(UpdateError::NotVented { asked }),
            outcome => return Err(UpdateError::Refused { asked, outcome }),
        }
        let last_trial = state.last_trial;
        if end.heard || end.tried || last_trial != end.before.last_trial {
            self.has_restarted(board);
            return Err(UpdateError::RolledBack { asked, last_trial });
        }
        self.ping(board)?;
        match self.update(board, Update::Commit)?.reply {
            UpdateReply::Taken | UpdateReply::Busy => end.heard = true,
            // The command before the next one is the first of a session.
            UpdateReply::NeedsSession => {}
            reply => return Err(super::refusal(board, reply)),
        }
        Ok(None)
    }

    /// The new program answers. In a session with it, it hears commands, too.
    fn confirm(
        &mut self,
        board: u8,
        end: &mut End,
        progress: &mut impl FnMut(UpdateProgress),
    ) -> Result<Option<Updated>, UpdateError> {
        if !end.tried {
            self.has_restarted(board);
        }
        if self.running_crc(board)? != end.crc {
            return Err(UpdateError::OnTrial { asked: Address::of_board(board) });
        }
        if !end.tried {
            end.tried = true;
            end.until_ns = self.line.now_ns() + TRIAL_NS;
            progress(UpdateProgress::Confirming);
        }
        self.ping(board)?;
        if self.in_session(board) {
            end.confirmed = true;
            // Whatever it answers: what it does then, the next question tells.
            self.update(board, Update::Confirm)?;
        }
        Ok(None)
    }

    /// The board knows nothing of the session any more.
    fn has_restarted(&mut self, board: u8) {
        self.peers[usize::from(board)].session.end();
    }
}
