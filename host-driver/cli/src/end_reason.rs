use crate::failure::Failure;
use crate::output::errln;
use crate::view::{EndedBy, EventSender};
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::{Conclusion, Finished};
use serde::Serialize;

/// Why a run ended: `ended` of the JSON object, and the first word of a recording's last event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EndReason {
    /// `--duration` was over.
    Duration,
    /// The trajectory was over.
    Trajectory,
    /// Ctrl-C as a signal, SIGTERM or SIGHUP.
    Signal,
    /// A key in the live view.
    Key,
    /// The terminal, or whatever read the lines, has closed or failed.
    Terminal,
    /// The port failed and was not to be opened again.
    Line,
    /// A recording could not be written any more.
    Recording,
    /// A fault of the program.
    Panic,
}

/// What there is to see when the view has ended.
pub struct Seen {
    /// What the view says; `None` if it failed.
    pub ended_by: Option<EndedBy>,
    /// Whether a signal came.
    pub signal: bool,
    /// Whether the time of `--duration` is over.
    pub time_is_over: bool,
}

impl EndReason {
    /// Why the run ended, now that it has.
    pub fn of(seen: &Seen, finished: Option<&Finished>) -> Self {
        let failed = finished.is_some_and(|finished| finished.error.is_some());
        match seen.ended_by {
            _ if finished.is_none() => Self::Panic,
            Some(EndedBy::Key) => Self::Key,
            Some(EndedBy::Terminal) | None => Self::Terminal,
            Some(EndedBy::Stop) if seen.signal => Self::Signal,
            Some(EndedBy::Stop) => Self::Recording,
            Some(EndedBy::Poller) if failed => Self::Line,
            Some(EndedBy::Poller) if seen.time_is_over => Self::Duration,
            Some(EndedBy::Poller) => Self::Trajectory,
        }
    }

    /// Adds to recordings how the boards are left, and the reason.
    pub fn note(self, events: &EventSender, finished: Option<&Finished>) {
        let not_safe = finished.map(|finished| finished.not_safe.as_slice()).unwrap_or_default();
        if !not_safe.is_empty() {
            let boards: Vec<_> = not_safe.iter().map(u8::to_string).collect();
            let text = format!("0 kPa was not confirmed by board(s) {}", boards.join(", "));
            events.note(&Notice::new(NoticeKind::NotSafe, text));
        }
        events.note(&self.notice());
    }

    fn notice(self) -> Notice {
        let text = match self {
            Self::Duration => "duration: the time asked for was over",
            Self::Trajectory => "trajectory: its last row was commanded",
            Self::Signal => "signal: Ctrl-C, SIGTERM or SIGHUP",
            Self::Key => "key: ended from the keyboard",
            Self::Terminal => "terminal: it closed, or whatever read the lines did",
            Self::Line => "line: the port failed",
            Self::Recording => "recording: it could not be written any more",
            Self::Panic => "panic: a fault of the program",
        };
        Notice::new(NoticeKind::End, text)
    }
}

/// Says what is to be said of the boards at the end of a run.
///
/// # Errors
/// The line failed, or a board may be under pressure.
pub fn concluded(finished: &Finished) -> Result<(), Failure> {
    let Conclusion { failures, remark, .. } = finished.conclusion();
    let mut failures = failures.into_iter();
    let first = failures.next();
    for warning in failures.chain(remark) {
        errln!("warning: {warning}");
    }
    first.map_or(Ok(()), |first| Err(Failure::running(first)))
}
