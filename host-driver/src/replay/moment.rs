//! A recorded row as a poller's.

use super::RecordedRow;
use crate::Calibration;
use crate::poller::{BoardRow, BoardSensors, BoardState, Outcome, Reading, Row, SupplyPressure, VENTED};

/// The boards at a moment of the recording.
pub(super) struct Moments {
    calibration: Calibration,
    rows: Vec<BoardRow>,
    /// When each board answered last, and told its supply pressure, s of the recording.
    answered_s: Vec<Option<f64>>,
    supply_s: Vec<f64>,
    t_s: f64,
    /// Rows so far.
    cycles: u64,
}

impl Moments {
    /// A board that has not answered for so long was missing, s: the commands of boards whose host
    /// is silent for so long expire.
    const MISSING_S: f64 = 0.5;

    pub(super) fn new(boards: &[u8], calibration: Calibration) -> Self {
        let row = |&board| BoardRow {
            drives: None,
            sensors: BoardSensors::default(),
            board,
            command: VENTED,
            wanted: VENTED,
            outcome: Outcome::NotAsked,
            reading: None,
            state: BoardState::Unseen,
        };
        let rows: Vec<_> = boards.iter().map(row).collect();
        Self {
            calibration,
            answered_s: vec![None; rows.len()],
            supply_s: vec![0.0; rows.len()],
            rows,
            t_s: 0.0,
            cycles: 0,
        }
    }

    pub(super) fn boards(&self) -> &[BoardRow] {
        &self.rows
    }

    /// What has been is forgotten: rows of another time follow.
    pub(super) fn forget(&mut self) {
        self.answered_s.fill(None);
        for row in &mut self.rows {
            (row.reading, row.state, row.sensors) = (None, BoardState::Unseen, BoardSensors::default());
        }
    }

    pub(super) fn take(&mut self, recorded: &RecordedRow) {
        (self.t_s, self.cycles) = (recorded.t_s, self.cycles + 1);
        let times = self.answered_s.iter_mut().zip(&mut self.supply_s);
        for ((row, (answered_s, supply_s)), board) in self.rows.iter_mut().zip(times).zip(&recorded.boards) {
            row.command = board.command(&self.calibration);
            row.wanted = row.command;
            let answer = board.answer(&self.calibration);
            row.outcome = if answer.is_some() { Outcome::Fresh } else { Outcome::Lost };
            if let (Some(counts), Some(kpa)) = (answer, board.kpa) {
                row.reading = Some(Reading { counts, kpa, asked_ns: 0 });
                *answered_s = Some(recorded.t_s);
            }
            if let Some(kpa) = board.supply_kpa {
                row.sensors.supply = Some(SupplyPressure { kpa, measured_ns: 0 });
                *supply_s = recorded.t_s;
            }
            row.state = match *answered_s {
                None => BoardState::Unseen,
                Some(_) if answer.is_some() => BoardState::Present,
                Some(at_s) if recorded.t_s - at_s < Self::MISSING_S => BoardState::Doubtful,
                Some(_) => BoardState::Missing,
            };
        }
    }

    /// The row as if the moment were now: readings are as old as they were then.
    pub(super) fn now(&mut self, now_ns: u64) -> Row<'_> {
        let was = |at_s: f64| now_ns.saturating_sub(((self.t_s - at_s).max(0.0) * 1e9) as u64);
        let times = self.answered_s.iter().zip(&self.supply_s);
        for (row, (answered_s, supply_s)) in self.rows.iter_mut().zip(times) {
            if let (Some(reading), Some(at_s)) = (&mut row.reading, *answered_s) {
                reading.asked_ns = was(at_s);
            }
            if let Some(supply) = &mut row.sensors.supply {
                supply.measured_ns = was(*supply_s);
            }
        }
        let since_start_ns = (self.t_s.max(0.0) * 1e9) as u64;
        Row { cycle: self.cycles, at_ns: now_ns, since_start_ns, boards: &self.rows }
    }
}
