//! Waiting for what the bus thread does, with signals handled.

use super::ending::{LOOK_EVERY, Signals};
use crate::errors::CommandError;
use pyo3::prelude::*;
use std::time::{Duration, Instant};

/// How often a caller that waits looks whether there is a new row: short beside the cycles of a
/// bus, long beside a look.
pub const LOOK_FOR_ROWS_EVERY: Duration = Duration::from_micros(300);

/// How long the first figures of a run are waited for: the bus thread makes them at the end of its
/// cycle.
pub const FIGURES_WITHIN: Duration = Duration::from_secs(1);

/// Looks until `found` finds something or `until` has come, running the handlers of signals. Call
/// it without the interpreter's lock.
pub fn look<T>(every: Duration, until: Instant, mut found: impl FnMut() -> Option<T>) -> PyResult<Option<T>> {
    let mut signals_at = Instant::now() + LOOK_EVERY;
    loop {
        if let Some(found) = found() {
            return Ok(Some(found));
        }
        let now = Instant::now();
        if now >= until {
            return Ok(None);
        }
        if now >= signals_at {
            Signals::Handled.look()?;
            signals_at = now + LOOK_EVERY;
        }
        std::thread::sleep(every);
    }
}

/// A time that Python gave.
pub fn patience(name: &str, seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds)
        .ok()
        .filter(|patience| patience.as_secs() <= MOST_PATIENCE_S)
        .ok_or_else(|| {
            CommandError::new_err(format!("{name} is {seconds} s; it must be 0 to {MOST_PATIENCE_S} s"))
        })
}

/// A year and a bit: whoever means for ever says None.
pub const MOST_PATIENCE_S: u64 = 40_000_000;
