//! When a board is asked for its valves' drives, between two polls.

use super::{Event, Polling};
use crate::bus::{ExchangeError, Frames, PageError};
use crate::line::{Line, LineError};
use pneudrive_protocol::pages::Drives;
use thiserror::Error;

/// After which share of the polls a board is asked for its valves' drives as well: above 0, at most 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveShare(f64);

/// A number that is no such share.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("expected a share of the polls above 0 and at most 1, got {0}")]
pub struct DriveShareError(
    /// The number.
    pub f64,
);

impl DriveShare {
    /// # Errors
    /// Not above 0, or above 1.
    pub fn new(share: f64) -> Result<Self, DriveShareError> {
        if share > 0.0 && share <= 1.0 { Ok(Self(share)) } else { Err(DriveShareError(share)) }
    }

    /// The number.
    pub fn get(self) -> f64 {
        self.0
    }

    /// Exact for shares such as 0.1, whose sums are not exact in floating point.
    fn millionths(self) -> u32 {
        ((self.0 * 1e6).round() as u32).max(1)
    }
}

/// The drives of a board's four valves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// What the board's last control step gave the valves.
    pub drives: Drives,
    /// When the board was asked, ns on the line's clock.
    pub asked_ns: u64,
}

/// Decides for one board.
#[derive(Debug, Clone)]
pub(super) struct DriveSchedule {
    share: Option<DriveShare>,
    /// Polls that have not been followed by a request for drives, weighted by the share, in millionths: at a million one is due.
    credit: u32,
    /// Requests in a row without drives.
    failures: u32,
    /// It has told its drives.
    known: bool,
    not_before_ns: u64,
    told: bool,
}

impl DriveSchedule {
    const DUE: u32 = 1_000_000;
    /// Failures in a row after which a board that has never told its drives gets pauses: its firmware may be of before pages, and
    /// each request costs a timeout.
    const FAILURES: u32 = 3;
    /// The same for one that has: on a noisy line three in a row are lost now and then.
    const FAILURES_OF_KNOWN: u32 = 100;
    /// The pause, ns: a timeout of 2.2 ms in it is 0.2 % of the bus's time.
    const PAUSE_NS: u64 = 1_000_000_000;

    pub(super) fn new(share: Option<DriveShare>) -> Self {
        // The first poll is followed by one.
        Self { share, credit: Self::DUE, failures: 0, known: false, not_before_ns: 0, told: false }
    }

    /// The board has answered a poll: whether it is to be asked for its drives now.
    pub(super) fn due(&mut self, now_ns: u64) -> bool {
        let Some(share) = self.share else { return false };
        let due = self.credit >= Self::DUE;
        // What falls into a pause is not made up for.
        self.credit = self.credit % Self::DUE + share.millionths();
        due && now_ns >= self.not_before_ns
    }

    pub(super) fn answered(&mut self) {
        self.failures = 0;
        self.known = true;
    }

    /// Whether it is worth telling: once a run.
    pub(super) fn failed(&mut self, now_ns: u64) -> bool {
        self.failures = self.failures.saturating_add(1);
        if self.failures < if self.known { Self::FAILURES_OF_KNOWN } else { Self::FAILURES } {
            return false;
        }
        self.known = false;
        self.not_before_ns = now_ns + Self::PAUSE_NS;
        !std::mem::replace(&mut self.told, true)
    }
}

impl<L: Line> Polling<L> {
    /// Asks the board at `index`, which has just answered, for its valves' drives if they are due.
    pub(super) fn ask_for_drives(&mut self, index: usize) -> Result<(), LineError> {
        let board = self.rows[index].board;
        if self.bus.frames(board) != Frames::Checked || !self.drives[index].due(self.bus.line().now_ns()) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn due(share: f64, polls: u64) -> Vec<u64> {
        let mut schedule = DriveSchedule::new(Some(DriveShare::new(share).unwrap()));
        (0..polls).filter(|&poll| schedule.due(poll)).collect()
    }

    #[test]
    fn the_share_is_kept_from_the_first_poll_on() {
        assert_eq!(due(1.0, 4), [0, 1, 2, 3]);
        assert_eq!(due(0.5, 6), [0, 2, 4]);
        assert_eq!(due(0.25, 9), [0, 4, 8]);
        assert_eq!(due(0.3, 1_000).len(), 300);
    }

    #[test]
    fn without_a_share_nothing_is_asked() {
        let mut schedule = DriveSchedule::new(None);
        assert!((0..10).all(|poll| !schedule.due(poll)));
    }

    #[test]
    fn shares_that_are_none_are_refused() {
        for share in [0.0, -0.1, 1.01, f64::NAN, f64::INFINITY] {
            assert!(DriveShare::new(share).is_err(), "{share}");
        }
    }

    #[test]
    fn a_board_without_pages_is_asked_once_a_second_and_told_once() {
        let mut schedule = DriveSchedule::new(Some(DriveShare::new(1.0).unwrap()));
        let mut asked = Vec::new();
        let mut told = Vec::new();
        for now_ns in (0..3_500_000_000).step_by(1_000_000) {
            if schedule.due(now_ns) {
                asked.push(now_ns / 1_000_000);
                if schedule.failed(now_ns) {
                    told.push(now_ns / 1_000_000);
                }
            }
        }
        assert_eq!((asked, told), (vec![0, 1, 2, 1_002, 2_002, 3_002], vec![2]));
    }

    /// Another board in its place gets its pauses, too, but later.
    #[test]
    fn a_board_that_has_told_its_drives_is_asked_on_through_noise() {
        let mut schedule = DriveSchedule::new(Some(DriveShare::new(1.0).unwrap()));
        schedule.answered();
        for now_ns in 0..99 {
            assert!(schedule.due(now_ns) && !schedule.failed(now_ns), "after {now_ns} failures");
        }
        assert!(schedule.due(99) && schedule.failed(99));
        assert!(!schedule.due(100) && !schedule.due(1_000_000_098) && schedule.due(1_000_000_099));
    }
}
