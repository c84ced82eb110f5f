//! Rows at the pace at which they were recorded.

use super::figures::Figures;
use super::moment::Moments;
use super::{RecordedBoard, RecordedRow};
use crate::Calibration;
use crate::line::Clock;
use crate::poller::{Latest, Monitor, Observer};
use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How a recording is shown.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PlayOptions {
    /// What the recording is called, for people.
    pub name: String,
    /// Numbers of the boards that are shown, ascending.
    pub boards: Vec<u8>,
    /// What counts meant.
    pub calibration: Calibration,
    /// How many times as fast as it was; above 0.
    pub speed: f64,
    /// Whether it begins anew when it is over.
    pub repeat: bool,
    /// Whether its last row stays until the player is dropped; otherwise the player finishes.
    pub stay: bool,
}

impl PlayOptions {
    /// Shows these boards of a recording once, as fast as it was.
    pub fn new(name: impl Into<String>, boards: Vec<u8>, calibration: impl Into<Calibration>) -> Self {
        let (name, calibration) = (name.into(), calibration.into());
        Self { name, boards, calibration, speed: 1.0, repeat: false, stay: false }
    }

    /// So many times as fast as it was; above 0.
    #[must_use]
    pub fn speed(mut self, speed: f64) -> Self {
        self.speed = speed;
        self
    }

    /// Begins anew when it is over, or not.
    #[must_use]
    pub fn repeat(mut self, repeat: bool) -> Self {
        self.repeat = repeat;
        self
    }

    /// Keeps its last row until the player is dropped, or finishes.
    #[must_use]
    pub fn stay(mut self, stay: bool) -> Self {
        self.stay = stay;
        self
    }
}

/// Shows a recording on a thread of its own, until it is dropped.
#[derive(Debug)]
pub struct Player {
    monitor: Monitor,
    control: Option<Sender<Control>>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Clone, Copy)]
enum Control {
    Pause,
    Skip(f64),
}

impl Player {
    /// Starts with the first row of those that `open` gives, each time from the beginning.
    /// `happened` gets `events` (their times, s, and texts) when their time comes, and what keeps
    /// rows from being read.
    ///
    /// # Errors
    /// The recording cannot be opened, has no rows, or the system has no thread to give.
    pub fn start<R>(
        mut open: impl FnMut() -> io::Result<R> + Send + 'static,
        options: PlayOptions,
        mut events: Vec<(f64, String)>,
        happened: impl FnMut(String) + Send + 'static,
    ) -> io::Result<Self>
    where
        R: Iterator<Item = io::Result<RecordedRow>> + 'static,
    {
        let Some(first) = open()?.next() else {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "no rows in it"));
        };
        let first_s = first?.t_s;
        events.sort_by(|one, other| one.0.total_cmp(&other.0));
        let latest = Latest::default();
        let monitor = Monitor::of(latest.clone());
        let (control, orders) = channel();
        let mut show = Show {
            open: Box::new(move || Ok(Box::new(open()?))),
            moments: Moments::new(&options.boards, options.calibration.clone()),
            figures: Figures::new(options.boards.len()),
            options,
            events,
            next_event: 0,
            latest,
            monitor: monitor.clone(),
            orders,
            happened: Box::new(happened),
            t_s: first_s,
            paused: false,
        };
        let run = move || show.run();
        let thread = std::thread::Builder::new().name("pneudrive-replay".into()).spawn(run)?;
        Ok(Self { monitor, control: Some(control), thread: Some(thread) })
    }

    /// The row that is shown, and figures of those that were. Whoever looks at readings finds them
    /// as old as they were then.
    pub fn monitor(&self) -> Monitor {
        self.monitor.clone()
    }

    /// Whether the last row has been shown and nothing follows.
    pub fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Stands still, or goes on.
    pub fn pause(&self) {
        self.tell(Control::Pause);
    }

    /// Goes so many seconds of the recording forward; back if negative.
    pub fn skip(&self, seconds: f64) {
        self.tell(Control::Skip(seconds));
    }

    fn tell(&self, order: Control) {
        if let Some(control) = &self.control {
            // A player that has finished does nothing more.
            let _ = control.send(order);
        }
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.control = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Why rows are not gone through any further.
enum Left {
    /// They are over.
    Over,
    /// Somebody wants to see those from this time on, s.
    To(f64),
    /// Nobody wants to see them.
    Dropped,
}

/// Rows, one after the other.
type Rows = Box<dyn Iterator<Item = io::Result<RecordedRow>>>;

/// What the thread works with.
struct Show {
    open: Box<dyn FnMut() -> io::Result<Rows> + Send>,
    options: PlayOptions,
    moments: Moments,
    figures: Figures,
    events: Vec<(f64, String)>,
    next_event: usize,
    latest: Latest,
    monitor: Monitor,
    orders: Receiver<Control>,
    happened: Box<dyn FnMut(String) + Send>,
    /// Time of the row that is shown, s.
    t_s: f64,
    paused: bool,
}

impl Show {
    /// A row that stands still is shown anew this often: its readings must not look old.
    const RENEW: Duration = Duration::from_millis(20);

    /// Later rows are as good as never.
    const FAR: Duration = Duration::from_secs(1_000_000_000);

    fn run(&mut self) {
        let mut from_s = f64::NEG_INFINITY;
        loop {
            let left = match (self.open)() {
                Ok(rows) => self.through(rows, from_s),
                Err(error) => {
                    (self.happened)(format!("{}: {error}", self.options.name));
                    Left::Over
                }
            };
            let left = match left {
                Left::Over if self.options.repeat => Left::To(f64::NEG_INFINITY),
                Left::Over if self.options.stay => self.at_end(),
                left => left,
            };
            match left {
                Left::To(t_s) => from_s = t_s,
                Left::Over | Left::Dropped => return,
            }
            self.figures.gap();
            self.moments.forget();
        }
    }

    /// Shows rows from `from_s` on, each at its time.
    fn through(&mut self, rows: Rows, from_s: f64) -> Left {
        let mut start: Option<(Instant, f64)> = None;
        let mut before = None;
        self.next_event = self.events.iter().take_while(|event| event.0 < from_s).count();
        for row in rows {
            let row = match row {
                Ok(row) => self.only_shown(row),
                Err(error) => {
                    (self.happened)(format!("the recording stops in the middle: {error}"));
                    break;
                }
            };
            if row.t_s < from_s {
                before = Some(row);
                continue;
            }
            let is_first = start.is_none();
            let (begun, begun_s) = *start.get_or_insert((Instant::now(), row.t_s));
            let due = (row.t_s - begun_s).max(0.0) / self.options.speed;
            let due = begun + Duration::try_from_secs_f64(due).unwrap_or(Self::FAR).min(Self::FAR);
            // The first row is shown even where it stands still then.
            let pausing = self.paused && !is_first;
            if pausing || due > Instant::now() + Duration::from_millis(1) {
                let until = (!pausing).then_some(due);
                match self.stand(until) {
                    Left::Over => {}
                    left => return left,
                }
                if until.is_none() {
                    // The time of a pause does not count.
                    start = Some((Instant::now(), row.t_s));
                }
            }
            self.take(&row);
        }
        if start.is_none()
            && let Some(last) = before
        {
            // Beyond the end.
            self.take(&last);
        }
        Left::Over
    }

    /// Shows a row, then tells what had happened by then.
    fn take(&mut self, row: &RecordedRow) {
        self.t_s = row.t_s;
        self.figures.add(row);
        self.moments.take(row);
        self.show();
        self.tell_events();
    }

    /// Shows the last row until somebody wants to see another.
    fn at_end(&mut self) -> Left {
        loop {
            match self.stand(None) {
                Left::Over => self.paused = false,
                left => return left,
            }
        }
    }

    /// Shows the same moment until a time, without one until a pause is over.
    fn stand(&mut self, until: Option<Instant>) -> Left {
        loop {
            let now = Instant::now();
            let rest =
                until.map_or(Self::RENEW, |until| until.saturating_duration_since(now).min(Self::RENEW));
            match self.orders.recv_timeout(rest) {
                Err(RecvTimeoutError::Disconnected) => return Left::Dropped,
                Ok(Control::Pause) => {
                    self.paused = !self.paused;
                    // The row that was waited for is shown; the pause begins with the next one, or
                    // ends here.
                    return Left::Over;
                }
                Ok(Control::Skip(by_s)) => return Left::To(self.t_s + by_s),
                Err(RecvTimeoutError::Timeout) => self.show(),
            }
            if until.is_some_and(|until| Instant::now() >= until) {
                return Left::Over;
            }
        }
    }

    /// The boards that are shown, in their order.
    fn only_shown(&self, row: RecordedRow) -> RecordedRow {
        let find = |&board: &u8| {
            row.boards.iter().copied().find(|one| one.board == board).unwrap_or(RecordedBoard::silent(board))
        };
        RecordedRow { t_s: row.t_s, boards: self.options.boards.iter().map(find).collect() }
    }

    fn tell_events(&mut self) {
        while let Some((t_s, text)) = self.events.get(self.next_event)
            && *t_s <= self.t_s
        {
            (self.happened)(text.clone());
            self.next_event += 1;
        }
    }

    fn show(&mut self) {
        self.latest.row(&self.moments.now(Clock.now_ns()));
        if self.monitor.wants_statistics() {
            self.monitor.publish(self.figures.statistics(&self.moments));
        }
    }
}
