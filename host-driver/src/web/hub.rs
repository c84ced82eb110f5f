//! Where the newest picture lies, for any number of clients.

use super::history::History;
use std::collections::VecDeque;
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
    /// The last lines about what happened, and how many there were before them.
    lines: VecDeque<Arc<str>>,
    lines_before: u64,
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
    lines: u64,
}

/// What is new to a reader.
#[derive(Debug, Default)]
pub(super) struct News {
    pub(super) picture: Option<Arc<str>>,
    pub(super) figures: Option<Arc<str>>,
    pub(super) lines: Vec<Arc<str>>,
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
    /// Lines that are kept for who comes later.
    const LINES: usize = 20;

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

    /// Adds a line. It goes out with the next picture.
    pub(super) fn line(&self, text: String) {
        let mut state = self.state();
        state.lines.push_back(text.into());
        if state.lines.len() > Self::LINES {
            state.lines.pop_front();
            state.lines_before += 1;
        }
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
        let skip = usize::try_from(seen.lines.saturating_sub(state.lines_before)).unwrap_or(usize::MAX);
        seen.lines = state.lines_before + state.lines.len() as u64;
        News {
            lines: state.lines.iter().skip(skip).cloned().collect(),
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
        (0..25).for_each(|number| hub.line(number.to_string()));
        let lines = hub.news(&mut seen, Duration::ZERO).lines;
        assert_eq!((lines.len(), lines.first().map(|line| &**line)), (20, Some("5")));
        hub.line("25".into());
        assert_eq!(hub.news(&mut seen, Duration::ZERO).lines.len(), 1);
        assert!(hub.news(&mut seen, Duration::ZERO).lines.is_empty());
        hub.end("over".into());
        assert_eq!(hub.news(&mut seen, Duration::ZERO).end.as_deref(), Some("over"));
    }
}
