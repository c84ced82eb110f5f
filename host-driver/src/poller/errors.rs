//! Why a poller did not start, or did not end as it should.

use crate::real_time::RealTimeError;
use thiserror::Error;

/// Why a poller was not started.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StartError {
    /// There is nobody to poll.
    #[error("no boards to poll; say which, as in `.boards(0..4)`")]
    NoBoards,
    /// A rate that makes no sense.
    #[error("{0} Hz: a bus is polled at 0.1 to 10,000 Hz")]
    Rate(f64),
    /// The system has no thread to give.
    #[error("no thread for the bus: {0}")]
    Thread(#[from] std::io::Error),
    /// The system refuses the bus thread what
    /// [`PollerOptions::real_time`](super::PollerOptions::real_time) asks for. The text says what,
    /// and how to allow it.
    #[error(transparent)]
    RealTime(#[from] RealTimeError),
}

/// The bus thread panicked: an observer or a source of commands did, or the poller has a fault. All
/// boards were commanded 0 kPa first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the bus thread panicked")]
pub struct PollerPanicked;
