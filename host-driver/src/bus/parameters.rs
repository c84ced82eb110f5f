//! A board's parameters: read by pages, and changed as a whole in a session.

use super::{Bus, ExchangeError, PageError};
use crate::line::{Line, LineError};
use pneudrive_protocol::Address;
use pneudrive_protocol::pages::{
    Change, ChangeAnswer, CommitOutcome, PageEntry, Parameter, StoreState, number_in,
};
use thiserror::Error;

/// Parameters that could not be changed. The board goes on with those it had, except where
/// [`Lost`](Self::Lost) says otherwise.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// It could not be asked.
    #[error(transparent)]
    Page(#[from] PageError),
    /// It gives no session, without which it changes nothing.
    #[error("{asked}: it gives this host no session, in which alone parameters are changed")]
    NoSession {
        /// The board that was asked.
        asked: Address,
    },
    /// The address that it was to have is taken.
    #[error("{asked}: board {wanted} is on the bus already")]
    AddressTaken {
        /// The board that was asked.
        asked: Address,
        /// The number that it was to have.
        wanted: u8,
    },
    /// Its chambers have pressure.
    #[error(
        "{asked}: refused, because a chamber has more than 17 kPa; it is commanded 0 kPa, try again when it has vented"
    )]
    NotVented {
        /// The board that was asked.
        asked: Address,
    },
    /// A value is outside its range, or does not go together with others.
    #[error("{asked}: refused: {} is outside its range ({} to {}) or does not go together with the others (sensor_min - sensor_margin >= 1, sensor_max + sensor_margin <= 1022)", .parameter.info().name, .parameter.info().min, .parameter.info().max)]
    Refused {
        /// The board that was asked.
        asked: Address,
        /// The parameter.
        parameter: Parameter,
    },
    /// It goes on with the parameters that it had.
    #[error(
        "{asked}: it goes on with the parameters that it had: the request was lost, or its flash could not be written; try again"
    )]
    NotKept {
        /// The board that was asked.
        asked: Address,
    },
    /// It took the change, and did not come back in time.
    #[error(
        "{asked}: it took the change and does not answer any more; `list --scan --max-devices 256` finds it at another address"
    )]
    Lost {
        /// The board that was asked.
        asked: Address,
    },
}

impl From<ExchangeError> for ParameterError {
    fn from(error: ExchangeError) -> Self {
        Self::Page(error.into())
    }
}

impl From<LineError> for ParameterError {
    fn from(error: LineError) -> Self {
        Self::Page(error.into())
    }
}

/// What a change of parameters has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterChange {
    /// They were so already; nothing was written.
    Unchanged,
    /// They are kept and in effect; the board restarted.
    InEffect {
        /// Its number now.
        board: u8,
    },
    /// The board has taken the change and has gone back to the address of its switch, which the
    /// host does not know.
    AtSwitchAddress,
}

/// From which values a change starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangeFrom {
    /// Those in effect.
    InEffect,
    /// Those that the firmware was compiled with.
    Compiled,
}

/// A request that is lost is sent again so often.
const TRIES: u32 = 5;
/// From a commit to the answer after the restart: half a second for flash at its slowest, 0.2 s for
/// the start, and as much again.
const RESTART_NS: u64 = 3_000_000_000;
/// Between two questions whether it is there again.
const ASK_AGAIN_NS: u64 = 10_000_000;

impl<L: Line> Bus<L> {
    /// The value of a parameter that is in effect at `board`, in the unit of [`Parameter::info`].
    ///
    /// # Errors
    /// As for [`page`](Self::page); [`PageError::NoSuchEntry`] from firmware of before parameters.
    pub fn parameter(&mut self, board: u8, parameter: Parameter) -> Result<u32, PageError> {
        self.page_number(board, PageEntry::Parameter(parameter))
    }

    /// The value of a parameter that `board`'s firmware was compiled with.
    ///
    /// # Errors
    /// As for [`parameter`](Self::parameter).
    pub fn compiled_parameter(&mut self, board: u8, parameter: Parameter) -> Result<u32, PageError> {
        self.page_number(board, PageEntry::Compiled(parameter))
    }

    /// Where `board`'s parameters come from, and what became of the last change.
    ///
    /// # Errors
    /// As for [`parameter`](Self::parameter).
    pub fn parameter_store(&mut self, board: u8) -> Result<StoreState, PageError> {
        let words = self.page(board, PageEntry::Store)?.words;
        StoreState::from_entry(words)
            .ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry: PageEntry::Store })
    }

    fn page_number(&mut self, board: u8, entry: PageEntry) -> Result<u32, PageError> {
        let words = self.page(board, entry)?.words;
        number_in(words).ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry })
    }

    /// Changes parameters of `board`, all or none, and waits until it has restarted with them: a
    /// fifth of a second, and its power-up vent follows. Commands 0 kPa; the board must be vented.
    ///
    /// # Errors
    /// Why nothing was changed, or [`ParameterError::Lost`].
    pub fn change_parameters(
        &mut self,
        board: u8,
        from: ChangeFrom,
        changes: &[(Parameter, u32)],
    ) -> Result<ParameterChange, ParameterError> {
        let asked = Address::of_board(board);
        self.ping_again(board)?;
        if !self.in_session(board) {
            return Err(ParameterError::NoSession { asked });
        }
        let before = again(|| self.parameter_store(board))?;
        let wanted = self.wanted_address(board, from, changes)?;
        let begin = match from {
            ChangeFrom::InEffect => Change::Begin,
            ChangeFrom::Compiled => Change::BeginFromDefaults,
        };
        let sets = changes.iter().map(|&(parameter, value)| Change::Set(parameter, value));
        for change in std::iter::once(begin).chain(sets) {
            self.collect(board, change)?;
        }
        if let Some(outcome) = self.commit(board, &before)? {
            return match outcome {
                CommitOutcome::NotVented => Err(ParameterError::NotVented { asked }),
                CommitOutcome::Refused(parameter) => Err(ParameterError::Refused { asked, parameter }),
                CommitOutcome::Unchanged => Ok(ParameterChange::Unchanged),
                CommitOutcome::None | CommitOutcome::Pending => Err(ParameterError::NotKept { asked }),
            };
        }
        self.peers[usize::from(board)].session.end();
        let Some(new) = wanted else { return Ok(ParameterChange::AtSwitchAddress) };
        let after = self.wait_for_restart(new).ok_or(ParameterError::Lost { asked })?;
        if after.record == before.record {
            return Err(ParameterError::NotKept { asked });
        }
        Ok(ParameterChange::InEffect { board: new })
    }

    /// 0 kPa, until it is answered.
    pub(super) fn ping_again(&mut self, board: u8) -> Result<(), ExchangeError> {
        let mut result = self.ping(board);
        for _ in 1..TRIES {
            if matches!(result, Ok(_) | Err(ExchangeError::Line(_))) {
                break;
            }
            result = self.ping(board);
        }
        result.map(drop)
    }

    /// The number that the board will have; `None` if its switch says it and the host does not know
    /// the switch.
    fn wanted_address(
        &mut self,
        board: u8,
        from: ChangeFrom,
        changes: &[(Parameter, u32)],
    ) -> Result<Option<u8>, ParameterError> {
        let in_effect = again(|| self.parameter(board, Parameter::Address))?;
        let base = match from {
            ChangeFrom::InEffect => in_effect,
            ChangeFrom::Compiled => Parameter::BY_SWITCH,
        };
        let set = changes.iter().rev().find(|(parameter, _)| *parameter == Parameter::Address);
        let value = set.map_or(base, |(_, value)| *value);
        let Ok(wanted) = u8::try_from(value) else {
            return Ok((in_effect == Parameter::BY_SWITCH).then_some(board));
        };
        if wanted != board && self.is_taken(wanted) {
            return Err(ParameterError::AddressTaken { asked: Address::of_board(board), wanted });
        }
        Ok(Some(wanted))
    }

    /// Whether anything answers at this address.
    fn is_taken(&mut self, board: u8) -> bool {
        (0..TRIES)
            .any(|_| !matches!(self.about(board), Err(PageError::Exchange(ExchangeError::NoAnswer { .. }))))
    }

    /// A change that can be sent twice. The commands between keep the session.
    fn collect(&mut self, board: u8, change: Change) -> Result<(), ParameterError> {
        let asked = Address::of_board(board);
        for _ in 0..TRIES {
            self.ping_again(board)?;
            match self.change(board, change) {
                Ok(ChangeAnswer::Taken) => return Ok(()),
                Ok(ChangeAnswer::NeedsSession) | Err(PageError::Exchange(_)) => {}
                Ok(ChangeAnswer::Busy | ChangeAnswer::NotBegun) => break,
                Err(error) => return Err(error.into()),
            }
        }
        Err(ParameterError::NoSession { asked })
    }

    fn change(&mut self, board: u8, change: Change) -> Result<ChangeAnswer, PageError> {
        let entry = PageEntry::Change(change);
        let words = self.page(board, entry)?.words;
        ChangeAnswer::from_entry(words)
            .ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry })
    }

    /// Commits what was collected. `None` if the board restarts.
    fn commit(&mut self, board: u8, before: &StoreState) -> Result<Option<CommitOutcome>, ParameterError> {
        self.ping_again(board)?;
        let until_ns = self.line.now_ns() + RESTART_NS;
        let mut taken = false;
        while self.line.now_ns() < until_ns {
            // What is lost is sent again until it is known to have arrived: then it is answered
            // with Busy or NotBegun.
            if !taken {
                match self.change(board, Change::Commit) {
                    Ok(ChangeAnswer::NeedsSession) => {
                        return Err(ParameterError::NoSession { asked: Address::of_board(board) });
                    }
                    Ok(_) => taken = true,
                    Err(PageError::Exchange(ExchangeError::NoAnswer { .. })) => return Ok(None),
                    Err(PageError::Exchange(error)) if error.something_came() => continue,
                    Err(error) => return Err(error.into()),
                }
            }
            match self.parameter_store(board) {
                Ok(state) if state.record != before.record => return Ok(None),
                Ok(state) if state.outcome != CommitOutcome::Pending => return Ok(Some(state.outcome)),
                Ok(_) => self.line.sleep_until(self.line.now_ns() + ASK_AGAIN_NS / 10),
                Err(PageError::Exchange(ExchangeError::NoAnswer { .. })) => return Ok(None),
                Err(PageError::Exchange(error)) if error.something_came() => {}
                Err(error) => return Err(error.into()),
            }
        }
        Err(ParameterError::Lost { asked: Address::of_board(board) })
    }

    /// What the board says after its restart.
    fn wait_for_restart(&mut self, board: u8) -> Option<StoreState> {
        let until_ns = self.line.now_ns() + RESTART_NS;
        while self.line.now_ns() < until_ns {
            // A board that still waits with its restart says that the change is pending.
            match self.parameter_store(board) {
                Ok(state) if state.outcome != CommitOutcome::Pending => return Some(state),
                _ => self.line.sleep_until(self.line.now_ns() + ASK_AGAIN_NS),
            }
        }
        None
    }
}

/// Asks again what is lost.
pub(super) fn again<T>(mut ask: impl FnMut() -> Result<T, PageError>) -> Result<T, PageError> {
    let mut result = ask();
    for _ in 1..TRIES {
        if !matches!(&result, Err(PageError::Exchange(error)) if !matches!(error, ExchangeError::Line(_))) {
            break;
        }
        result = ask();
    }
    result
}
