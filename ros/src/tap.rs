//! From the bus thread to the publisher's.

use crate::live::Live;
use pneudrive_host::Calibration;
use pneudrive_host::poller::{Observer, Row};
use pneudrive_protocol::CHANNELS;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// What a board answered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Its place in the poller's order.
    pub index: usize,
    /// When it was asked, ns on the line's clock.
    pub asked_ns: u64,
    /// What it measured, kPa gauge.
    pub measured: [f64; CHANNELS],
    /// What it was commanded when it was asked, kPa gauge.
    pub command: [f64; CHANNELS],
}

/// Sits on the bus thread, which does not wait: what does not fit is counted.
pub struct Tap {
    states: SyncSender<State>,
    dropped: Arc<AtomicU64>,
    live: Arc<Live>,
    calibration: Calibration,
    due_ns: u64,
}

impl Tap {
    /// States that may wait for the publisher: 0.25 s of four boards at 1 kHz, so that a hiccup of
    /// the network passes unseen.
    const QUEUE: usize = 1_000;

    /// The tap, its other end, and how many states did not fit.
    pub fn new(live: Arc<Live>, calibration: Calibration) -> (Self, Receiver<State>, Arc<AtomicU64>) {
        let (states, receiver) = sync_channel(Self::QUEUE);
        let dropped = Arc::new(AtomicU64::new(0));
        (Self { states, dropped: Arc::clone(&dropped), live, calibration, due_ns: 0 }, receiver, dropped)
    }

    /// Whether a row at `at_ns` is to be published. A row that comes a little early, by jitter, is
    /// not left out.
    fn is_due(&mut self, at_ns: u64) -> bool {
        let period_ns = self.live.publish_period_ns();
        if at_ns + period_ns / 4 < self.due_ns {
            return false;
        }
        // On the grid, unless that has been left behind.
        self.due_ns = (self.due_ns + period_ns).max(at_ns + period_ns / 2);
        true
    }
}

impl Observer for Tap {
    fn row(&mut self, row: &Row<'_>) {
        if !self.is_due(row.at_ns) {
            return;
        }
        for (index, board) in row.boards.iter().enumerate() {
            let Some(reading) = board.fresh() else { continue };
            let state = State {
                index,
                asked_ns: reading.asked_ns,
                measured: reading.kpa,
                command: self.calibration.command_kpa(board.board, board.command),
            };
            if self.states.try_send(state).is_err() {
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_host::poller::{BoardRow, BoardSensors, BoardState, Outcome, Reading, VENTED};

    fn published(rate_hz: f64, at_ns: impl Iterator<Item = u64>) -> usize {
        let live = Arc::new(Live::default());
        live.set("publish_rate_hz", rate_hz);
        let (mut tap, _, _) = Tap::new(live, Calibration::default());
        at_ns.filter(|&at_ns| tap.is_due(at_ns)).count()
    }

    #[test]
    fn a_fast_bus_is_thinned_out_and_a_slow_one_is_not() {
        let second = |hz: u64| (0..hz).map(move |row| 5_000_000_000 + row * 1_000_000_000 / hz);
        assert_eq!(published(1_000.0, second(500)), 500);
        assert_eq!(published(1_000.0, second(1_000)), 1_000);
        assert!((995..=1_005).contains(&published(1_000.0, second(4_000))));
        // Jitter of 100 us at the same rate leaves nothing out.
        let jittered = second(1_000).map(|at_ns| at_ns + at_ns / 1_000_000 % 3 * 50_000);
        assert_eq!(published(1_000.0, jittered), 1_000);
    }

    #[test]
    fn the_bus_thread_does_not_wait_and_old_readings_are_not_passed_on() {
        let (mut tap, states, dropped) = Tap::new(Arc::default(), Calibration::default());
        let reading = Some(Reading { counts: VENTED, kpa: [1.0; 4], asked_ns: 7 });
        let row = |outcome| BoardRow {
            board: 0,
            command: VENTED,
            wanted: VENTED,
            outcome,
            reading,
            drives: None,
            sensors: BoardSensors::default(),
            state: BoardState::Present,
        };
        let boards = [row(Outcome::Lost), row(Outcome::Fresh), row(Outcome::NotAsked)];
        for cycle in 0..Tap::QUEUE as u64 + 10 {
            tap.row(&Row { cycle, at_ns: cycle, since_start_ns: cycle, boards: &boards });
        }
        assert_eq!(dropped.load(Ordering::Relaxed), 10);
        drop(tap);
        let states: Vec<_> = states.iter().collect();
        assert_eq!(states.len(), Tap::QUEUE);
        let expected = State { index: 1, asked_ns: 7, measured: [1.0; 4], command: [0.0; 4] };
        assert_eq!(states[0], expected);
    }
}
