//! Ctrl-C: the first asks long work to end with the best so far, the second ends the program.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;
use super::print::errln;

static STOP: AtomicBool = AtomicBool::new(false);

/// What a shell reports for a program ended by Ctrl-C: 128 + SIGINT.
const ENDED_BY_INTERRUPT: i32 = 130;

/// Catches Ctrl-C (and SIGTERM) from here on; the returned flag is set by the first.
pub fn watch() -> Result<&'static AtomicBool, Failure> {
    caught("stopping: the best so far is kept (once more to end at once)")
}

/// As [`watch`], for work that has nothing to keep.
pub fn watch_quietly() -> Result<&'static AtomicBool, Failure> {
    caught("stopping (once more to end at once)")
}

/// For work that writes its results at its end alone: Ctrl-C (and SIGTERM) end the program, which
/// says so, with status 1.
pub fn end_at_once() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        errln!("interrupted; there are no results yet, and nothing was written");
        std::process::exit(1);
    })
    .map_err(not_caught)
}

fn caught(says: &'static str) -> Result<&'static AtomicBool, Failure> {
    ctrlc::set_handler(move || {
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(ENDED_BY_INTERRUPT);
        }
        errln!("{says}");
    })
    .map_err(not_caught)?;
    Ok(&STOP)
}

fn not_caught(error: ctrlc::Error) -> Failure {
    Failure::running(format!("Ctrl-C cannot be caught: {error}"))
}

/// Fails with status 1 if the work was stopped; results have been written by then.
pub fn check(written: &str) -> Result<(), Failure> {
    if STOP.load(Ordering::SeqCst) {
        return Err(Failure::running(format!("stopped by request: {written} hold the best found so far")));
    }
    Ok(())
}
