//! Printing that ends nothing: a reader that has seen enough (`| head`) is no failure, any other
//! fault of standard output is the exit status.

use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// `println!` without its panic.
macro_rules! outln {
    ($($arg:tt)*) => { $crate::print::put(format_args!("{}\n", format_args!($($arg)*))) };
}

/// `eprintln!` without its panic.
macro_rules! errln {
    ($($arg:tt)*) => { $crate::print::put_error(format_args!("{}\n", format_args!($($arg)*))) };
}

pub(crate) use {errln, outln};

/// Nobody reads standard output any more.
static CLOSED: AtomicBool = AtomicBool::new(false);
/// And not because somebody had read enough.
static FAILED: AtomicBool = AtomicBool::new(false);

/// Writes to standard output for as long as it takes anything.
pub fn put(text: std::fmt::Arguments<'_>) {
    if closed() {
        return;
    }
    let mut out = io::stdout();
    if let Err(error) = out.write_fmt(text).and_then(|()| out.flush()) {
        CLOSED.store(true, Ordering::SeqCst);
        if error.kind() != ErrorKind::BrokenPipe {
            FAILED.store(true, Ordering::SeqCst);
            errln!("error: standard output: {error}");
        }
    }
}

/// Writes to standard error, if anybody reads it.
pub fn put_error(text: std::fmt::Arguments<'_>) {
    let _ = io::stderr().write_fmt(text);
}

/// Has whoever read standard output gone?
pub fn closed() -> bool {
    CLOSED.load(Ordering::SeqCst)
}

/// Could something not be printed that somebody wanted to have?
pub fn failed() -> bool {
    FAILED.load(Ordering::SeqCst)
}
