//! The port `sim` of the host, of the Python package and of the ROS node: virtual boards in a
//! thread of the program, which talks to them through their pty's bytes only.
//!
//! With the feature `sim`; without it [`VirtualBoards::start`] says that there are none.
#![forbid(unsafe_code)]

#[cfg(not(feature = "sim"))]
mod absent;
#[cfg(feature = "sim")]
mod present;

#[cfg(not(feature = "sim"))]
use absent::Boards;
use pneudrive_protocol::Baud;
#[cfg(feature = "sim")]
use present::Boards;
use std::path::Path;
use std::time::Duration;
use thiserror::Error;

/// Whether a port's name means virtual boards.
pub fn is_sim(port: &Path) -> bool {
    port == Path::new("sim")
}

/// Which boards are started, and how punctual they are.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct VirtualOptions {
    /// How many boards, 1 to 256; healthy ones, with all sensors.
    pub boards: u16,
    /// The line's rate.
    pub baud: Baud,
    /// Whether their bytes take as long as on a wire.
    pub timing: Timing,
    /// How long they take before they answer; `None` for what the firmware takes.
    pub turnaround: Option<Duration>,
    /// Those that are of the original kind.
    pub original: Vec<u8>,
    /// How late answers may be.
    pub punctuality: Punctuality,
}

impl VirtualOptions {
    /// Boards as the firmware makes them.
    pub fn new(boards: u16, baud: Baud) -> Self {
        Self {
            boards,
            baud,
            timing: Timing::Wire,
            turnaround: None,
            original: Vec::new(),
            punctuality: Punctuality::Usual,
        }
    }

    /// Whether their bytes take as long as on a wire.
    #[must_use]
    pub fn timing(self, timing: Timing) -> Self {
        Self { timing, ..self }
    }

    /// How long they take before they answer; `None` for what the firmware takes.
    #[must_use]
    pub fn turnaround(self, turnaround: impl Into<Option<Duration>>) -> Self {
        Self { turnaround: turnaround.into(), ..self }
    }

    /// Those that are of the original kind.
    #[must_use]
    pub fn original(self, original: Vec<u8>) -> Self {
        Self { original, ..self }
    }

    /// How late answers may be.
    #[must_use]
    pub fn punctuality(self, punctuality: Punctuality) -> Self {
        Self { punctuality, ..self }
    }
}

/// When bytes arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Timing {
    /// When the line rate would deliver them.
    Wire,
    /// At once.
    Instant,
}

/// How punctual virtual boards are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Punctuality {
    /// Some 10 us late, and hardly a load.
    Usual,
    /// As punctual as a core that busy-waits makes them.
    Best {
        /// Whether requests are dated back by the pty's round trip.
        dated: bool,
    },
}

/// There are no virtual boards.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum VirtualError {
    /// The program has none.
    #[error(
        "this program was built without virtual boards (feature `sim`); start pneudrive-sim and pass its port"
    )]
    NotBuilt,
    /// There cannot be such boards.
    #[error("virtual boards: {0}")]
    Options(String),
    /// The system has no pseudo-terminal or thread to give.
    #[error("virtual boards: {0}")]
    System(String),
}

impl VirtualError {
    /// Whether other arguments, or another program, would do; otherwise the system has failed.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::System(_))
    }
}

/// Virtual boards. They end when this is dropped, which is to be after the bus.
#[derive(Debug)]
pub struct VirtualBoards(Boards);

impl VirtualBoards {
    /// Starts them.
    ///
    /// # Errors
    /// The program has none, there cannot be such boards, or the system has failed.
    pub fn start(options: &VirtualOptions) -> Result<Self, VirtualError> {
        Boards::start(options).map(Self)
    }

    /// The path of their port, to be opened like a serial port.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// What requests are dated back by: the round trip of the pty. `None` where nothing is
    /// dated.
    pub fn dated_back(&self) -> Option<Duration> {
        Some(self.0.pty_round_trip()).filter(|round_trip| !round_trip.is_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_name_alone_means_virtual_boards() {
        assert!(is_sim(Path::new("sim")));
        assert!(!is_sim(Path::new("./sim")) && !is_sim(Path::new("/dev/sim")) && !is_sim(Path::new("SIM")));
    }

    #[cfg(feature = "sim")]
    #[test]
    fn boards_have_a_port_and_impossible_ones_are_the_arguments_fault() {
        let boards = VirtualBoards::start(&VirtualOptions::new(2, Baud::ORIGINAL)).unwrap();
        assert!(boards.path().exists());
        assert!(boards.dated_back().is_some());
        let refused = VirtualBoards::start(&VirtualOptions::new(300, Baud::ORIGINAL)).unwrap_err();
        assert!(refused.is_input(), "{refused}");
    }

    #[cfg(not(feature = "sim"))]
    #[test]
    fn a_program_without_them_says_what_to_do_instead() {
        let refused = VirtualBoards::start(&VirtualOptions::new(1, Baud::ORIGINAL)).unwrap_err();
        assert_eq!(refused, VirtualError::NotBuilt);
        assert!(refused.is_input());
        assert!(refused.to_string().ends_with("start pneudrive-sim and pass its port"), "{refused}");
    }
}
