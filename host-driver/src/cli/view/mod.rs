//! What the user sees while boards are polled: a live view on a terminal, plain lines otherwise.

mod events;
mod lines;
mod live;

pub use events::Events;

use crate::cli::failure::Failure;
use pneudrive_host::line::Clock;
use pneudrive_host::poller::{BoardRow, Override, Poller};
use pneudrive_protocol::{CHANNELS, SensorScale};
use std::io::IsTerminal;
use std::path::PathBuf;

/// What does not change while a run lasts.
#[derive(Debug, Clone)]
pub struct Session {
    /// Name of the port.
    pub port: String,
    /// The recording's file, if there is one.
    pub recording: Option<PathBuf>,
    /// The clock of rows and readings.
    pub clock: Clock,
    /// For venting by key.
    pub overriding: Override,
}

/// Shows the run until `stop`, the poller's own end, or the user ends it.
pub fn show(
    session: &Session,
    json: bool,
    plain: bool,
    poller: &Poller,
    events: &Events,
    stop: impl Fn() -> bool,
) -> Result<(), Failure> {
    if !json && !plain && std::io::stdout().is_terminal() && std::io::stdin().is_terminal() {
        live::show(session, poller, events, stop)
    } else {
        lines::show(session, json, poller, events, stop)
    }
}

/// The commands last sent to a board, kPa. The count for 0 kPa lies a little below it; a command below 0 does not exist.
fn commands_kpa(board: &BoardRow) -> [f64; CHANNELS] {
    board.command.map(|counts| SensorScale::ORIGINAL.kpa(counts).max(0.0))
}
