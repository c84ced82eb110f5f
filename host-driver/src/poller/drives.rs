//! A board is asked for its valves' drives, between two polls.

use super::{Event, Polling};
use crate::bus::{BoardFormat, ExchangeError, PageError};
use crate::line::{Line, LineError};
use pneudrive_protocol::pages::Drives;

/// The drives of a board's four valves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// What the board's last control step gave the valves.
    pub drives: Drives,
    /// When the board was asked, ns on the line's clock.
    pub asked_ns: u64,
}

impl<L: Line> Polling<L> {
    /// Asks the board at `index`, which has just answered, for its valves' drives if they are due.
    pub(super) fn ask_for_drives(&mut self, index: usize) -> Result<(), LineError> {
        let board = self.rows[index].board;
        if self.bus.format(board) != BoardFormat::Checked || !self.drives[index].due(self.bus.line().now_ns())
        {
            return Ok(());
        }
        match self.bus.drives(board) {
            Ok((drives, asked_ns)) => {
                self.drives[index].answered();
                self.rows[index].drives = Some(DriveReading { drives, asked_ns });
            }
            Err(PageError::Exchange(ExchangeError::Line(error))) => return Err(error),
            Err(error) => {
                if self.drives[index].failed(self.bus.line().now_ns()) {
                    self.tell(&Event::NoDrives { board, error: &error });
                }
            }
        }
        Ok(())
    }
}
