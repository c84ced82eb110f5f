use crate::failure::Failure;
use pneudrive_host::bus::BoardFormat;
use pneudrive_host::statistics::Statistics;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

/// `print!` without its panic: see [`put`].
macro_rules! out {
    ($($arg:tt)*) => { $crate::output::put(format_args!($($arg)*)) };
}

/// `println!` without its panic: see [`put`].
macro_rules! outln {
    ($($arg:tt)*) => { $crate::output::put(format_args!("{}\n", format_args!($($arg)*))) };
}

/// `eprintln!` without its panic: a terminal that has closed must not keep the boards from being
/// vented.
macro_rules! errln {
    ($($arg:tt)*) => { $crate::output::put_error(format_args!("{}\n", format_args!($($arg)*))) };
}

pub(crate) use {errln, out, outln};

/// Writes to standard error, if anybody reads it.
pub fn put_error(text: std::fmt::Arguments<'_>) {
    let _ = std::io::stderr().write_fmt(text);
}

/// Standard output has failed.
static FAILED: AtomicBool = AtomicBool::new(false);

/// Whether something could not be written to standard output, which has been said.
pub fn failed() -> bool {
    FAILED.load(Ordering::Relaxed)
}

/// Writes to standard output. A reader that has seen enough (`| head`) is no failure; anything else
/// is said, once, and ends nothing, because what has been measured or recorded is not less for it.
/// Other commands than runs have it in their exit status: see [`failed`].
pub fn put(text: std::fmt::Arguments<'_>) {
    match std::io::stdout().write_fmt(text) {
        Err(error)
            if error.kind() != std::io::ErrorKind::BrokenPipe && !FAILED.swap(true, Ordering::Relaxed) =>
        {
            errln!("error: standard output: {error}");
        }
        _ => {}
    }
}

/// Version of the JSON objects. It grows when a key goes or changes its meaning; keys that are
/// added do not count.
const SCHEMA: u32 = 1;

/// What every JSON object begins with.
#[derive(Serialize)]
struct Object<'a, T> {
    schema: u32,
    program: &'static str,
    version: &'static str,
    #[serde(flatten)]
    content: &'a T,
}

/// One JSON object and a line end on standard output.
pub fn print_json(content: &impl Serialize) -> Result<(), Failure> {
    let (program, version) = ("pneudrive-host", env!("CARGO_PKG_VERSION"));
    let object = Object { schema: SCHEMA, program, version, content };
    let text = serde_json::to_string(&object).map_err(Failure::running)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{text}")
        .and_then(|()| out.flush())
        .map_err(|error| Failure::running(format!("standard output: {error}")))
}

/// The statistics of a run, for people.
pub fn statistics_text(statistics: &Statistics) -> String {
    let Statistics { loop_hz, cycle_us, .. } = statistics;
    let mut text = String::new();
    // Writing to a String does not fail.
    let _ = writeln!(
        text,
        "{} cycles of {} board(s) in {:.2} s: {:.1} +- {:.1} Hz (slowest {:.1} Hz)",
        statistics.cycles, statistics.devices, statistics.seconds, loop_hz.mean, loop_hz.std, loop_hz.min
    );
    let _ = writeln!(
        text,
        "cycle time: median {:.0} us, 99 % {:.0} us, 99.9 % {:.0} us, longest {:.0} us; {} starts missed",
        cycle_us.p50, cycle_us.p99, cycle_us.p999, cycle_us.max, statistics.missed_ticks
    );
    let _ = writeln!(
        text,
        "{} exchanges, {} lost, {} answers rejected, {} bytes unasked; bus thread {:.1} % of a core",
        statistics.exchanges,
        statistics.lost,
        statistics.rejected,
        statistics.unsolicited_bytes,
        100.0 * statistics.cpu_share
    );
    for board in &statistics.boards {
        let state = format!("{:?}", board.state).to_lowercase();
        let frames = match board.frames {
            BoardFormat::Unknown => "packet format unknown",
            BoardFormat::Checked => "checked packets",
            BoardFormat::Unchecked => "original packets",
        };
        let _ = writeln!(
            text,
            "  board {}: {state}, {} answered, {} lost, {} rejected, rows without a reading: {}, {frames}",
            board.board, board.answered, board.lost, board.rejected, board.rows_without_reading
        );
    }
    text
}
