//! A live page of a run, for browsers: what [`pneudrive_page`] serves, of a poller.
//!
//! ```text
//!   bus thread ──newest row──▶ Latest ──Monitor──▶ ┌────────────────┐
//!        ▲                                         │ pneudrive-page │ ◀──▶ browsers
//!        └── Override (atomics), RecordSwitch ◀────└────────────────┘
//! ```
//!
//! The bus thread does the same work whether somebody looks or not: it leaves its newest row where
//! the page finds it ([`Latest`](pneudrive_host::poller::Latest)), and waits for nothing that the
//! page holds.

mod moment;
mod recording;

pub use pneudrive_page::{BoardLabel, Control, Labels, Token, TokenError, UnitLabel};
pub use recording::Recording;

use pneudrive_host::Calibration;
use pneudrive_host::line::Clock;
use pneudrive_host::poller::{Commanding, Monitor, Override};
use pneudrive_page::{Moment, PageOptions, Refusal, Run, SetPoint, WatchMoment};
use pneudrive_record::watch::WatchStatus;
use pneudrive_record::{RecordError, RecordingSummary};
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError};

/// What is served.
pub struct WebOptions {
    /// Name of the boards' port, for people.
    pub port: String,
    /// Numbers of the boards in the poller's order.
    pub boards: Vec<u8>,
    /// Names and the unit, for people.
    pub labels: Labels,
    /// What counts mean: the poller's.
    pub calibration: Calibration,
    /// Host names under which the page may be asked for, besides addresses, `localhost` and this
    /// computer's own name.
    pub names: Vec<String>,
    /// Vents and, with `control`, commands. `None`: it is a recording, and nothing can be
    /// commanded.
    pub overriding: Option<Override>,
    /// Set points by hand and release of a vent, for clients that have the token. `None`: nobody.
    pub control: Option<Control>,
    /// Recordings by button. `None`: none.
    pub recording: Option<Recording>,
    /// File to which the whole run is recorded anyway.
    pub whole_run: Option<PathBuf>,
    /// How a watch of the rig stands. `None`: nothing is watched.
    pub watch: Option<WatchStatus>,
    /// Lines about what happens on the bus, to be shown on the page.
    pub lines: Option<Mutex<Receiver<String>>>,
    /// Gets a line about everything that was done from the page. Called on the server's threads.
    pub notice: Box<dyn Fn(String) + Send + Sync>,
}

/// An address that is ours, with nobody served yet.
#[derive(Debug)]
pub struct Listener(pneudrive_page::Listener);

/// A page that is being served. Ends when dropped.
pub struct Server {
    server: pneudrive_page::Server,
    recording: Option<Arc<Recording>>,
}

/// What the page looks at and acts on.
struct PolledRun {
    monitor: Monitor,
    clock: Clock,
    boards: Vec<u8>,
    calibration: Calibration,
    overriding: Option<Override>,
    watch: Option<WatchStatus>,
    lines: Option<Mutex<Receiver<String>>>,
    notice: Box<dyn Fn(String) + Send + Sync>,
}

impl Listener {
    /// Takes the address; port 0 is any free one.
    ///
    /// # Errors
    /// What the system says: the port is taken, the address is not ours.
    pub fn bind(address: SocketAddr) -> io::Result<Self> {
        pneudrive_page::Listener::bind(address).map(Self)
    }

    /// The address with its actual port.
    pub fn address(&self) -> SocketAddr {
        self.0.address()
    }

    /// Starts serving the run that `monitor` sees. `clock` is the clock of its rows.
    ///
    /// # Errors
    /// The system has no threads to give.
    pub fn serve(self, options: WebOptions, monitor: Monitor, clock: Clock) -> io::Result<Server> {
        let recording = options.recording.map(Arc::new);
        let recordings = recording.clone().map(recording::by_button);
        let page = PageOptions {
            port: options.port,
            boards: options.boards.clone(),
            full_scale_kpa: options.calibration.full_scale_kpa(&options.boards),
            labels: options.labels,
            names: options.names,
            control: options.control,
            recordings,
            whole_run: options.whole_run,
        };
        let run = PolledRun {
            monitor,
            clock,
            boards: options.boards,
            calibration: options.calibration,
            overriding: options.overriding,
            watch: options.watch,
            lines: options.lines,
            notice: options.notice,
        };
        Ok(Server { server: self.0.serve(page, Arc::new(run))?, recording })
    }
}

impl Server {
    /// The page's address, for people.
    pub fn url(&self) -> String {
        self.server.url()
    }

    /// Tells all clients that the run has ended, with a reason if it was not meant to, and ends. To
    /// be called when the poller has ended. Returns what became of a recording that was still in
    /// progress.
    pub fn end(self, reason: Option<&str>) -> Option<Result<RecordingSummary, RecordError>> {
        self.server.end(reason);
        self.recording.and_then(|recording| recording.switch.finish())
    }
}

impl Run for PolledRun {
    fn moment(&self) -> Option<Moment> {
        moment::of(&self.monitor.latest(), self.clock.now_ns(), &self.calibration, self.overriding.as_ref())
    }

    fn statistics(&self) -> serde_json::Value {
        // Statistics are plain figures, which JSON always holds.
        serde_json::to_value(self.monitor.statistics()).unwrap_or_default()
    }

    fn watch(&self) -> Option<WatchMoment> {
        let state = self.watch.as_ref()?.state();
        Some(WatchMoment { words: state.words(), warning: state.is_warning() })
    }

    fn lines(&self) -> Vec<String> {
        let lines = self.lines.as_ref().map(|lines| lines.lock().unwrap_or_else(PoisonError::into_inner));
        lines.map_or_else(Vec::new, |lines| lines.try_iter().collect())
    }

    fn vent(&self) -> bool {
        let Some(overriding) = &self.overriding else { return false };
        let is_new = overriding.commanding() != Commanding::Vented || overriding.returns();
        overriding.vent();
        is_new
    }

    fn release(&self) -> bool {
        let Some(overriding) = &self.overriding else { return false };
        let returns = overriding.returns();
        overriding.release();
        returns
    }

    fn set(&self, set_point: SetPoint) -> Result<f64, Refusal> {
        let SetPoint { board, channel, kpa } = set_point;
        let recorded = || Refusal::Conflict("this is a recording: nothing can be commanded".to_owned());
        let overriding = self.overriding.as_ref().ok_or_else(recorded)?;
        let scale = self.calibration.channel(board, channel);
        let counts = scale.counts(kpa).map_err(|error| Refusal::Unusable(error.to_string()))?;
        let index = self.boards.iter().position(|polled| *polled == board);
        let unknown = || Refusal::Unusable(format!("board {board} is not polled in this run"));
        overriding.set(index.ok_or_else(unknown)?, channel, counts).map_err(|e| moment::refusal(&e))?;
        Ok(scale.kpa(counts))
    }

    fn commanding(&self) -> pneudrive_page::Commanding {
        moment::commanding(self.overriding.as_ref())
    }

    fn notice(&self, line: String) {
        (self.notice)(line);
    }
}
