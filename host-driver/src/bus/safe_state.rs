//! Leaving the boards at 0 kPa, and knowing that they are.
//!
//! What confirms it depends on the board:
//!
//! - A checked answer: it has the number of the request, and a board answers in checked packets
//!   only what it obeys.
//! - Of a board of the original kind an answer says nothing: it answers requests whose commands it
//!   drops. Such a board is commanded again and again until its channels *read* that they are
//!   vented ([`SafeStateOptions`]). It has no command timeout, so what is left in it stays.
//! - A board that this bus has never commanded anything but 0 kPa has nothing of this host's in it:
//!   its answer is enough.

use super::{BoardFormat, Bus, BusOptions, ExchangeError};
use crate::line::{Line, LineError};
use crate::time::saturating_ns;
use pneudrive_protocol::pages::LineRate;
use pneudrive_protocol::{CHANNELS, CheckedPacket, Counts};
use std::time::Duration;

/// When a board of the original kind counts as vented at the end, and how long is waited for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct SafeStateOptions {
    /// The highest reading of a vented channel, ADC counts. Default 114: just below 10 kPa on the
    /// original's sensor.
    pub vented: Counts,
    /// How long all channels have to read so, and not to rise: as long as a set point that is still
    /// regulated would need to be seen in a chamber. Default 0.2 s.
    pub settled: Duration,
    /// A board of which no channel has fallen by a count for so long is given up. Default 1 s.
    pub stalled: Duration,
    /// So is every board after this time. Default 10 s.
    pub limit: Duration,
    /// Time between two commands to the boards that are waited for. Default 5 ms.
    pub every: Duration,
}

impl Default for SafeStateOptions {
    fn default() -> Self {
        Self {
            vented: Counts::saturating(114),
            settled: Duration::from_millis(200),
            stalled: Duration::from_secs(1),
            limit: Duration::from_secs(10),
            every: Duration::from_millis(5),
        }
    }
}

/// A board on its way to 0 kPa.
#[derive(Debug)]
struct Venting {
    board: u8,
    confirmed: bool,
    /// Lowest reading of each channel so far.
    lowest: [Counts; CHANNELS],
    fell_at_ns: u64,
    /// Since when all channels have read vented without rising, ns.
    vented_since_ns: Option<u64>,
}

impl Venting {
    /// What a reading goes up and down by of itself, ADC counts. A chamber that fills rises by more
    /// in [`SafeStateOptions::settled`].
    const NOISE: u16 = 3;

    fn new(board: u8, now_ns: u64) -> Self {
        Self {
            board,
            confirmed: false,
            lowest: [Counts::MAX; CHANNELS],
            fell_at_ns: now_ns,
            vented_since_ns: None,
        }
    }

    /// The board reads `pressures` at `now_ns`, after it was commanded 0 kPa.
    fn reads(&mut self, pressures: [Counts; CHANNELS], now_ns: u64, options: &SafeStateOptions) {
        let mut rises = false;
        for (lowest, &pressure) in self.lowest.iter_mut().zip(&pressures) {
            rises |= pressure.get() > lowest.get() + Self::NOISE;
            if pressure < *lowest {
                *lowest = pressure;
                self.fell_at_ns = now_ns;
            }
        }
        let vented = pressures.iter().all(|&pressure| pressure <= options.vented);
        if !vented || rises {
            self.vented_since_ns = None;
            if rises {
                self.lowest = pressures;
            }
            return;
        }
        let since_ns = *self.vented_since_ns.get_or_insert(now_ns);
        self.confirmed |= now_ns - since_ns >= saturating_ns(options.settled);
    }

    /// Whether it is to be commanded on.
    fn is_waited_for(&self, started_ns: u64, now_ns: u64, options: &SafeStateOptions) -> bool {
        let settles = self.vented_since_ns.is_some();
        let given_up = (now_ns - self.fell_at_ns >= saturating_ns(options.stalled) && !settles)
            || now_ns - started_ns >= saturating_ns(options.limit);
        !self.confirmed && !given_up
    }
}

impl<L: Line> Bus<L> {
    /// Commands 0 kPa to `boards`, each [`BusOptions::SAFE_STATE_REPEATS`] times at least, so that
    /// a lost packet does not matter, and boards of the original kind until they read that they are
    /// vented ([`BusOptions::safe_state`] says how long). Then tells boards that check that the
    /// host leaves: see [`leave`](Self::leave). Returns the boards that confirmed none of it; those
    /// of them that are of the original kind may be under pressure for ever.
    ///
    /// # Errors
    /// Only when the line failed: then nothing can be sent any more.
    pub fn make_safe(&mut self, boards: impl Iterator<Item = u8>) -> Result<Vec<u8>, LineError> {
        let options = self.options.safe_state;
        let started_ns = self.line.now_ns();
        let mut boards: Vec<Venting> = boards.map(|board| Venting::new(board, started_ns)).collect();
        for _ in 0..BusOptions::SAFE_STATE_REPEATS {
            for board in &mut boards {
                self.command_zero(board)?;
            }
        }
        loop {
            let now_ns = self.line.now_ns();
            let mut waiting = false;
            for board in &mut boards {
                let waits =
                    self.holds_set_points(board.board) && board.is_waited_for(started_ns, now_ns, &options);
                if waits {
                    self.command_zero(board)?;
                    waiting = true;
                }
            }
            if !waiting {
                break;
            }
            self.line.sleep_until(now_ns + saturating_ns(options.every));
        }
        for board in &boards {
            self.leave(board.board)?;
        }
        // Boards that were left go back by themselves.
        if self.line_rate != LineRate::Compiled {
            self.go_to(LineRate::Compiled)?;
        }
        Ok(boards.iter().filter(|board| !board.confirmed).map(|board| board.board).collect())
    }

    /// Tells `board` that this host leaves, if it is a board that checks: it vents, and obeys
    /// another host, of whichever kind, at once ([`CheckedPacket::leave`]). Does nothing to other
    /// boards. Tried three times.
    ///
    /// # Errors
    /// Only when the line failed.
    pub fn leave(&mut self, board: u8) -> Result<(), LineError> {
        if self.format(board) != BoardFormat::Checked {
            return Ok(());
        }
        for _ in 0..BusOptions::SAFE_STATE_REPEATS {
            match self.request(board, CheckedPacket::LEAVE) {
                Ok(_) => {
                    self.peers[usize::from(board)].session.end();
                    break;
                }
                Err(ExchangeError::Line(error)) => return Err(error),
                Err(_) => {}
            }
        }
        Ok(())
    }

    /// Whether `board` may go on regulating a set point of this host for ever when nobody speaks to
    /// it any more: it has been commanded more than 0 kPa and is not known to check, so it may be
    /// of the original kind, without a command timeout.
    pub fn may_hold_for_ever(&self, board: u8) -> bool {
        self.peers[usize::from(board)].was_pressurised() && self.format(board) != BoardFormat::Checked
    }

    /// Whether `board` may hold a set point of this host whatever it answers: it has answered, and
    /// may hold it for ever.
    fn holds_set_points(&self, board: u8) -> bool {
        self.counters(board).answered > 0 && self.may_hold_for_ever(board)
    }

    fn command_zero(&mut self, board: &mut Venting) -> Result<(), LineError> {
        match self.ping(board.board) {
            Ok(answer) if self.holds_set_points(board.board) => {
                board.reads(answer.pressures, answer.answered_ns, &self.options.safe_state);
                Ok(())
            }
            Ok(_) => {
                board.confirmed = true;
                Ok(())
            }
            Err(ExchangeError::Line(error)) => Err(error),
            Err(_) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPTIONS: SafeStateOptions = SafeStateOptions {
        vented: Counts::saturating(114),
        settled: Duration::from_nanos(200),
        stalled: Duration::from_nanos(1_000),
        limit: Duration::from_nanos(10_000),
        every: Duration::from_nanos(5),
    };

    fn reads(board: &mut Venting, pressure: u16, now_ns: u64) -> bool {
        board.reads([Counts::saturating(pressure); CHANNELS], now_ns, &OPTIONS);
        board.confirmed
    }

    #[test]
    fn a_board_is_confirmed_when_it_has_read_vented_for_long_enough() {
        let mut board = Venting::new(0, 0);
        assert!(!reads(&mut board, 300, 0));
        assert!(!reads(&mut board, 114, 500));
        assert!(!reads(&mut board, 115, 600), "above the limit again: noise of a count");
        assert!(!reads(&mut board, 114, 700));
        assert!(!reads(&mut board, 102, 899));
        assert!(reads(&mut board, 103, 900));
    }

    /// It reads low because its chamber has only begun to fill.
    #[test]
    fn a_board_that_rises_is_not_confirmed() {
        let mut board = Venting::new(0, 0);
        for now_ns in 0..10 {
            assert!(!reads(&mut board, 77 + 4 * now_ns, u64::from(now_ns) * 100), "{now_ns}");
        }
    }

    #[test]
    fn a_board_that_does_not_fall_is_given_up() {
        let mut board = Venting::new(0, 0);
        reads(&mut board, 300, 10);
        assert!(board.is_waited_for(0, 1_009, &OPTIONS));
        assert!(!board.is_waited_for(0, 1_010, &OPTIONS));
        reads(&mut board, 299, 1_000);
        assert!(board.is_waited_for(0, 1_999, &OPTIONS));
        reads(&mut board, 298, 9_900);
        assert!(!board.is_waited_for(0, 10_000, &OPTIONS), "the limit");
    }
}
