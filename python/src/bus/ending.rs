//! Venting on a thread of its own: it goes on to its end when whoever waits for it is interrupted.

use parking_lot::{Condvar, Mutex};
use pyo3::prelude::*;
use std::sync::Arc;
use std::time::Duration;

/// How often a waiting caller looks for signals.
pub const LOOK_EVERY: Duration = Duration::from_millis(50);

/// What a caller that waits does about signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signals {
    /// Their handlers run: Ctrl-C ends the waiting.
    Handled,
    /// They wait, because an object is being destroyed and nobody could be told.
    Left,
}

impl Signals {
    /// Runs the handlers of signals that have come, in the main thread.
    ///
    /// # Errors
    /// What a handler raised, such as `KeyboardInterrupt`.
    pub fn look(self) -> PyResult<()> {
        match self {
            Self::Handled => Python::attach(|py| py.check_signals()),
            Self::Left => Ok(()),
        }
    }
}

/// A result that is to come. Clones wait for the same one.
#[derive(Debug)]
pub struct Ending<T> {
    shared: Arc<(Mutex<Option<T>>, Condvar)>,
}

impl<T> Clone for Ending<T> {
    fn clone(&self) -> Self {
        Self { shared: Arc::clone(&self.shared) }
    }
}

impl<T: Clone + Send + 'static> Ending<T> {
    /// Starts `work`; on the calling thread if the system has no other to give.
    pub fn start(work: impl FnOnce() -> T + Send + 'static) -> Self {
        let ending = Self { shared: Arc::new((Mutex::new(None), Condvar::new())) };
        // Handed over through a place that both can reach, so that it is not lost with a thread
        // that does not start.
        let place = Arc::new(Mutex::new(Some(work)));
        let (theirs, their_place) = (ending.clone(), Arc::clone(&place));
        let perform = move || {
            let work = their_place.lock().take();
            if let Some(work) = work {
                theirs.set(work());
            }
        };
        let thread = std::thread::Builder::new().name("pneudrive-vent".to_owned());
        if thread.spawn(perform).is_err()
            && let Some(work) = place.lock().take()
        {
            ending.set(work());
        }
        ending
    }

    fn set(&self, result: T) {
        *self.shared.0.lock() = Some(result);
        self.shared.1.notify_all();
    }

    /// The result, if it is there.
    pub fn peek(&self) -> Option<T> {
        self.shared.0.lock().clone()
    }

    /// Waits for it. Call it without the interpreter's lock.
    ///
    /// # Errors
    /// What a signal's handler raised; the work goes on.
    pub fn wait(&self, signals: Signals) -> PyResult<T> {
        let (place, changed) = &*self.shared;
        loop {
            {
                let mut result = place.lock();
                if result.is_none() {
                    changed.wait_for(&mut result, LOOK_EVERY);
                }
                if let Some(result) = &*result {
                    return Ok(result.clone());
                }
            }
            signals.look()?;
        }
    }
}
