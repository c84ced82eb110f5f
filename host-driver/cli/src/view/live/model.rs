use super::jog::Jog;
use super::{Question, Session};
use pneudrive_host::poller::{Commanding, Snapshot};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::CHANNELS;
use std::collections::VecDeque;
use std::time::Duration;

/// What the picture is made of.
pub struct Model {
    pub session: Session,
    pub snapshot: Snapshot,
    pub statistics: Option<Statistics>,
    pub now_ns: u64,
    /// What the user has been asked.
    pub question: Option<Question>,
    /// Whether the keys are explained.
    pub help: bool,
    /// Whether it is a recording: nothing is commanded.
    pub is_recording: bool,
    /// The selected channel, counted over all boards.
    pub selected: usize,
    /// Set points by keys.
    pub jog: Jog,
    /// A set point that is being typed, in the unit for people.
    pub typed: String,
    /// What the last key led to, and until when it is shown, ns.
    message: Option<(String, u64)>,
    /// How many of the newest events are passed over.
    pub events_back: usize,
    /// Highest pressure or command of each board so far, kPa.
    highest_kpa: Vec<f64>,
    /// Pressures of each board's channels at each picture, kPa; `None` where the board had not
    /// answered lately.
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
    const EVENTS: usize = 500;
    /// How long a message stands, ns.
    const MESSAGE_NS: u64 = 5_000_000_000;
    /// A reading older than this is drawn as missing, ns.
    pub const OLD: Duration = Duration::from_millis(100);
    /// Full scales of bars where no limit says one, kPa.
    const SCALES_KPA: [f64; 8] = [20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 700.0];

    pub fn new(session: Session) -> Self {
        Self {
            session,
            snapshot: Snapshot::default(),
            statistics: None,
            now_ns: 0,
            question: None,
            help: false,
            is_recording: false,
            selected: 0,
            jog: Jog::default(),
            typed: String::new(),
            message: None,
            events_back: 0,
            highest_kpa: Vec::new(),
            history: Vec::new(),
            progress: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    pub fn sample(&mut self, snapshot: Snapshot, now_ns: u64) {
        self.history.resize_with(snapshot.boards.len(), Default::default);
        self.highest_kpa.resize(snapshot.boards.len(), 0.0);
        let calibration = &self.session.setup.calibration;
        for ((board, history), highest) in
            snapshot.boards.iter().zip(&mut self.history).zip(&mut self.highest_kpa)
        {
            let fresh = board.reading.filter(|reading| reading.age(now_ns) <= Self::OLD);
            let commands = calibration.command_kpa(board.board, board.wanted);
            for (channel, values) in history.iter_mut().enumerate() {
                let kpa = fresh.map(|reading| reading.kpa[channel]);
                *highest = highest.max(commands[channel]).max(kpa.unwrap_or(0.0));
                push(values, kpa, Self::HISTORY);
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

    /// Where the bars of the board at `index` end, kPa: at its highest limit, or a little above
    /// what has been.
    pub fn scale_kpa(&self, index: usize) -> f64 {
        let Some(board) = self.snapshot.boards.get(index) else { return Self::SCALES_KPA[0] };
        let limits = self.session.limits.of(board.board);
        let limit = limits.iter().map(|limit| limit.max_kpa).fold(0.0, f64::max);
        if limit.is_finite() && limit > 0.0 {
            return limit;
        }
        let highest = self.highest_kpa.get(index).copied().unwrap_or(0.0);
        let [.., last] = Self::SCALES_KPA;
        Self::SCALES_KPA.into_iter().find(|&scale| scale >= highest).unwrap_or(last)
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
        // Who looks at old ones goes on looking at them.
        if self.events_back > 0 {
            self.scroll_events(1);
        }
    }

    pub fn events(&self) -> impl DoubleEndedIterator<Item = &String> {
        self.events.iter()
    }

    pub fn scroll_events(&mut self, by: isize) {
        let most = self.events.len().saturating_sub(1);
        self.events_back = self.events_back.saturating_add_signed(by).min(most);
    }

    pub fn say(&mut self, message: impl Into<String>) {
        self.message = Some((message.into(), self.now_ns + Self::MESSAGE_NS));
    }

    pub fn message(&self) -> Option<&str> {
        self.message.as_ref().filter(|(_, until)| self.now_ns < *until).map(|(message, _)| message.as_str())
    }

    pub fn select(&mut self, by: isize) {
        let last = (self.snapshot.boards.len() * CHANNELS).saturating_sub(1);
        self.selected = self.selected.saturating_add_signed(by).min(last);
        self.typed.clear();
        if self.jog.armed().is_some_and(|board| board != self.selected / CHANNELS) {
            self.jog.disarm();
        }
    }

    /// The selected channel: its board's place, and the channel.
    pub fn place(&self) -> (usize, usize) {
        (self.selected / CHANNELS, self.selected % CHANNELS)
    }

    pub fn is_vented(&self) -> bool {
        self.session.overriding.commanding() == Commanding::Vented
    }
}

fn push<T>(values: &mut VecDeque<T>, value: T, most: usize) {
    values.push_back(value);
    while values.len() > most {
        values.pop_front();
    }
}
