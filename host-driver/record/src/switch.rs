//! Recordings that start and stop while boards are polled.

use super::{Description, Notes, PageColumns, RecordError, Recorder, RecorderOptions, RecordingSummary};
use pneudrive_host::Calibration;
use pneudrive_host::poller::{Event, Observer, Row};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use thiserror::Error;

/// Starts and stops recordings of a run, one at a time. The times in them are those of the run, not
/// of the recording.
pub struct RecordSwitch {
    boards: Vec<u8>,
    calibration: Calibration,
    options: RecorderOptions,
    taps: Sender<Option<Box<dyn Observer>>>,
    notes: Notes,
    failed: Arc<dyn Fn(&RecordError) + Send + Sync>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    running: Option<(PathBuf, Recorder)>,
    /// Told to stop; its last rows may still be on their way to the disk.
    finishing: Option<Recorder>,
    last: Option<Result<RecordingSummary, RecordError>>,
    /// The first recording of the run that failed.
    failure: Option<RecordError>,
}

impl std::fmt::Debug for RecordSwitch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RecordSwitch").field("boards", &self.boards).field("state", &self.state).finish()
    }
}

/// What a [`RecordSwitch`] is doing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SwitchStatus {
    /// The recording in progress.
    pub running: Option<PathBuf>,
    /// Whether the last rows of the recording before are still being written.
    pub finishing: bool,
    /// How the recording before ended.
    pub last: Option<Result<RecordingSummary, RecordError>>,
}

/// A recording that was not started or stopped.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SwitchError {
    /// Another one is in progress.
    #[error("{file} is being recorded; stop that first", file = .file.display())]
    Running {
        /// Its file.
        file: PathBuf,
    },
    /// There is nothing to stop.
    #[error("nothing is being recorded")]
    NotRunning,
    /// The file cannot be made.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// The end of the switch that sits on the bus thread.
struct Switched {
    taps: Receiver<Option<Box<dyn Observer>>>,
    tap: Option<Box<dyn Observer>>,
}

impl RecordSwitch {
    /// A switch for a poller of these boards, and the observer that is to be given to it.
    pub fn new(boards: &[u8], calibration: impl Into<Calibration>) -> (Self, Box<dyn Observer>) {
        let (sender, taps) = channel();
        let switch = Self {
            boards: boards.to_vec(),
            calibration: calibration.into(),
            options: RecorderOptions::default(),
            taps: sender,
            notes: Notes::default(),
            failed: Arc::new(|_| {}),
            state: Mutex::default(),
        };
        (switch, Box::new(Switched { taps, tap: None }))
    }

    /// The same switch, whose recordings say this of themselves.
    #[must_use]
    pub fn describe(mut self, description: Description) -> Self {
        self.options.description = description;
        self
    }

    /// The same switch, whose recordings have these columns, too, and this pressure of the
    /// atmosphere, kPa absolute ([`RecorderOptions::ambient_kpa`]).
    #[must_use]
    pub fn with_pages(mut self, pages: PageColumns, ambient_kpa: Option<f64>) -> Self {
        (self.options.pages, self.options.ambient_kpa) = (pages, ambient_kpa);
        self
    }

    /// The same switch, which calls `failed` as soon as writing a recording fails, on the thread
    /// that writes. Whoever starts a recording may have gone by then.
    #[must_use]
    pub fn on_failure(mut self, failed: impl Fn(&RecordError) + Send + Sync + 'static) -> Self {
        self.failed = Arc::new(failed);
        self
    }

    /// For adding events that do not happen on the bus to whatever is being recorded.
    pub fn notes(&self) -> Notes {
        self.notes.clone()
    }

    /// Starts recording to a new file, from the next cycle on.
    ///
    /// # Errors
    /// A recording is in progress, or the file cannot be made: see [`Recorder::create`]. Nothing is
    /// ever replaced.
    pub fn start(&self, path: &Path) -> Result<(), SwitchError> {
        let mut state = self.settled();
        if let Some((file, _)) = &state.running {
            return Err(SwitchError::Running { file: file.clone() });
        }
        let failed = Arc::clone(&self.failed);
        let failed = Box::new(move |error: &RecordError| failed(error));
        let (recorder, taps) =
            Recorder::create_told(path, &self.boards, &self.calibration, &self.options, failed)?;
        // A poller that has ended has dropped its end, and the recording stays empty.
        taps.into_iter().for_each(|tap| drop(self.taps.send(Some(tap))));
        self.notes.redirect(&recorder.notes());
        state.running = Some((path.to_owned(), recorder));
        Ok(())
    }

    /// Stops recording with the next cycle. [`status`](Self::status) tells when the file is
    /// complete.
    ///
    /// # Errors
    /// Nothing is being recorded.
    pub fn stop(&self) -> Result<(), SwitchError> {
        let mut state = self.settled();
        let Some((_, recorder)) = state.running.take() else { return Err(SwitchError::NotRunning) };
        let _ = self.taps.send(None);
        recorder.end();
        state.finishing = Some(recorder);
        Ok(())
    }

    /// What is going on now.
    pub fn status(&self) -> SwitchStatus {
        let state = self.settled();
        SwitchStatus {
            running: state.running.as_ref().map(|(file, _)| file.clone()),
            finishing: state.finishing.is_some(),
            last: state.last.clone(),
        }
    }

    /// Waits for the recording in progress, if there is one. To be called when the poller has
    /// ended.
    ///
    /// # Errors
    /// One of the run's recordings failed: this one, or the first of those before it.
    pub fn finish(&self) -> Option<Result<RecordingSummary, RecordError>> {
        let mut state = self.settled();
        let running = state.running.take().map(|(_, recorder)| recorder);
        let last = running.or(state.finishing.take()).map(Recorder::finish);
        match state.failure.take() {
            Some(failure) => Some(Err(failure)),
            None => last,
        }
    }

    /// The state, after what has ended by itself was put away.
    fn settled(&self) -> std::sync::MutexGuard<'_, State> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.running.as_ref().is_some_and(|(_, recorder)| recorder.has_failed()) {
            state.finishing = state.running.take().map(|(_, recorder)| recorder);
            let _ = self.taps.send(None);
        }
        if let Some(recorder) = state.finishing.take_if(|recorder| recorder.has_ended()) {
            let last = recorder.finish();
            if let Err(error) = &last {
                state.failure.get_or_insert_with(|| error.clone());
            }
            state.last = Some(last);
        }
        state
    }
}

impl Observer for Switched {
    fn row(&mut self, row: &Row<'_>) {
        while let Ok(tap) = self.taps.try_recv() {
            self.tap = tap;
        }
        if let Some(tap) = &mut self.tap {
            tap.row(row);
        }
    }

    fn event(&mut self, event: &Event<'_>) {
        if let Some(tap) = &mut self.tap {
            tap.event(event);
        }
    }
}

#[cfg(test)]
mod tests;
