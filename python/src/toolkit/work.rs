//! Long work: on a thread of its own, so that other Python threads run, Ctrl-C ends it, and
//! progress can be told.

use super::pool::Pool;
use crate::errors::PneuDriveError;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

/// How often the waiting side looks for signals and news.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// What is being done, and how much of it is done.
#[derive(Debug, Clone, Default, PartialEq)]
struct Step {
    done: u64,
    total: u64,
    what: String,
}

/// The line between the work and whoever waits for it.
#[derive(Debug, Default)]
pub struct Watch {
    cancel: AtomicBool,
    step: Mutex<Step>,
}

/// The payload of an unwinding that nobody needs to hear about.
struct Abandoned;

impl Watch {
    /// Set when nobody waits for the result any more.
    pub fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }

    /// Tells what is being done.
    pub fn begin(&self, what: &str) {
        let step = Step { what: what.to_owned(), ..Step::default() };
        *self.step.lock().unwrap_or_else(PoisonError::into_inner) = step;
    }

    /// Tells how far it is; a `total` of 0 means that nobody knows.
    pub fn tell(&self, done: u64, total: u64) {
        let mut step = self.step.lock().unwrap_or_else(PoisonError::into_inner);
        (step.done, step.total) = (done, total);
    }

    /// Adds to how far it is.
    pub fn advance(&self) {
        self.step.lock().unwrap_or_else(PoisonError::into_inner).done += 1;
    }

    /// Ends the work here when nobody waits for it, by unwinding without the panic hook: for work
    /// that takes no flag.
    pub fn checkpoint(&self) {
        if self.cancel.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Abandoned));
        }
    }

    fn step(&self) -> Step {
        self.step.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Runs `work` on a thread of its own. Meanwhile signals are handled, and `progress` is called with
/// (done, total, what) from the calling thread whenever there is news. An exception from either
/// abandons the work.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> PyResult<T> {
    let (pool, watch) = (Pool::of_this_process()?, Arc::new(Watch::default()));
    let (sender, receiver) = mpsc::sync_channel(1);
    let shared = Arc::clone(&watch);
    named_thread().spawn(move || perform(&pool, work, &shared, &sender)).map_err(no_thread)?;
    attend(py, progress, &watch, receiver)
}

/// The same for work on borrowed memory: after an exception, waits until the work has come to its
/// next checkpoint.
pub fn run_scoped<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<T> {
    let (pool, watch) = (Pool::of_this_process()?, Watch::default());
    let (sender, receiver) = mpsc::sync_channel(1);
    std::thread::scope(|scope| {
        named_thread().spawn_scoped(scope, || perform(&pool, work, &watch, &sender)).map_err(no_thread)?;
        attend(py, progress, &watch, receiver)
    })
}

fn named_thread() -> std::thread::Builder {
    std::thread::Builder::new().name("pneudrive-work".to_owned())
}

fn no_thread(error: std::io::Error) -> PyErr {
    PneuDriveError::new_err(format!("no thread for the work: {error}"))
}

/// Outcome of work that may have panicked.
type Outcome<T> = std::thread::Result<T>;

fn perform<T: Send>(
    pool: &Pool,
    work: impl FnOnce(&Watch) -> T + Send,
    watch: &Watch,
    sender: &mpsc::SyncSender<Outcome<T>>,
) {
    let outcome = catch_unwind(AssertUnwindSafe(|| pool.run(|| work(watch))));
    // Nobody listens after an interruption.
    let _ = sender.send(outcome);
}

/// Waits for the outcome.
fn attend<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    watch: &Watch,
    receiver: mpsc::Receiver<Outcome<T>>,
) -> PyResult<T> {
    let (mut receiver, mut told) = (receiver, Step::default());
    loop {
        let (outcome, back) = py.detach(move || (receiver.recv_timeout(LOOK_EVERY), receiver));
        receiver = back;
        match outcome {
            Ok(Ok(result)) => return Ok(result),
            Ok(Err(panic)) => return Err(internal(panic.as_ref())),
            Err(mpsc::RecvTimeoutError::Disconnected) => return Err(internal(&"its thread ended")),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
        }
        let step = watch.step();
        let news = (step != told).then(|| step.clone());
        let heard = py.check_signals().and_then(|()| match (progress, news) {
            (Some(progress), Some(Step { done, total, what })) => {
                progress.call1((done, total, what)).map(|_| ())
            }
            _ => Ok(()),
        });
        if let Err(exception) = heard {
            watch.cancel.store(true, Ordering::SeqCst);
            return Err(exception);
        }
        told = step;
    }
}

/// A defect of ours, as an exception instead of a backtrace.
fn internal(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "unknown".to_owned());
    PneuDriveError::new_err(format!("internal error, please report it: {text}"))
}
