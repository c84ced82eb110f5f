//! Recordings that start and stop while boards are polled.

use super::{RecordError, Recorder, RecordingSummary};
use crate::poller::{Event, Observer, Row};
use pneudrive_protocol::SensorScale;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};
use thiserror::Error;

/// Starts and stops recordings of a run, one at a time. The times in them are those of the run, not of the recording.
#[derive(Debug)]
pub struct RecordSwitch {
    boards: Vec<u8>,
    scale: SensorScale,
    taps: Sender<Option<Box<dyn Observer>>>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    running: Option<(PathBuf, Recorder)>,
    /// Told to stop; its last rows may still be on their way to the disk.
    finishing: Option<Recorder>,
    last: Option<Result<RecordingSummary, RecordError>>,
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
    pub fn new(boards: &[u8], scale: SensorScale) -> (Self, Box<dyn Observer>) {
        let (sender, taps) = channel();
        let switch = Self { boards: boards.to_vec(), scale, taps: sender, state: Mutex::default() };
        (switch, Box::new(Switched { taps, tap: None }))
    }

    /// Starts recording to a new file, from the next cycle on.
    ///
    /// # Errors
    /// A recording is in progress, or the file cannot be made: see [`Recorder::create`]. Nothing is ever replaced.
    pub fn start(&self, path: &Path) -> Result<(), SwitchError> {
        let mut state = self.settled();
        if let Some((file, _)) = &state.running {
            return Err(SwitchError::Running { file: file.clone() });
        }
        let (recorder, tap) = Recorder::create(path, &self.boards, self.scale, false)?;
        // A poller that has ended has dropped its end, and the recording stays empty.
        let _ = self.taps.send(Some(tap));
        state.running = Some((path.to_owned(), recorder));
        Ok(())
    }

    /// Stops recording with the next cycle. [`status`](Self::status) tells when the file is complete.
    ///
    /// # Errors
    /// Nothing is being recorded.
    pub fn stop(&self) -> Result<(), SwitchError> {
        let mut state = self.settled();
        let Some((_, recorder)) = state.running.take() else { return Err(SwitchError::NotRunning) };
        let _ = self.taps.send(None);
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

    /// Waits for the recording in progress, if there is one. To be called when the poller has ended.
    pub fn finish(&self) -> Option<Result<RecordingSummary, RecordError>> {
        let mut state = self.settled();
        let running = state.running.take().map(|(_, recorder)| recorder);
        running.or(state.finishing.take()).map(Recorder::finish)
    }

    /// The state, after what has ended by itself was put away.
    fn settled(&self) -> std::sync::MutexGuard<'_, State> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.running.as_ref().is_some_and(|(_, recorder)| recorder.has_failed()) {
            state.finishing = state.running.take().map(|(_, recorder)| recorder);
            let _ = self.taps.send(None);
        }
        if let Some(recorder) = state.finishing.take_if(|recorder| recorder.has_failed()) {
            state.last = Some(recorder.finish());
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
mod tests {
    use super::*;
    use crate::poller::{BoardRow, BoardState, Outcome, VENTED};
    use std::time::{Duration, Instant};

    fn cycle(observer: &mut dyn Observer, cycle: u64) {
        let board = BoardRow {
            board: 0,
            command: VENTED,
            outcome: Outcome::Lost,
            reading: None,
            state: BoardState::Present,
        };
        let at_ns = cycle * 1_000_000;
        observer.row(&Row { cycle, at_ns, since_start_ns: at_ns, boards: &[board] });
    }

    fn settled(switch: &RecordSwitch) -> SwitchStatus {
        let started = Instant::now();
        loop {
            let status = switch.status();
            if !status.finishing && status.running.is_none() {
                return status;
            }
            assert!(started.elapsed() < Duration::from_secs(60), "{status:?}");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn only_what_passes_between_start_and_stop_is_recorded() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.csv");
        let (switch, mut observer) = RecordSwitch::new(&[0], SensorScale::ORIGINAL);
        assert_eq!(switch.stop(), Err(SwitchError::NotRunning));
        cycle(&mut *observer, 0);
        switch.start(&file).unwrap();
        assert_eq!(switch.start(&file), Err(SwitchError::Running { file: file.clone() }));
        (1..4).for_each(|number| cycle(&mut *observer, number));
        switch.stop().unwrap();
        cycle(&mut *observer, 4);
        let status = settled(&switch);
        assert_eq!(status.last.unwrap().unwrap().rows, 3);
        let text = std::fs::read_to_string(&file).unwrap();
        let times: Vec<_> = text.lines().skip(1).filter_map(|line| line.split(',').next()).collect();
        assert_eq!(times, ["0.001000000", "0.002000000", "0.003000000"]);
        assert_eq!(switch.start(&file), Err(SwitchError::Record(RecordError::Exists { file: file.clone() })));
    }

    #[test]
    fn the_end_of_the_poller_ends_the_recording() {
        let folder = tempfile::tempdir().unwrap();
        let (switch, mut observer) = RecordSwitch::new(&[0], SensorScale::ORIGINAL);
        switch.start(&folder.path().join("run.csv")).unwrap();
        cycle(&mut *observer, 0);
        drop(observer);
        assert_eq!(switch.finish().unwrap().unwrap().rows, 1);
        assert!(switch.finish().is_none());
    }
}
