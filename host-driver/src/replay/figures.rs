//! What a run was like, as far as its rows tell.

use super::RecordedRow;
use super::moment::Moments;
use crate::bus::BoardFormat;
use crate::statistics::{BoardStatistics, CycleStatistics, Statistics};

/// Figures of the rows that have been shown.
pub(super) struct Figures {
    cycles: CycleStatistics,
    last_s: Option<f64>,
    /// Answers, and rows without one, of each board.
    boards: Vec<(u64, u64)>,
}

impl Figures {
    pub(super) fn new(boards: usize) -> Self {
        Self { cycles: CycleStatistics::new(), last_s: None, boards: vec![(0, 0); boards] }
    }

    pub(super) fn add(&mut self, row: &RecordedRow) {
        if let Some(last_s) = self.last_s.replace(row.t_s)
            && row.t_s > last_s
        {
            self.cycles.add(((row.t_s - last_s) * 1e9) as u64);
        }
        for ((answered, without), board) in self.boards.iter_mut().zip(&row.boards) {
            *(if board.kpa.is_some() { answered } else { without }) += 1;
        }
    }

    /// The rows that follow do not follow on those so far.
    pub(super) fn gap(&mut self) {
        self.last_s = None;
    }

    /// Requests and losses are those that rows tell of; what a bus counts otherwise is 0.
    pub(super) fn statistics(&self, moments: &Moments) -> Statistics {
        let boards =
            self.boards.iter().zip(moments.boards()).map(|(&(answered, without), row)| BoardStatistics {
                board: row.board,
                answered,
                lost: without,
                rejected: 0,
                state: row.state,
                age_us: None,
                rows_without_reading: without,
                frames: BoardFormat::Unknown,
                zero_kpa_confirmed: None,
                sensors: None,
            });
        let boards: Vec<_> = boards.collect();
        Statistics {
            devices: boards.len(),
            seconds: self.cycles.seconds(),
            baud: None,
            cycles: self.cycles.count(),
            loop_hz: self.cycles.rate(),
            cycle_us: self.cycles.times(),
            exchanges: boards.iter().map(|board| board.answered + board.lost).sum(),
            lost: boards.iter().map(|board| board.lost).sum(),
            rejected: 0,
            missed_ticks: 0,
            unsolicited_bytes: 0,
            cpu_share: 0.0,
            boards,
        }
    }
}
