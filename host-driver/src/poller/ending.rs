//! What a run was like, and how the boards are left.

use super::{BoardState, Pace, Polling};
use crate::bus::ExchangeError;
use crate::line::{Line, LineError};
use crate::statistics::{BoardStatistics, HistogramBin, SensorFigures, Statistics};

impl<L: Line> Polling<L> {
    /// What the run has been like so far.
    pub fn statistics(&self) -> Statistics {
        let boards: Vec<_> = self
            .rows
            .iter()
            .zip(&self.before)
            .zip(&self.without_reading)
            .map(|((row, &before), &without)| (row, self.bus.counters(row.board) - before, without))
            .collect();
        let now_ns = self.bus.line().now_ns();
        let wall_ns = now_ns.saturating_sub(self.start_ns.unwrap_or(now_ns));
        let cpu_ns = self.bus.line().cpu_time_ns().saturating_sub(self.cpu_before_ns);
        Statistics {
            devices: self.rows.len(),
            seconds: self.cycles.seconds(),
            baud: Some(self.bus.baud().get()),
            cycles: self.cycles.count(),
            loop_hz: self.cycles.rate(),
            cycle_us: self.cycles.times(),
            exchanges: boards.iter().map(|(_, counters, _)| counters.asked).sum(),
            lost: boards.iter().map(|(_, counters, _)| counters.lost()).sum(),
            rejected: boards.iter().map(|(_, counters, _)| counters.rejected()).sum(),
            missed_ticks: self.schedule.missed(),
            unsolicited_bytes: self.bus.unsolicited_bytes() - self.unsolicited_before,
            cpu_share: if wall_ns == 0 { 0.0 } else { cpu_ns as f64 / wall_ns as f64 },
            boards: boards
                .iter()
                .map(|(row, counters, without)| BoardStatistics {
                    sensors: self.options.sensors.map(|_| SensorFigures::new(&row.sensors, now_ns)),
                    ..BoardStatistics::new(row, *counters, *without, self.bus.format(row.board), now_ns)
                })
                .collect(),
        }
    }

    /// How long answers took, from the request to the answer's last byte as the host saw them:
    /// counts in bins evenly spaced on a logarithmic scale.
    pub fn round_trips(&self) -> Vec<HistogramBin> {
        self.round_trips.bins()
    }

    /// Ends the last cycle, so that it counts, and returns the statistics.
    pub fn finish(&mut self) -> Statistics {
        let now_ns = self.bus.line().now_ns();
        if self.next_is_due(now_ns) {
            self.close_cycle(now_ns);
        } else if let Some(started_ns) = self.open_cycle_ns.take() {
            // It is not known when the next one would have started.
            self.cycles.end(now_ns.saturating_sub(started_ns));
        }
        self.statistics()
    }

    /// Whether the next cycle would start now: one after the other, and nothing to wait for.
    fn next_is_due(&self, now_ns: u64) -> bool {
        self.options.pace == Pace::AsFastAsPossible && self.next_ready_ns() <= now_ns
    }

    /// Commands 0 kPa to all boards until they have confirmed it, as
    /// [`Bus::make_safe`](crate::bus::Bus::make_safe) does, which can take seconds with boards of
    /// the original kind. Boards that are missing are told once. A line that is gone gets a last
    /// try to come back.
    ///
    /// Returns the boards that did not confirm it.
    ///
    /// # Errors
    /// The line failed.
    pub fn make_safe(&mut self) -> Result<Vec<u8>, LineError> {
        if self.outage.take().is_some() {
            // If it fails, so does what follows, and says why.
            let _ = self.bus.reopen();
        }
        let with = |present: bool| {
            let rows = self.rows.iter();
            rows.filter(move |row| {
                (row.state == BoardState::Present || row.state == BoardState::Doubtful) == present
            })
            .map(|row| row.board)
            .collect::<Vec<_>>()
        };
        let (present, others) = (with(true), with(false));
        let mut silent = self.bus.make_safe(present.into_iter())?;
        for board in others {
            match self.bus.ping(board) {
                Ok(_) => {}
                Err(ExchangeError::Line(error)) => return Err(error),
                Err(_) => silent.push(board),
            }
        }
        Ok(silent)
    }
}
