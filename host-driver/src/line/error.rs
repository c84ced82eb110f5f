use std::path::PathBuf;
use std::time::Duration;
use thiserror::Error;

/// A port that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum OpenError {
    /// There is no such file.
    #[error("{port}: no such port; is the adapter plugged in? (look at /dev/serial/by-id, or use --port sim)", port = .port.display())]
    NotFound {
        /// The port that was asked for.
        port: PathBuf,
    },
    /// The user may not open it.
    #[error(
        "{port}: no permission; serial ports usually belong to the group dialout (sudo usermod -aG dialout $USER, then log in again)",
        port = .port.display()
    )]
    NoPermission {
        /// The port that was asked for.
        port: PathBuf,
    },
    /// Another process has it.
    #[error("{port}: in use by another process; two hosts on one bus would disturb each other", port = .port.display())]
    InUse {
        /// The port that was asked for.
        port: PathBuf,
    },
    /// It exists but is no serial port.
    #[error("{port}: not a serial port", port = .port.display())]
    NotATerminal {
        /// The port that was asked for.
        port: PathBuf,
    },
    /// The device took the settings but not the line rate.
    #[error("{port}: asked for {asked} baud, the device set {got}; choose a rate that the adapter can do", port = .port.display())]
    BaudRefused {
        /// The port that was asked for.
        port: PathBuf,
        /// Line rate asked for, bit/s.
        asked: u32,
        /// Line rate that the device reports, bit/s.
        got: u32,
    },
    /// It was lost, and its name may by now belong to somebody else's terminal.
    #[error("{port}: a pseudo-terminal that was closed does not come back by this name; start the other end with a link and use that", port = .port.display())]
    NameGivenAway {
        /// The port that was asked for.
        port: PathBuf,
    },
    /// A line of another kind, that cannot be opened again.
    #[error("this line has no name to open it again by")]
    NoName,
    /// Anything else the system said.
    #[error("{port}: {what} failed: {reason}", port = .port.display())]
    System {
        /// The port that was asked for.
        port: PathBuf,
        /// What was tried.
        what: &'static str,
        /// What the system said.
        reason: String,
    },
}

/// A port that was open and failed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LineError {
    /// The device vanished or the other end of the pty was closed.
    #[error("{port}: the port is gone (adapter unplugged, or the other end closed)", port = .port.display())]
    Gone {
        /// The port.
        port: PathBuf,
    },
    /// The device takes no more bytes: it stopped sending.
    #[error("{port}: the device took no bytes for {waited} us", port = .port.display(), waited = .waited.as_micros())]
    Stuck {
        /// The port.
        port: PathBuf,
        /// How long it was waited.
        waited: Duration,
    },
    /// Anything else the system said.
    #[error("{port}: {what} failed: {reason}", port = .port.display())]
    System {
        /// The port.
        port: PathBuf,
        /// What was tried.
        what: &'static str,
        /// What the system said.
        reason: String,
    },
}
