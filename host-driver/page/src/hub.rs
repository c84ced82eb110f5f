//! Where the newest picture lies, for any number of clients.

use crate::history::History;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::watch;

/// The newest of everything, already as text. Writers replace; readers take what is new to them and
/// may miss what was replaced.
#[derive(Debug, Default)]
pub(crate) struct Hub {
    state: Mutex<State>,
    changed: watch::Sender<Change>,
}

/// What readers wait for.
#[derive(Debug, Clone, Copy, Default)]
struct Change {
    picture: u64,
    ended: bool,
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
    /// Time of the newest picture since the run's first cycle, s.
    t_s: f64,
}

#[derive(Debug, Default)]
struct Newest {
    number: u64,
    text: Option<Arc<str>>,
}

/// How far a reader has come.
#[derive(Debug)]
pub(crate) struct Seen {
    changed: watch::Receiver<Change>,
    pictures: u64,
    figures: u64,
    lines: u64,
}

/// What is new to a reader.
#[derive(Debug, Default)]
pub(crate) struct News {
    pub(crate) picture: Option<Arc<str>>,
    pub(crate) figures: Option<Arc<str>>,
    pub(crate) lines: Vec<Arc<str>>,
    /// The run has ended, and why. Nothing comes after it.
    pub(crate) end: Option<Arc<str>>,
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
    /// Lines that are kept for clients that come later.
    const LINES: usize = 20;

    /// Replaces the picture, which is of `t_s` after the run's first cycle; `remember` may add to
    /// the history.
    pub(crate) fn picture(&self, t_s: f64, text: String, remember: impl FnOnce(&mut History)) {
        let mut state = self.state();
        state.t_s = t_s;
        state.pictures.replace(text);
        remember(&mut state.history);
        let picture = state.pictures.number;
        drop(state);
        self.changed.send_modify(|change| change.picture = picture);
    }

    /// Replaces the figures. They go out with the next picture.
    pub(crate) fn figures(&self, text: String) {
        self.state().figures.replace(text);
    }

    /// Adds a line with the time of the newest picture. It goes out with the next one.
    pub(crate) fn line(&self, text: &str) {
        let mut state = self.state();
        let t_s = (state.t_s * 10.0).floor() / 10.0;
        state.lines.push_back(serde_json::json!({ "t": t_s, "text": text }).to_string().into());
        if state.lines.len() > Self::LINES {
            state.lines.pop_front();
            state.lines_before += 1;
        }
    }

    /// Tells everybody that it is over.
    pub(crate) fn end(&self, reason: String) {
        self.state().end = Some(reason.into());
        self.changed.send_modify(|change| change.ended = true);
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.state().end.is_some()
    }

    /// Waits for the end.
    pub(crate) async fn ended(&self) {
        // The sender lives as long as the hub.
        let _ = self.changed.subscribe().wait_for(|change| change.ended).await;
    }

    /// For a reader that has seen nothing yet.
    pub(crate) fn reader(&self) -> Seen {
        Seen { changed: self.changed.subscribe(), pictures: 0, figures: 0, lines: 0 }
    }

    /// Picture and figures, the newest that there are.
    pub(crate) fn newest(&self) -> (Option<Arc<str>>, Option<Arc<str>>) {
        let state = self.state();
        (state.pictures.text.clone(), state.figures.text.clone())
    }

    /// What is new, as soon as there is something, or nothing after `patience`.
    pub(crate) async fn news(&self, seen: &mut Seen, patience: Duration) -> News {
        let pictures = seen.pictures;
        let something = seen.changed.wait_for(|change| change.picture != pictures || change.ended);
        // Nothing new is an answer too.
        let _ = tokio::time::timeout(patience, something).await;
        let state = self.state();
        let skip = usize::try_from(seen.lines.saturating_sub(state.lines_before)).unwrap_or(usize::MAX);
        seen.lines = state.lines_before + state.lines.len() as u64;
        News {
            lines: state.lines.iter().skip(skip).cloned().collect(),
            picture: state.pictures.after(&mut seen.pictures),
            figures: state.figures.after(&mut seen.figures),
            end: state.end.clone(),
        }
    }

    pub(crate) fn history(&self) -> History {
        self.state().history.clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn now(hub: &Hub, seen: &mut Seen) -> News {
        hub.news(seen, Duration::ZERO).await
    }

    #[test]
    fn a_slow_reader_gets_the_newest_and_misses_the_others() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let hub = Hub::default();
            let mut seen = hub.reader();
            assert!(now(&hub, &mut seen).await.picture.is_none());
            hub.picture(0.0, "one".into(), |_| {});
            hub.figures("figures".into());
            hub.picture(1.25, "two".into(), |_| {});
            let news = now(&hub, &mut seen).await;
            assert_eq!((news.picture.as_deref(), news.figures.as_deref()), (Some("two"), Some("figures")));
            hub.picture(1.25, "three".into(), |_| {});
            let news = now(&hub, &mut seen).await;
            assert_eq!((news.picture.as_deref(), news.figures), (Some("three"), None));
            assert!(now(&hub, &mut seen).await.picture.is_none());
            assert_eq!(hub.newest().0.as_deref(), Some("three"));
            (0..25).for_each(|number| hub.line(&number.to_string()));
            let lines = now(&hub, &mut seen).await.lines;
            let first = lines.first().map(|line| &**line);
            assert_eq!((lines.len(), first), (20, Some(r#"{"t":1.2,"text":"5"}"#)));
            hub.line("25");
            assert_eq!(now(&hub, &mut seen).await.lines.len(), 1);
            assert!(now(&hub, &mut seen).await.lines.is_empty());
            hub.end("over".into());
            assert_eq!(now(&hub, &mut seen).await.end.as_deref(), Some("over"));
            hub.ended().await;
        });
    }
}
