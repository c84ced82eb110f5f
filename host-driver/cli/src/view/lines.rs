use super::{EndedBy, Events, Session, Watched};
use crate::failure::Failure;
use crate::output::errln;
use crate::setup::Setup;
use pneudrive_host::poller::{BoardRow, Snapshot};
use pneudrive_host::statistics::BoardStatistics;
use std::fmt::Write as _;
use std::io::Write as _;
use std::time::{Duration, Instant};

const LOOK_EVERY: Duration = Duration::from_millis(20);
const LINE_EVERY: Duration = Duration::from_secs(1);

/// One line a second; with `json` on standard error, because standard output belongs to the JSON
/// object.
pub fn show(
    session: &Session,
    json: bool,
    watched: Watched<'_>,
    events: &Events,
    stop: impl Fn() -> bool,
) -> Result<EndedBy, Failure> {
    let monitor = watched.monitor();
    let mut next = Instant::now() + LINE_EVERY;
    let mut before = Snapshot::default();
    let mut without = Vec::new();
    let say = |line: &str| -> Result<bool, Failure> {
        if json {
            errln!("{line}");
            return Ok(true);
        }
        match writeln!(std::io::stdout(), "{line}") {
            Ok(()) => Ok(true),
            Err(error) if reader_is_gone(&error) => Ok(false),
            Err(error) => Err(Failure::running(format!("standard output: {error}"))),
        }
    };
    // What was said before, such as where the page is, is no row of the table.
    while let Some(event) = events.next() {
        errln!("{event}");
    }
    if !say(&header(&session.setup))? {
        return Ok(EndedBy::Terminal);
    }
    loop {
        if stop() {
            return Ok(EndedBy::Stop);
        }
        if watched.is_finished() {
            return Ok(EndedBy::Poller);
        }
        std::thread::sleep(LOOK_EVERY);
        while let Some(event) = events.next() {
            errln!("{event}");
        }
        if Instant::now() >= next {
            next += LINE_EVERY;
            let now = monitor.latest();
            // As of the line before or a little later: whoever asks gets new figures next time.
            let counted = monitor.statistics().map_or_else(Vec::new, |statistics| statistics.boards);
            let new = newly_without(&without, &counted);
            let line = line(&before, &now, session.clock.now_ns(), &new, &session.setup);
            (before, without) = (now, counted);
            if !say(&line)? {
                return Ok(EndedBy::Terminal);
            }
        }
    }
}

/// A closed pipe, or a terminal that has closed.
fn reader_is_gone(error: &std::io::Error) -> bool {
    const EIO: i32 = rustix::io::Errno::IO.raw_os_error();
    error.kind() == std::io::ErrorKind::BrokenPipe || error.raw_os_error() == Some(EIO)
}

/// Rows without a reading that have come since `before`, for each board that has some.
fn newly_without(before: &[BoardStatistics], now: &[BoardStatistics]) -> Vec<(u8, u64)> {
    let before =
        |board| before.iter().find(|one| one.board == board).map_or(0, |one| one.rows_without_reading);
    let new = now.iter().map(|one| (one.board, one.rows_without_reading - before(one.board)));
    new.filter(|&(_, rows)| rows > 0).collect()
}

/// What stands in the lines below.
fn header(setup: &Setup) -> String {
    format!("      time   loop rate  board: pressure/command of its four channels, {}", setup.unit.name())
}

/// Time, loop rate since the line before, and pressure and command of every channel; `without` says
/// of which boards how many rows had no reading.
fn line(before: &Snapshot, now: &Snapshot, now_ns: u64, without: &[(u8, u64)], setup: &Setup) -> String {
    let mut line = format!("{:>8.1} s", now.since_start_ns as f64 * 1e-9);
    let cycles = now.cycle.unwrap_or(0) - before.cycle.unwrap_or(0);
    let seconds = now.since_start_ns.saturating_sub(before.since_start_ns) as f64 * 1e-9;
    // Before the first line nothing is known, and a recording need not begin at 0.
    if seconds > 0.0 && before.cycle.is_some() {
        let _ = write!(line, "  {:>7.1} Hz", cycles as f64 / seconds);
    } else {
        let _ = write!(line, "  {:>7} Hz", "-");
    }
    for board in &now.boards {
        let _ = write!(line, "  b{}", board.board);
        put_board(&mut line, board, now_ns, setup);
        if let Some((_, rows)) = without.iter().find(|(one, _)| *one == board.board) {
            let _ = write!(line, " (rows without a reading: {rows})");
        }
    }
    line
}

/// Readings older than this are shown with their age: three of the slowest usual cycles.
const OLD: Duration = Duration::from_millis(100);

fn put_board(line: &mut String, board: &BoardRow, now_ns: u64, setup: &Setup) {
    match &board.reading {
        None => line.push_str(" never answered"),
        Some(reading) => {
            let commands = setup.calibration.command_kpa(board.board, board.command);
            for (kpa, command) in reading.kpa.into_iter().zip(commands) {
                let _ = write!(line, " {}/{}", setup.unit.number(kpa), setup.unit.number(command));
            }
            let age = reading.age(now_ns);
            if age > OLD {
                let _ = write!(line, " ({:.1} s old)", age.as_secs_f64());
            }
            if let Some(kpa) = board.sensors.supply.and_then(|supply| supply.shown_kpa(now_ns)) {
                let _ = write!(line, " supply {}", setup.unit.number(kpa));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_host::poller::{BoardSensors, BoardState, Outcome, Reading, SupplyPressure, VENTED};

    #[test]
    fn a_line_tells_old_values_from_fresh_ones() {
        let reading = Reading { counts: VENTED, kpa: [1.0, 2.0, 3.0, 4.0], asked_ns: 1_000_000_000 };
        let board = BoardRow {
            board: 2,
            command: VENTED,
            wanted: VENTED,
            outcome: Outcome::Fresh,
            reading: Some(reading),
            drives: None,
            sensors: BoardSensors::default(),
            state: BoardState::Present,
        };
        let at = |cycle, since_start_ns| Snapshot {
            cycle: Some(cycle),
            at_ns: 0,
            since_start_ns,
            boards: vec![board],
        };
        let (before, now) = (at(1000, 1_000_000_000), at(3000, 2_000_000_000));
        let fresh = line(&before, &now, 1_000_200_000, &[], &Setup::default());
        assert_eq!(fresh, "     2.0 s   2000.0 Hz  b2 1.0/0.0 2.0/0.0 3.0/0.0 4.0/0.0");
        let first = line(&Snapshot::default(), &now, 1_000_200_000, &[], &Setup::default());
        assert_eq!(first, "     2.0 s        - Hz  b2 1.0/0.0 2.0/0.0 3.0/0.0 4.0/0.0");
        let old = line(&before, &now, 2_500_000_000, &[(1, 3), (2, 37)], &Setup::default());
        assert!(old.ends_with("4.0/0.0 (1.5 s old) (rows without a reading: 37)"), "{old}");
        let supply = Some(SupplyPressure { kpa: 549.66, measured_ns: 1_000_000_000 });
        let sensors = BoardSensors { supply, ..BoardSensors::default() };
        let mut now = now;
        now.boards[0].sensors = sensors;
        let fresh = line(&before, &now, 1_000_200_000, &[], &Setup::default());
        assert!(fresh.ends_with("3.0/0.0 4.0/0.0 supply 549.7"), "{fresh}");
    }
}
