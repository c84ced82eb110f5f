//! How the watch stands, for views and diagnostics.

use super::line::{Line, Says};
use std::sync::{Arc, Mutex, PoisonError};

/// How it stands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WatchState {
    /// Channels that are to be watched.
    pub channels: usize,
    /// Channels on which what is usual has been learnt.
    pub watched: usize,
    /// Changes so far.
    pub changes: usize,
    /// The last change.
    pub latest: Option<LatestChange>,
    /// Rows that the program was too slow for.
    pub rows_left_out: u64,
    /// Why nothing is watched any more, where it was not meant to end.
    pub failed: Option<String>,
}

/// A change.
#[derive(Debug, Clone, PartialEq)]
pub struct LatestChange {
    /// The channel, as in `b0c2`.
    pub channel: String,
    /// When it was found, s since the start of the run.
    pub t_s: f64,
    /// Since when, on the same axis, s.
    pub since_s: f64,
    /// The most probable effect; `something_else` where none of the catalogue explains it.
    pub effect: String,
    /// Its probability, 0 to 1.
    pub probability: f64,
    /// The whole sentence.
    pub text: String,
}

impl WatchState {
    /// In a few words, for a line of a view.
    pub fn words(&self) -> String {
        match (&self.failed, &self.latest) {
            (Some(_), _) => "watch FAILED".to_owned(),
            (None, Some(LatestChange { channel, since_s, effect, probability, .. })) => format!(
                "{channel} CHANGED since {since_s:.0} s: {effect} {:.0} %",
                (100.0 * probability).min(99.0)
            ),
            (None, None) if self.watched < self.channels => {
                format!("watch learns ({} of {})", self.watched, self.channels)
            }
            (None, None) => "watched".to_owned(),
        }
    }

    /// Whether somebody should look after the rig, or the watch.
    pub fn is_warning(&self) -> bool {
        self.failed.is_some() || self.latest.is_some()
    }

    pub(super) fn take(&mut self, line: &Line) {
        match &line.says {
            Says::Begin { channels } => self.channels = channels.len(),
            // After a change a channel is learnt anew, and said again.
            Says::Learnt => self.watched = (self.watched + 1).min(self.channels),
            Says::Changed { channel, t_s, since_s, explanations } => {
                self.changes += 1;
                let best = explanations.first();
                self.latest = Some(LatestChange {
                    channel: channel.clone(),
                    t_s: *t_s,
                    since_s: *since_s,
                    effect: best.map_or_else(|| "something_else".to_owned(), |best| best.effect.clone()),
                    probability: best.map_or(0.0, |best| best.probability),
                    text: line.text.clone(),
                });
            }
            Says::End | Says::Other => {}
        }
    }
}

/// The state, seen from several threads.
#[derive(Debug, Clone, Default)]
pub struct WatchStatus(Arc<Mutex<WatchState>>);

impl WatchStatus {
    /// How it stands now.
    pub fn state(&self) -> WatchState {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn change(&self, how: impl FnOnce(&mut WatchState)) {
        how(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_follows_what_is_said() {
        let mut state = WatchState::default();
        let mut take = |rest: &str| {
            let text = format!(r#"{{"schema":"pneudrive-watch/1","text":"a sentence",{rest}}}"#);
            state.take(&Line::parse(&text).unwrap());
            state.words()
        };
        assert_eq!(take(r#""kind":"begin","channels":["b0c0","b0c2"]"#), "watch learns (0 of 2)");
        assert_eq!(take(r#""kind":"learnt","channel":"b0c0""#), "watch learns (1 of 2)");
        assert_eq!(take(r#""kind":"learnt","channel":"b0c2""#), "watched");
        let changed = r#""kind":"changed","channel":"b0c2","t_s":700.0,"since_s":641.2,
            "explanations":[{"effect":"exhaust_leak","probability":0.83}]"#;
        assert_eq!(take(changed), "b0c2 CHANGED since 641 s: exhaust_leak 83 %");
        assert!(state.is_warning() && state.changes == 1);
        state.failed = Some("it ended".into());
        assert_eq!(state.words(), "watch FAILED");
    }
}
