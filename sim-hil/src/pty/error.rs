use crate::rig::RigError;
use rustix::io::Errno;
use std::path::PathBuf;
use thiserror::Error;

/// The simulator could not start, or had to end.
#[derive(Debug, Error)]
pub enum SimError {
    /// The rig cannot be built.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The system gave no pseudo-terminal.
    #[error("cannot {action} a pseudo-terminal: {source}")]
    Pty {
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: Errno,
    },
    /// The system gave no thread.
    #[error("cannot start the simulator's thread: {source}")]
    Thread {
        /// What the system said.
        source: std::io::Error,
    },
    /// The symbolic link cannot be made.
    #[error("cannot make the link {}: {reason}", link.display())]
    Link {
        /// Where it should be.
        link: PathBuf,
        /// What stands in the way.
        reason: String,
    },
}

impl SimError {
    /// For `map_err` on calls to the system.
    pub(super) fn pty(action: &'static str) -> impl FnOnce(Errno) -> Self {
        move |source| Self::Pty { action, source }
    }
}
