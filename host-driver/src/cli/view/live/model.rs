use super::{Question, Session};
use pneudrive_host::poller::Snapshot;
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::CHANNELS;
use std::collections::VecDeque;

/// What the picture is made of.
pub struct Model {
    pub session: Session,
    pub snapshot: Snapshot,
    pub statistics: Option<Statistics>,
    pub now_ns: u64,
    /// What the user has been asked.
    pub question: Option<Question>,
    /// First board shown, for buses with more boards than the screen has room for.
    pub first_board: usize,
    /// Pressures of each board's channels at each picture, kPa; `None` where the board had not answered lately.
    history: Vec<[VecDeque<Option<f64>>; CHANNELS]>,
    /// (time, cycles) of some pictures, for the loop rate.
    progress: VecDeque<(u64, u64)>,
    events: VecDeque<String>,
}

impl Model {
    /// Pictures remembered: 30 s at 20 pictures a second.
    const HISTORY: usize = 600;
    /// The loop rate is that of the last so many pictures: 1 s.
    const RATE_OVER: usize = 20;
    const EVENTS: usize = 100;
    /// A reading older than this is drawn as missing, ns.
    pub const OLD_NS: u64 = 100_000_000;

    pub fn new(session: Session) -> Self {
        Self {
            session,
            snapshot: Snapshot::default(),
            statistics: None,
            now_ns: 0,
            question: None,
            first_board: 0,
            history: Vec::new(),
            progress: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    pub fn sample(&mut self, snapshot: Snapshot, now_ns: u64) {
        self.history.resize_with(snapshot.boards.len(), Default::default);
        for (board, history) in snapshot.boards.iter().zip(&mut self.history) {
            let fresh = board.reading.filter(|reading| reading.age_ns(now_ns) <= Self::OLD_NS);
            for (channel, values) in history.iter_mut().enumerate() {
                push(values, fresh.map(|reading| reading.kpa[channel]), Self::HISTORY);
            }
        }
        push(&mut self.progress, (snapshot.since_start_ns, snapshot.cycle.unwrap_or(0)), Self::RATE_OVER + 1);
        self.snapshot = snapshot;
        self.now_ns = now_ns;
    }

    /// Cycles per second over the last second, Hz.
    pub fn loop_hz(&self) -> Option<f64> {
        let (first, last) = (self.progress.front()?, self.progress.back()?);
        let seconds = last.0.checked_sub(first.0).filter(|&ns| ns > 0)? as f64 * 1e-9;
        Some(last.1.checked_sub(first.1)? as f64 / seconds)
    }

    pub fn history(&self, board: usize, channel: usize) -> &VecDeque<Option<f64>> {
        &self.history[board][channel]
    }

    pub fn figures(&mut self, statistics: Statistics) {
        self.statistics = Some(statistics);
    }

    pub fn happened(&mut self, event: String) {
        let seconds = self.snapshot.since_start_ns as f64 * 1e-9;
        push(&mut self.events, format!("{seconds:.1} s: {event}"), Self::EVENTS);
    }

    pub fn events(&self) -> impl DoubleEndedIterator<Item = &String> {
        self.events.iter()
    }

    pub fn scroll(&mut self, by: isize) {
        let last = self.snapshot.boards.len().saturating_sub(1);
        self.first_board = self.first_board.saturating_add_signed(by).min(last);
    }
}

fn push<T>(values: &mut VecDeque<T>, value: T, most: usize) {
    values.push_back(value);
    while values.len() > most {
        values.pop_front();
    }
}
