//! The recent past of a poller, written by the bus thread and read by Python, where neither waits
//! for the other.

use super::sensors::Reading;
use pneudrive_host::Calibration;
use pneudrive_host::poller::{Observer, Outcome, Row};
use pneudrive_protocol::CHANNELS;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One cycle.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Start of the cycle after the first, s.
    pub t_s: f64,
    /// Commands sent, kPa, board by board.
    pub commands: Vec<[f64; CHANNELS]>,
    /// Pressures answered in this cycle, kPa; NaN where a board did not answer or was not asked.
    pub pressures: Vec<[f64; CHANNELS]>,
    /// What the boards' sensors told in this cycle; empty where boards are not asked.
    pub sensors: Vec<Reading>,
}

/// The newest samples, as many as fit into the time that is kept.
#[derive(Debug, Default)]
pub struct Ring {
    samples: VecDeque<Sample>,
}

/// Shared between the bus thread, through [`History::writer`], and readers.
#[derive(Debug, Clone)]
pub struct History {
    ring: Arc<Mutex<Ring>>,
    keep_s: f64,
    has_sensors: bool,
}

impl History {
    /// Keeps the last `keep_s` seconds.
    pub fn new(keep_s: f64, has_sensors: bool) -> Self {
        Self { ring: Arc::default(), keep_s, has_sensors }
    }

    /// Whether boards are asked for their sensors.
    pub fn has_sensors(&self) -> bool {
        self.has_sensors
    }

    /// The observer that fills it.
    pub fn writer(&self, calibration: Calibration) -> Writer {
        Writer { history: self.clone(), calibration, waiting: Vec::new() }
    }

    /// A copy of what is kept.
    pub fn samples(&self) -> Vec<Sample> {
        self.lock().samples.iter().cloned().collect()
    }

    fn lock(&self) -> MutexGuard<'_, Ring> {
        self.ring.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The bus thread's side. It never waits: while somebody reads, samples wait with it.
pub struct Writer {
    history: History,
    calibration: Calibration,
    waiting: Vec<Sample>,
}

impl Observer for Writer {
    fn row(&mut self, row: &Row<'_>) {
        let t_s = row.since_start_ns as f64 * 1e-9;
        let pressures = row.boards.iter().map(|board| match (&board.reading, board.outcome) {
            (Some(reading), Outcome::Fresh) => reading.kpa,
            _ => [f64::NAN; CHANNELS],
        });
        self.waiting.push(Sample {
            t_s,
            commands: row
                .boards
                .iter()
                .map(|board| self.calibration.command_kpa(board.board, board.command))
                .collect(),
            pressures: pressures.collect(),
            sensors: match self.history.has_sensors {
                true => row.boards.iter().map(|board| Reading::new(&board.sensors)).collect(),
                false => Vec::new(),
            },
        });
        let Ok(mut ring) = self.history.ring.try_lock() else { return };
        ring.samples.extend(self.waiting.drain(..));
        while ring.samples.front().is_some_and(|oldest| oldest.t_s < t_s - self.history.keep_s) {
            ring.samples.pop_front();
        }
    }
}
