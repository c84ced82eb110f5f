use pneudrive_host::line::Clock;
use pneudrive_host::notices::Notice;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};

/// What the writing thread is told beside rows.
#[derive(Debug)]
pub(super) enum Note {
    /// Something happened.
    Happened {
        /// On the line's clock, ns.
        at_ns: u64,
        /// What.
        notice: Notice,
    },
    /// There is nothing more to come.
    End,
}

/// Adds events to a recording, from any thread: what is done by key or page, how the run ended.
/// What happens on the bus is in the recording anyway. Clones add to the same recording.
#[derive(Debug, Clone, Default)]
pub struct Notes(Arc<Mutex<Option<Sender<Note>>>>);

impl Notes {
    pub(super) fn to(sender: Sender<Note>) -> Self {
        Self(Arc::new(Mutex::new(Some(sender))))
    }

    /// Adds an event that happens now. Where nothing is being recorded, or not any more, nothing is
    /// added.
    pub fn add(&self, notice: Notice) {
        self.send(Note::Happened { at_ns: Clock.now_ns(), notice });
    }

    /// There are no more.
    pub(super) fn end(&self) {
        self.send(Note::End);
        self.redirect(&Self::default());
    }

    /// Adds to the recording of `other` from now on.
    pub(super) fn redirect(&self, other: &Self) {
        let sender = other.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = sender;
    }

    fn send(&self, note: Note) {
        let sender = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(sender) = &*sender {
            // A recording that has failed takes no more.
            let _ = sender.send(note);
        }
    }
}
