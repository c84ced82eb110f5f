//! What the user sees while boards are polled: a live view on a terminal, plain lines otherwise.

mod events;
mod lines;
mod live;
mod recorder;

pub use events::{EventSender, Events};
pub use recorder::KeyRecorder;

use crate::failure::Failure;
use crate::setup::Setup;
use pneudrive_host::line::Clock;
use pneudrive_host::poller::{Limits, Monitor, Override, Poller};
use pneudrive_host::replay::Player;
use pneudrive_record::watch::WatchStatus;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;

/// What is looked at: boards that are polled, or a recording of them.
#[derive(Clone, Copy)]
pub enum Watched<'a> {
    /// Boards.
    Boards(&'a Poller),
    /// A recording.
    Recording(&'a Player),
}

impl<'a> Watched<'a> {
    /// Its rows and figures.
    pub fn monitor(self) -> Monitor {
        match self {
            Self::Boards(poller) => poller.monitor(),
            Self::Recording(player) => player.monitor(),
        }
    }

    /// Whether it has ended by itself.
    pub fn is_finished(self) -> bool {
        match self {
            Self::Boards(poller) => poller.is_finished(),
            Self::Recording(player) => player.is_finished(),
        }
    }

    /// The recording, if it is one: there is nothing to command.
    pub fn recording(self) -> Option<&'a Player> {
        match self {
            Self::Boards(_) => None,
            Self::Recording(player) => Some(player),
        }
    }
}

/// What does not change while a run lasts.
#[derive(Clone)]
pub struct Session {
    /// Name of the port.
    pub port: String,
    /// The recording's file, if there is one.
    pub recording: Option<PathBuf>,
    /// The clock of rows and readings.
    pub clock: Clock,
    /// Names, calibration, and the unit for people.
    pub setup: Setup,
    /// Highest set points.
    pub limits: Limits,
    /// Recordings by a key, where the run is not recorded anyway.
    pub recorder: Option<KeyRecorder>,
    /// For venting by key.
    pub overriding: Override,
    /// Whether the run goes on when the terminal closes.
    pub keep_running: bool,
    /// The calibrated model beside the run.
    pub watch: Option<WatchStatus>,
}

/// Why nobody looks at the run any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndedBy {
    /// A signal, or a recording that cannot go on.
    Stop,
    /// The poller ended by itself: its commands ended, or the line failed.
    Poller,
    /// A key.
    Key,
    /// The terminal, or whatever read the lines, has closed.
    Terminal,
}

/// Shows the run until `stop`, the poller's own end, or the user ends it. A terminal that closes
/// ends it too, unless it is to keep running: then it goes on without a view.
pub fn show(
    session: &Session,
    json: bool,
    plain: bool,
    watched: Watched<'_>,
    events: &Events,
    stop: impl Fn() -> bool,
) -> Result<EndedBy, Failure> {
    let ended = if wants_live(json, plain) {
        live::show(session, watched, events, &stop)?
    } else {
        lines::show(session, json, watched, events, &stop)?
    };
    if ended == EndedBy::Terminal && session.keep_running {
        return Ok(wait(watched, events, stop));
    }
    Ok(ended)
}

/// Whether there is a terminal that can be drawn on, and nobody wants lines.
pub fn wants_live(json: bool, plain: bool) -> bool {
    let dumb = std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb");
    !json && !plain && !dumb && has_size(&std::io::stdout()) && std::io::stdin().is_terminal()
}

/// Whether it is a terminal, and one that has room. Those that `script` and such like make have
/// none where no person sits in front of them: nothing could be seen, and what comes as a key is
/// none.
fn has_size(output: &std::io::Stdout) -> bool {
    rustix::termios::tcgetwinsize(output).is_ok_and(|size| size.ws_col > 0 && size.ws_row > 0)
}

/// Until the end, with nobody looking.
fn wait(watched: Watched<'_>, events: &Events, stop: impl Fn() -> bool) -> EndedBy {
    const LOOK_EVERY: Duration = Duration::from_millis(50);
    loop {
        if stop() {
            return EndedBy::Stop;
        }
        if watched.is_finished() {
            return EndedBy::Poller;
        }
        // They would pile up.
        while events.next().is_some() {}
        std::thread::sleep(LOOK_EVERY);
    }
}
