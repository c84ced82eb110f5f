use super::{FrontEnd, PtyOptions, SimError, SimReport};
use crate::rig::RigOptions;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// A simulator in a thread of the calling process, for `--port sim`. The caller talks to it through
/// the pty's bytes, as to any other port.
///
/// ```no_run
/// use pneudrive_sim::pty::{EmbeddedSim, PtyOptions};
/// use pneudrive_sim::rig::RigOptions;
///
/// let sim = EmbeddedSim::start(&RigOptions { boards: 3, ..RigOptions::default() }, &PtyOptions::default())?;
/// println!("{}", sim.path().display());
/// let report = sim.stop()?;
/// assert_eq!(report.bus.collisions, 0);
/// # Ok::<(), pneudrive_sim::pty::SimError>(())
/// ```
#[derive(Debug)]
pub struct EmbeddedSim {
    path: PathBuf,
    round_trip: Duration,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<SimReport, SimError>>>,
}

impl EmbeddedSim {
    /// Builds the rig, opens its port, and lets time run.
    ///
    /// # Errors
    /// The rig cannot be built, or the system gives no port or thread.
    pub fn start(rig: &RigOptions, options: &PtyOptions) -> Result<Self, SimError> {
        let mut front_end = FrontEnd::new(rig, options)?;
        let path = front_end.path().to_owned();
        let round_trip = front_end.round_trip();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let body = move || {
            front_end.run(&stopped, None)?;
            Ok(front_end.report())
        };
        let thread = thread::Builder::new().name("pneudrive-sim".to_owned()).spawn(body);
        let thread = thread.map_err(|source| SimError::Thread { source })?;
        Ok(Self { path, round_trip, stop, thread: Some(thread) })
    }

    /// The path of the port, to be opened like a serial port.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What requests are dated back by; 0 where bytes take no time.
    pub fn pty_round_trip(&self) -> Duration {
        self.round_trip
    }

    /// Stops it; says what happened on the bus.
    ///
    /// # Errors
    /// The pty failed while it ran.
    pub fn stop(mut self) -> Result<SimReport, SimError> {
        self.join()
    }

    fn join(&mut self) -> Result<SimReport, SimError> {
        self.stop.store(true, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(SimReport::default()),
        }
    }
}

impl Drop for EmbeddedSim {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // Who drops it does not want to know; a panic has been printed by its thread.
            let _ = thread.join();
        }
    }
}
