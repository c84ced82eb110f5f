use super::{EchoError, HeardBytes};
use crate::line::{LineError, OpenError};
use pneudrive_protocol::{Address, PACKET_LEN};
use std::time::Duration;
use thiserror::Error;

/// A bus that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum OpenBusError {
    /// The port cannot be used.
    #[error(transparent)]
    Port(#[from] OpenError),
    /// The port failed at once.
    #[error(transparent)]
    Line(#[from] LineError),
    /// It cannot be told whether the adapter echoes.
    #[error(transparent)]
    Echo(#[from] EchoError),
}

/// An exchange that brought no answer.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ExchangeError {
    /// Nothing came.
    #[error("{asked}: no answer after {waited} us; check its power, the two wires and its address switch",
        waited = .waited.as_micros()
    )]
    NoAnswer {
        /// The board that was asked.
        asked: Address,
        /// How long it was waited.
        waited: Duration,
    },
    /// Something came that is no packet.
    #[error(
        "{asked}: expected {expected} bytes, got {heard}, which hold no packet, in {waited} us; noise, or another baud rate",
        expected = PACKET_LEN,
        waited = .waited.as_micros()
    )]
    Garbled {
        /// The board that was asked.
        asked: Address,
        /// What came (without a whole echo).
        heard: HeardBytes,
        /// How long it was waited.
        waited: Duration,
    },
    /// The host's own bytes came back changed: somebody spoke at the same time, or the line is
    /// noisy. An answer is not believed, because the board may have heard something else than was
    /// sent.
    #[error("{asked}: the echo of the request came back damaged: {heard}; two speakers at a time, or noise")]
    EchoDamaged {
        /// The board that was asked.
        asked: Address,
        /// What came.
        heard: HeardBytes,
        /// How long it was waited.
        waited: Duration,
    },
    /// The adapter echoed at the start, and now does not.
    #[error(
        "{asked}: {missing} bytes of the request's echo are missing after {waited} us; noise, or the adapter was changed",
        waited = .waited.as_micros()
    )]
    EchoMissing {
        /// The board that was asked.
        asked: Address,
        /// Bytes of the echo that did not come.
        missing: usize,
        /// What came.
        heard: HeardBytes,
        /// How long it was waited.
        waited: Duration,
    },
    /// Only another board answered.
    #[error(
        "{asked}: {answered} answered instead, nothing else in {waited} us; a late answer, or two boards with one address",
        waited = .waited.as_micros()
    )]
    OtherBoard {
        /// The board that was asked.
        asked: Address,
        /// The board that answered.
        answered: Address,
        /// How long it was waited.
        waited: Duration,
    },
    /// The board answered an earlier request, or in the other packet format, and nothing else.
    #[error("{asked}: only an answer to an earlier request came in {waited} us", waited = .waited.as_micros())]
    Stale {
        /// The board that was asked.
        asked: Address,
        /// How long it was waited.
        waited: Duration,
    },
    /// A board of which nothing was known was asked in checked packets and answered in the
    /// original's format: it is of the original kind, and has dropped the commands.
    #[error(
        "{asked}: it answered in the original's packet format, and drops checked requests; it is of the original kind"
    )]
    OriginalFormat {
        /// The board that was asked.
        asked: Address,
        /// From the request until the answer.
        waited: Duration,
    },
    /// The board is in a session, with another host or with this one before it was started anew,
    /// and obeys nobody else.
    #[error(
        "{asked}: it is in a session with another host, or with this one before it was restarted; it is free when that has \
         been silent for the board's command timeout"
    )]
    InSession {
        /// The board that was asked.
        asked: Address,
    },
    /// The answer came, but the host read it only now: it was stopped, or the machine is
    /// overloaded. Its pressures are history.
    #[error(
        "{asked}: its answer was read only after {waited} us, too old to be used; the host was stopped, or the machine is overloaded",
        waited = .waited.as_micros()
    )]
    TooOld {
        /// The board that was asked.
        asked: Address,
        /// From the request until the answer was read.
        waited: Duration,
    },
    /// Somebody does not stop talking, so that nothing can be asked.
    #[error(
        "the line is not idle after {waited} us ({heard}); a board or another host does not stop sending",
        waited = .waited.as_micros()
    )]
    LineBusy {
        /// What came.
        heard: HeardBytes,
        /// How long it was waited.
        waited: Duration,
    },
    /// The port failed.
    #[error(transparent)]
    Line(#[from] LineError),
}

impl ExchangeError {
    /// How long it was waited for the answer; 0 where nothing was asked, or the port failed.
    pub fn waited(&self) -> Duration {
        match self {
            Self::NoAnswer { waited, .. }
            | Self::Garbled { waited, .. }
            | Self::EchoDamaged { waited, .. }
            | Self::EchoMissing { waited, .. }
            | Self::OtherBoard { waited, .. }
            | Self::Stale { waited, .. }
            | Self::OriginalFormat { waited, .. }
            | Self::TooOld { waited, .. }
            | Self::LineBusy { waited, .. } => *waited,
            Self::InSession { .. } | Self::Line(_) => Duration::ZERO,
        }
    }

    /// Whether bytes came that were refused.
    pub fn something_came(&self) -> bool {
        !matches!(self, Self::NoAnswer { .. } | Self::InSession { .. } | Self::Line(_))
    }

    /// Whether the board can be assumed to have said what it had to say: as many bytes came as its
    /// answer has. If not, it may still answer.
    pub(super) fn answer_consumed(&self) -> bool {
        match self {
            Self::Garbled { heard, .. } => heard.count() >= PACKET_LEN,
            Self::EchoDamaged { heard, .. } | Self::EchoMissing { heard, .. } => {
                heard.count() >= 2 * PACKET_LEN
            }
            // A busy line was never asked; a late answer has come.
            Self::OriginalFormat { .. }
            | Self::InSession { .. }
            | Self::TooOld { .. }
            | Self::LineBusy { .. }
            | Self::Line(_) => true,
            Self::NoAnswer { .. } | Self::OtherBoard { .. } | Self::Stale { .. } => false,
        }
    }
}
