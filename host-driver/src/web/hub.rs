//! Where the newest picture lies, for any number of clients.

use super::history::History;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The newest of everything, already as text. Writers replace; readers take what is new to them and may miss what was replaced.
#[derive(Debug, Default)]
pub(super) struct Hub {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    pictures: Newest,
    figures: Newest,
    end: Option<Arc<str>>,
    history: History,
}

#[derive(Debug, Default)]
struct Newest {
    number: u64,
    text: Option<Arc<str>>,
}

/// How far a reader has come.
#[derive(Debug, Default)]
pub(super) struct Seen {
    pictures: u64,
    figures: u64,
}

/// What is new to a reader.
#[derive(Debug, Default)]
pub(super) struct News {
    pub(super) picture: Option<Arc<str>>,
    pub(super) figures: Option<Arc<str>>,
    /// The run has ended, and why. Nothing comes after it.
    pub(super) end: Option<Arc<str>>,
}

impl Newest {
    fn replace(&mut self, text: String) {
        self.number += 1;
        self.text = Some(text.into());
    }

    fn after(&self, seen: &mut u64) -> Option<Arc<str>> {
        let number = std::mem::replace(seen, self.number);
        self.text.clone().filter(|_| number != self.number)
    }
}

impl Hub {
    /// Replaces the picture; `remember` may add to the history.
    pub(super) fn picture(&self, text: String, remember: impl FnOnce(&mut History)) {
        let mut state = self.state();
        state.pictures.replace(text);
        remember(&mut state.history);
        drop(state);
        self.changed.notify_all();
    }

    /// Replaces the figures. They go out with the next picture.
    pub(super) fn figures(&self, text: String) {
        self.state().figures.replace(text);
    }

    /// Tells everybody that it is over.
    pub(super) fn end(&self, reason: String) {
        self.state().end = Some(reason.into());
        self.changed.notify_all();
    }

    pub(super) fn has_ended(&self) -> bool {
        self.state().end.is_some()
    }

    /// What is new, as soon as there is something, or nothing after `patience`.
    pub(super) fn news(&self, seen: &mut Seen, patience: Duration) -> News {
        let nothing = |state: &mut State| state.pictures.number == seen.pictures && state.end.is_none();
        let (state, _) = self
            .changed
            .wait_timeout_while(self.state(), patience, nothing)
            .unwrap_or_else(PoisonError::into_inner);
        News {
            picture: state.pictures.after(&mut seen.pictures),
            figures: state.figures.after(&mut seen.figures),
            end: state.end.clone(),
        }
    }

    pub(super) fn history(&self) -> History {
        self.state().history.clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_reader_gets_the_newest_and_misses_the_others() {
        let (hub, mut seen) = (Hub::default(), Seen::default());
        assert!(hub.news(&mut seen, Duration::ZERO).picture.is_none());
        hub.picture("one".into(), |_| {});
        hub.figures("figures".into());
        hub.picture("two".into(), |_| {});
        let news = hub.news(&mut seen, Duration::ZERO);
        assert_eq!((news.picture.as_deref(), news.figures.as_deref()), (Some("two"), Some("figures")));
        hub.picture("three".into(), |_| {});
        let news = hub.news(&mut seen, Duration::ZERO);
        assert_eq!((news.picture.as_deref(), news.figures), (Some("three"), None));
        assert!(hub.news(&mut seen, Duration::ZERO).picture.is_none());
        hub.end("over".into());
        assert_eq!(hub.news(&mut seen, Duration::ZERO).end.as_deref(), Some("over"));
    }
}
