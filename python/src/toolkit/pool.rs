//! Threads that simulate, also in a forked child, where those of the parent do not exist.

use crate::errors::PneuDriveError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::cell::RefCell;
use std::mem;
use std::sync::{Arc, OnceLock};

/// The process that imported the module. Rayon's own pool is its.
static IMPORTER: OnceLock<u32> = OnceLock::new();

thread_local! {
    /// The pool of a forked child, and whose it is. Kept by each thread that asks for one: a lock
    /// could be held for ever by a thread that a fork left behind.
    static CHILDS: RefCell<Option<(u32, Arc<ThreadPool>)>> = const { RefCell::new(None) };
}

/// Threads for one piece of work.
#[derive(Clone)]
pub struct Pool {
    /// `None` for Rayon's own.
    threads: Option<Arc<ThreadPool>>,
}

/// To be called when the module is imported.
pub fn imported() {
    IMPORTER.get_or_init(std::process::id);
}

impl Pool {
    /// Rayon's own threads; in a forked child threads of its own, as many as `RAYON_NUM_THREADS`
    /// says or there are cores.
    ///
    /// # Errors
    /// `PneuDriveError` if the system has no threads to give.
    pub fn of_this_process() -> PyResult<Self> {
        let pid = std::process::id();
        if *IMPORTER.get_or_init(|| pid) == pid {
            return Ok(Self { threads: None });
        }
        CHILDS.with_borrow_mut(|childs| {
            if let Some((owner, threads)) = childs
                && *owner == pid
            {
                return Ok(Self { threads: Some(Arc::clone(threads)) });
            }
            let threads = ThreadPoolBuilder::new().build();
            let threads = threads
                .map_err(|error| PneuDriveError::new_err(format!("no threads to simulate on: {error}")))?;
            let threads = Arc::new(threads);
            // The pool of a parent that is a forked child itself must not be taken down from here.
            mem::forget(childs.replace((pid, Arc::clone(&threads))));
            Ok(Self { threads: Some(threads) })
        })
    }

    /// Runs `work` where Rayon's parallel iterators use these threads.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.threads {
            None => work(),
            Some(threads) => threads.install(work),
        }
    }
}
