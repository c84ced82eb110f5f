//! The loop itself: which board is asked when, and who is told.

use super::line_rate::LineRateSchedule;
use super::outage::{Outage, Try};
use super::page_share::PageSchedule;
use super::presence::Presence;
use super::schedule::Schedule;
use super::sensors::SensorSchedule;
use super::slew::{Slew, SlewOptions};
use super::{
    BoardRow, BoardSensors, BoardState, CommandSource, Event, Observer, Outcome, PollerOptions, Row,
    SourceStatus, VENTED,
};
use crate::bus::{Bus, Counters};
use crate::line::{Line, LineError};
use crate::statistics::{CycleStatistics, Durations};
use pneudrive_protocol::{CHANNELS, SensorScale};
use std::time::Duration;

/// Polls boards on the calling thread, one [`cycle`](Self::cycle) after the other.
/// [`Poller`](super::Poller) runs it on a thread of its own; benchmarks and tests, in virtual time,
/// call it themselves.
pub struct Polling<L: Line> {
    pub(super) bus: Bus<L>,
    pub(super) options: PollerOptions,
    pub(super) source: Box<dyn CommandSource>,
    pub(super) observers: Vec<Box<dyn Observer>>,
    pub(super) schedule: Schedule,
    pub(super) presence: Vec<Presence>,
    /// What is wanted of each board.
    pub(super) wanted: Vec<super::BoardCommand>,
    /// What the counts of each board's channels mean.
    pub(super) scales: Vec<[SensorScale; CHANNELS]>,
    /// What becomes of it on its way to the bus.
    pub(super) slews: Vec<Slew>,
    /// When each board is asked for its valves' drives.
    pub(super) drives: Vec<PageSchedule>,
    /// When each board is asked for its sensors.
    pub(super) sensors: Vec<SensorSchedule>,
    pub(super) line_rate: LineRateSchedule,
    pub(super) rows: Vec<BoardRow>,
    pub(super) cycles: CycleStatistics,
    pub(super) round_trips: Durations,
    pub(super) start_ns: Option<u64>,
    /// Start of the cycle that has not been counted yet, ns.
    pub(super) open_cycle_ns: Option<u64>,
    pub(super) cpu_before_ns: u64,
    pub(super) outage: Option<Outage>,
    /// Readings from before this are from before the line was lost, ns.
    pub(super) line_since_ns: u64,
    /// When the next cycle was due, ns.
    pub(super) due_ns: u64,
    /// When the host was last late, and by how much, ns: the worst within a second.
    pub(super) late: Option<(u64, u64)>,
    pub(super) stale: bool,
    /// Whether the vent latch was closed in the last cycle.
    pub(super) vented: bool,
    /// Boards that are sent 0 kPa since this cycle because they were not heard, and for how long
    /// they were not.
    pub(super) paused: Vec<u8>,
    pub(super) unheard: Duration,
    /// It has been told that a set point is sent one count lower.
    pub(super) lowered_told: bool,
    /// Cycles without a reading of each board.
    pub(super) without_reading: Vec<u64>,
    /// What had happened on the bus before.
    pub(super) before: Vec<Counters>,
    pub(super) unsolicited_before: u64,
}

impl<L: Line> Polling<L> {
    /// Standing still for so long is worth a line, ns: boards are taken for vented then, and filled
    /// again by a ramp.
    const STALL_NS: u64 = SlewOptions::PAUSE_NS;
    /// From here on being late is more than the scheduler's usual jitter, and may have cost
    /// answers, ns.
    const LATE_NS: u64 = 10_000_000;
    /// It explains what happens within so long after it, ns.
    const LATE_FOR_NS: u64 = 1_000_000_000;

    /// The boards and settings of `options`, commands from `source`.
    pub fn new(
        bus: Bus<L>,
        options: PollerOptions,
        source: Box<dyn CommandSource>,
        observers: Vec<Box<dyn Observer>>,
    ) -> Self {
        let timeout_ns = bus.times().answer_timeout_ns();
        let row = |&board| BoardRow {
            board,
            command: VENTED,
            wanted: VENTED,
            outcome: Outcome::NotAsked,
            reading: None,
            drives: None,
            sensors: BoardSensors::default(),
            state: BoardState::Unseen,
        };
        Self {
            schedule: Schedule::new(options.pace, 0),
            presence: vec![Presence::new(options.presence); options.boards.len()],
            wanted: vec![VENTED; options.boards.len()],
            scales: options.boards.iter().map(|&board| options.calibration.of(board)).collect(),
            slews: options.boards.iter().map(|&board| options.slew(board, timeout_ns)).collect(),
            drives: vec![PageSchedule::new(options.drives); options.boards.len()],
            sensors: vec![SensorSchedule::new(options.sensors); options.boards.len()],
            line_rate: LineRateSchedule::new(options.line_rate),
            rows: options.boards.iter().map(row).collect(),
            cycles: CycleStatistics::new(),
            round_trips: Durations::new(),
            start_ns: None,
            open_cycle_ns: None,
            cpu_before_ns: 0,
            outage: None,
            line_since_ns: 0,
            due_ns: u64::MAX,
            late: None,
            stale: false,
            vented: false,
            paused: Vec::with_capacity(options.boards.len()),
            unheard: Duration::ZERO,
            lowered_told: false,
            without_reading: vec![0; options.boards.len()],
            before: options.boards.iter().map(|&board| bus.counters(board)).collect(),
            unsolicited_before: bus.unsolicited_bytes(),
            bus,
            options,
            source,
            observers,
        }
    }

    /// When the next cycle is due, ns on the line's clock: by the pace, and not before a board can
    /// be asked.
    pub fn next_cycle_ns(&mut self) -> u64 {
        let now_ns = self.bus.line().now_ns();
        let Some(_) = self.start_ns else {
            self.begin(now_ns);
            return now_ns;
        };
        let scheduled = self.schedule.next_start(now_ns);
        self.due_ns = scheduled.max(self.next_ready_ns());
        self.due_ns
    }

    /// When a board can be asked, or the line be opened again.
    pub(super) fn next_ready_ns(&self) -> u64 {
        match &self.outage {
            Some(outage) => outage.next_try_ns(),
            None => (0..self.rows.len()).map(|index| self.ready_at_ns(index)).min().unwrap_or(0),
        }
    }

    fn begin(&mut self, now_ns: u64) {
        self.start_ns = Some(now_ns);
        self.schedule = Schedule::new(self.options.pace, now_ns);
        self.cpu_before_ns = self.bus.line().cpu_time_ns();
    }

    /// Asks every board that can be asked, then tells the observers. While the line is gone, tries
    /// to open it again first.
    ///
    /// # Errors
    /// The line failed, and is not to be opened again or cannot be. Everything else that goes wrong
    /// is in the row.
    pub fn cycle(&mut self) -> Result<SourceStatus, LineError> {
        let now_ns = self.bus.line().now_ns();
        if self.start_ns.is_none() {
            self.begin(now_ns);
        }
        // Time counts from the first cycle, not from when it was asked for.
        let is_first = self.open_cycle_ns.is_none() && self.cycles.count() == 0;
        let start_ns = self.start_ns.filter(|_| !is_first).unwrap_or(now_ns);
        self.start_ns = Some(start_ns);
        let due_ns = std::mem::replace(&mut self.due_ns, u64::MAX);
        self.stalled(now_ns, due_ns);
        self.close_cycle(now_ns);
        self.open_cycle_ns = Some(now_ns);
        let status = self.source.fill(now_ns - start_ns, &mut self.wanted);
        self.note_freshness(status);
        self.note_vent();
        if self.line_is_there() {
            for index in 0..self.rows.len() {
                if let Err(error) = self.visit(index) {
                    self.line_lost(error)?;
                    break;
                }
            }
            self.note_pause();
            if let Err(error) = self.look_after_line_rate() {
                self.line_lost(error)?;
            }
        }
        for (row, count) in self.rows.iter().zip(&mut self.without_reading) {
            *count += u64::from(row.fresh().is_none());
        }
        let cycle = self.cycles.count();
        let row = Row { cycle, at_ns: now_ns, since_start_ns: now_ns - start_ns, boards: &self.rows };
        self.observers.iter_mut().for_each(|observer| observer.row(&row));
        Ok(status)
    }

    /// Whether boards can be asked. If the line is gone and a try is due, tries.
    fn line_is_there(&mut self) -> bool {
        let Some(outage) = &mut self.outage else { return true };
        if self.bus.line().now_ns() < outage.next_try_ns() {
            return false;
        }
        match outage.attempt(&mut self.bus) {
            Try::Back { gone } => {
                self.outage = None;
                self.line_since_ns = self.bus.line().now_ns();
                for (row, presence) in self.rows.iter_mut().zip(&mut self.presence) {
                    presence.line_back();
                    row.state = presence.state();
                }
                if !self.options.resume {
                    self.options.vent.vent_after_outage();
                }
                self.tell(&Event::LineBack { gone });
                self.note_vent();
                true
            }
            Try::Refused(error) => {
                self.tell(&Event::LineNotBack { error: &error });
                false
            }
            Try::NotYet => false,
        }
    }

    /// No reading is of this cycle any more, and no board is there.
    fn line_lost(&mut self, error: LineError) -> Result<(), LineError> {
        for (row, presence) in self.rows.iter_mut().zip(&mut self.presence) {
            presence.line_lost();
            row.state = presence.state();
            row.outcome = Outcome::NotAsked;
            row.drives = None;
            row.sensors = BoardSensors::default();
        }
        match self.options.reopen {
            Some(policy) if self.bus.line().can_reopen() => {
                self.outage = Some(Outage::new(policy, self.bus.line().now_ns()));
                let boards = self.rows.iter().map(|row| row.board);
                let holding: Vec<u8> = boards.filter(|&board| self.bus.may_hold_for_ever(board)).collect();
                self.tell(&Event::LineLost { error: &error, holding: &holding });
                Ok(())
            }
            _ => Err(error),
        }
    }

    pub(super) fn tell(&mut self, event: &Event<'_>) {
        self.observers.iter_mut().for_each(|observer| observer.event(event));
    }

    /// Something that should have been over by `due_ns` is over now.
    pub(super) fn stalled(&mut self, now_ns: u64, due_ns: u64) {
        let by_ns = now_ns.saturating_sub(due_ns);
        if by_ns >= Self::LATE_NS && self.late_ns().is_none_or(|worst_ns| by_ns >= worst_ns) {
            self.late = Some((now_ns, by_ns));
        }
        if by_ns >= Self::STALL_NS {
            self.tell(&Event::Stalled { by: Duration::from_nanos(by_ns) });
        }
    }

    /// By how much the host was late at most within the last second.
    pub(super) fn late(&self) -> Option<Duration> {
        self.late_ns().map(Duration::from_nanos)
    }

    fn late_ns(&self) -> Option<u64> {
        let (at_ns, by_ns) = self.late?;
        (self.bus.line().now_ns() <= at_ns + Self::LATE_FOR_NS).then_some(by_ns)
    }

    fn note_pause(&mut self) {
        if self.paused.is_empty() {
            return;
        }
        let (boards, unheard) = (std::mem::take(&mut self.paused), std::mem::take(&mut self.unheard));
        self.tell(&Event::Paused { boards: &boards, unheard, host_late: self.late() });
        // With the room that it has.
        self.paused = boards;
        self.paused.clear();
    }

    fn note_freshness(&mut self, status: SourceStatus) {
        let stale = status == SourceStatus::Stale;
        if stale != std::mem::replace(&mut self.stale, stale) {
            self.tell(if stale { &Event::CommandsStale } else { &Event::CommandsBack });
        }
    }

    fn note_vent(&mut self) {
        let vented = self.options.vent.is_vented();
        if vented != std::mem::replace(&mut self.vented, vented) {
            self.tell(if vented { &Event::Vented } else { &Event::Released });
        }
    }

    /// A cycle lasts until the next one starts.
    pub(super) fn close_cycle(&mut self, now_ns: u64) {
        if let Some(started_ns) = self.open_cycle_ns.take() {
            self.cycles.add(now_ns.saturating_sub(started_ns));
        }
    }

    /// Lets go of the bus. Nothing is commanded to the boards any more.
    pub fn into_bus(self) -> Bus<L> {
        self.bus
    }

    /// The bus, between cycles.
    pub fn bus_mut(&mut self) -> &mut Bus<L> {
        &mut self.bus
    }
}
