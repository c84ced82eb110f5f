//! Which process something belongs to: a forked child has copies of what only its parent may use.

use crate::errors::PneuDriveError;
use pyo3::prelude::*;

/// The process that made something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Owner {
    pid: u32,
}

impl Owner {
    /// The calling process.
    pub fn this_process() -> Self {
        Self { pid: std::process::id() }
    }

    /// Whether the calling process is another one. It then has neither the threads nor the right to
    /// the port, and locks may be held for ever by threads that it does not have.
    pub fn is_other_process(self) -> bool {
        self.pid != std::process::id()
    }

    /// Refuses in a forked child, where `what` says what was made before the fork.
    ///
    /// # Errors
    /// `PneuDriveError` in any other process than the owner.
    pub fn check(self, what: &str) -> PyResult<()> {
        if !self.is_other_process() {
            return Ok(());
        }
        Err(PneuDriveError::new_err(format!(
            "this {what} belongs to process {}, from which this process ({}) was forked: only that one may drive the boards; \
             nothing was sent",
            self.pid,
            std::process::id()
        )))
    }
}
