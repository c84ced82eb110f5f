use pneudrive_host::bus::OpenBusError;
use pneudrive_host::line::OpenError;
use pneudrive_host::poller::{BoardState, Event, Observer, Row};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Lines about what happened, from the bus thread to whoever shows them.
pub struct Events {
    sender: Sender<String>,
    receiver: Mutex<Receiver<String>>,
    /// Others who hear what happens on the bus.
    listeners: Vec<Sender<String>>,
}

/// Adds lines, from any thread.
#[cfg(feature = "web")]
#[derive(Clone)]
pub struct EventSender(Sender<String>);

struct Tap {
    senders: Vec<Sender<String>>,
    /// Boards that have been reported missing.
    missing: BTreeSet<u8>,
}

impl Events {
    pub fn new() -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver: Mutex::new(receiver), listeners: Vec::new() }
    }

    pub fn observer(&self) -> impl Observer + use<> {
        let senders = self.listeners.iter().chain([&self.sender]).cloned().collect();
        Tap { senders, missing: BTreeSet::new() }
    }

    /// What happens on the bus from now on, for somebody else too: from observers that are made after this, and nothing that is
    /// said by [`say`](Self::say).
    #[cfg(feature = "web")]
    pub fn listen(&mut self) -> Receiver<String> {
        let (sender, receiver) = channel();
        self.listeners.push(sender);
        receiver
    }

    /// For others who have something to say.
    #[cfg(feature = "web")]
    pub fn sender(&self) -> EventSender {
        EventSender(self.sender.clone())
    }

    /// Adds a line.
    #[cfg(feature = "web")]
    pub fn say(&self, line: impl Into<String>) {
        EventSender(self.sender.clone()).say(line);
    }

    /// The next line that has not been shown.
    pub fn next(&self) -> Option<String> {
        self.receiver.lock().ok()?.try_recv().ok()
    }
}

#[cfg(feature = "web")]
impl EventSender {
    /// Adds a line.
    pub fn say(&self, line: impl Into<String>) {
        // Nobody listening any more is the end of the run.
        let _ = self.0.send(line.into());
    }
}

impl Observer for Tap {
    fn row(&mut self, _: &Row<'_>) {}

    fn event(&mut self, event: &Event<'_>) {
        let line = match event {
            // One failure is in the counters; it becomes news when the board stays away, and when it comes back.
            Event::Board { board, state: BoardState::Missing, error } if self.missing.insert(*board) => {
                let why = error.map_or_else(String::new, |error| format!(" ({error})"));
                format!("board {board} is missing{why}")
            }
            Event::Board { board, state: BoardState::Present, .. } if self.missing.remove(board) => {
                format!("board {board} answers again")
            }
            Event::LineLost { error } => {
                format!("{error}; waiting for it to come back, the boards vent by their own command timeout")
            }
            Event::LineNotBack { error: OpenBusError::Port(OpenError::NotFound { .. }) } => return,
            Event::LineNotBack { error } => format!("the port cannot be used yet: {error}"),
            Event::LineBack { gone_ns } => {
                format!("the port is back after {:.1} s, polling goes on", seconds(*gone_ns))
            }
            Event::Stalled { by_ns } => format!(
                "the host stood still for {:.1} s: it was stopped, or the machine is overloaded",
                seconds(*by_ns)
            ),
            Event::CommandsStale => "nobody renews the commands: 0 kPa is commanded".to_owned(),
            Event::CommandsBack => "the commands are renewed again".to_owned(),
            _ => return,
        };
        for sender in &self.senders {
            // Nobody listening any more is the end of the run.
            let _ = sender.send(line.clone());
        }
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
