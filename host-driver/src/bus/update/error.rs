//! Why a board was not updated, and what its user can do.

use crate::bus::{ExchangeError, PageError};
use crate::line::LineError;
use pneudrive_protocol::Address;
use pneudrive_protocol::pages::{ChipKind, LastTrial, Update, UpdateOutcome};
use thiserror::Error;

/// A board that was not updated. It goes on with the program that it had, except where
/// [`Lost`](Self::Lost) says otherwise.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum UpdateError {
    /// It could not be asked.
    #[error(transparent)]
    Page(#[from] PageError),
    /// Its firmware is of before updates over the bus.
    #[error(
        "{asked}: its firmware is of before updates over the bus; flash it once with a debug probe (`cargo fw`) or by BOOTSEL (`cargo fw-uf2`)"
    )]
    TooOld {
        /// The board that was asked.
        asked: Address,
    },
    /// It cannot be updated over the bus at all.
    #[error("{asked}: {chip} is not updated over the bus; flash it with a debug probe or by BOOTSEL")]
    Unsupported {
        /// The board that was asked.
        asked: Address,
        /// What it runs on.
        chip: ChipKind,
    },
    /// The program is for another chip.
    #[error("{asked}: the program is for {wanted}, and the board is {chip}")]
    OtherChip {
        /// The board that was asked.
        asked: Address,
        /// What the board runs on.
        chip: ChipKind,
        /// What the program is for.
        wanted: ChipKind,
    },
    /// It gives no session, without which it takes no program.
    #[error(
        "{asked}: it gives this host no session, in which alone it takes a program; is another host on the bus?"
    )]
    NoSession {
        /// The board that was asked.
        asked: Address,
    },
    /// A program is on trial already.
    #[error(
        "{asked}: a program is on trial that nobody has confirmed; the board goes back to the one before within {} s, try again then",
        Update::TRIAL_S
    )]
    OnTrial {
        /// The board that was asked.
        asked: Address,
    },
    /// Its chambers have pressure.
    #[error(
        "{asked}: refused, because a chamber has more than 17 kPa; it is commanded 0 kPa, try again when it has vented"
    )]
    NotVented {
        /// The board that was asked.
        asked: Address,
    },
    /// It could not be asked while the program was sent. Nothing is written then.
    #[error(
        "{error}; not all of the program was sent: the board goes on with the one that it had, try again"
    )]
    Interrupted {
        /// Why the last request failed.
        error: PageError,
    },
    /// It does not have what it was sent, as after half a second without a request.
    #[error(
        "{asked}: nothing reached it for too long, and it has forgotten what it was sent; it goes on with the program that it had, try again"
    )]
    Forgotten {
        /// The board that was asked.
        asked: Address,
    },
    /// It refused what it has received.
    #[error(
        "{asked}: refused what it has received ({outcome:?}); it goes on with the program that it had, try again"
    )]
    Refused {
        /// The board that was asked.
        asked: Address,
        /// Why.
        outcome: UpdateOutcome,
    },
    /// It is back with the old program.
    #[error("{asked}: {}; it is back with the program that it had", reason(.last_trial))]
    RolledBack {
        /// The board that was asked.
        asked: Address,
        /// How the trial ended.
        last_trial: LastTrial,
    },
    /// All was sent, and the board does not say what became of it.
    #[error("{}", lost(*.asked, *.confirmed, .last.as_ref()))]
    Lost {
        /// The board that was asked.
        asked: Address,
        /// Whether the new program was told to stay. If not, it does not.
        confirmed: bool,
        /// Why the last question brought no answer; `None` if it brought one that said nothing new.
        last: Option<PageError>,
    },
}

fn lost(asked: Address, confirmed: bool, last: Option<&PageError>) -> String {
    let silence = last.map_or_else(|| format!("{asked}: it still works on the update"), PageError::to_string);
    let runs = if confirmed {
        "whether it runs the new program or the one before is not known".to_string()
    } else {
        format!(
            "the new program was not confirmed: the board goes back to the one before within {} s, or when its supply is \
             switched off and on",
            Update::TRIAL_S
        )
    };
    format!("{silence}; {runs}; update it again: nothing is sent if it runs the new program")
}

fn reason(trial: &LastTrial) -> &'static str {
    match trial {
        LastTrial::None => "it does not run the new program, as after a failure of its supply",
        LastTrial::Damaged => "its flash did not hold the new program, which was not started",
        LastTrial::NotConfirmed => "the new program was not confirmed before its trial ended",
    }
}

impl From<ExchangeError> for UpdateError {
    fn from(error: ExchangeError) -> Self {
        Self::Page(error.into())
    }
}

impl From<LineError> for UpdateError {
    fn from(error: LineError) -> Self {
        Self::Page(error.into())
    }
}
