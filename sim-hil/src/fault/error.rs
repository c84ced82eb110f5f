use super::FaultKind;
use thiserror::Error;

/// A fault specification that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FaultError {
    /// Neither `KIND=RATE` nor `KIND@SECONDS`.
    #[error("fault '{text}' is neither KIND=RATE nor KIND@SECONDS, as in bit_flip=1e-4 or unplug@3,board=1")]
    Form {
        /// What was given.
        text: String,
    },
    /// No such kind.
    #[error("there is no fault '{name}'; the nearest is '{nearest}' (pneudrive-sim faults lists them all)")]
    UnknownKind {
        /// What was given.
        name: String,
        /// The kind with the most similar name.
        nearest: &'static str,
    },
    /// The rate is no number or out of its range.
    #[error("fault {}: rate '{value}' must be {expected}", kind.name())]
    Rate {
        /// Which fault.
        kind: FaultKind,
        /// What was given.
        value: String,
        /// What it must be.
        expected: &'static str,
    },
    /// The time is no number of seconds.
    #[error("fault {}: time '{value}' must be a number of seconds from 0 to 1e6", kind.name())]
    Time {
        /// Which fault.
        kind: FaultKind,
        /// What was given.
        value: String,
    },
    /// An option that the kind does not have, or whose value is not understood.
    #[error("fault {}: option '{option}' must be one of {expected}", kind.name())]
    Option {
        /// Which fault.
        kind: FaultKind,
        /// What was given.
        option: String,
        /// What the kind takes.
        expected: String,
    },
    /// The board is not on the bus.
    #[error("fault {}: there is no board {board} among {boards}", kind.name())]
    NoSuchBoard {
        /// Which fault.
        kind: FaultKind,
        /// The board that was named.
        board: usize,
        /// Boards on the bus.
        boards: usize,
    },
}
