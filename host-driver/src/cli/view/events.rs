use pneudrive_host::poller::{BoardState, Event, Observer, Row};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Lines about what happened, from the bus thread to whoever shows them.
pub struct Events {
    sender: Sender<String>,
    receiver: Mutex<Receiver<String>>,
}

struct Tap {
    sender: Sender<String>,
    /// Boards that have been reported missing.
    missing: BTreeSet<u8>,
}

impl Events {
    pub fn new() -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver: Mutex::new(receiver) }
    }

    pub fn observer(&self) -> impl Observer + use<> {
        Tap { sender: self.sender.clone(), missing: BTreeSet::new() }
    }

    /// The next line that has not been shown.
    pub fn next(&self) -> Option<String> {
        self.receiver.lock().ok()?.try_recv().ok()
    }
}

impl Observer for Tap {
    fn row(&mut self, _: &Row<'_>) {}

    fn event(&mut self, event: &Event<'_>) {
        let Event::Board { board, state, error } = event;
        // One failure is in the counters; it becomes news when the board stays away, and when it comes back.
        let line = match (state, error) {
            (BoardState::Missing, error) if self.missing.insert(*board) => {
                let why = error.map_or_else(String::new, |error| format!(" ({error})"));
                format!("board {board} is missing{why}")
            }
            (BoardState::Present, _) if self.missing.remove(board) => format!("board {board} answers again"),
            _ => return,
        };
        // Nobody listening any more is the end of the run.
        let _ = self.sender.send(line);
    }
}
