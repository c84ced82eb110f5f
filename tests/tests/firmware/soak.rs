//! An hour with everything that can go wrong, in virtual time: nothing drifts, grows, or is lost.
//!
//! ```console
//! $ cargo test -p system-tests --test firmware soak:: -- --nocapture
//! $ export PNEUDRIVE_SOAK_HOURS=24    # a day; fractions are fine
//! $ cargo test -p system-tests --test firmware soak:: -- --nocapture
//! ```

use pneudrive_host::bus::{BusOptions, EchoMode};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{BoardState, Observer, Outcome, Pace, PollerOptions, Polling, Row};
use pneudrive_protocol::{Echo, SensorScale};
use pneudrive_record::Recorder;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use system_tests::fault_table::{NewEveryCycle, SharedTruth, TappedLine, faulty_rig};
use system_tests::virtual_bus::VirtualBus;

const PERIOD_NS: u64 = 5_000_000;
const BOARDS: u8 = 2;

/// All kinds at once; in an hour each strikes dozens of times at least.
const FAULTS: &[&str] = &[
    "bit_flip=1e-5",
    "drop=1e-5",
    "duplicate=1e-5",
    "delay=1e-6,ms=3.2",
    "delay=1e-6,ms=40",
    "echo=1e-4",
    "stray=0.2",
    "noise=0.1,ms=1",
    "unplug=0.02,ms=1000",
    "babble=0.02,ms=50",
    "power_cycle=0.01,ms=500",
];

/// How the rows come.
#[derive(Debug, Default)]
struct Seen {
    rows: u64,
    first_ns: u64,
    last_ns: u64,
    /// Rows that did not begin on the grid of the period.
    off_grid: u64,
    fresh: u64,
    /// Greatest age of a value that was presented as fresh, ns.
    oldest_fresh_ns: u64,
}

struct Watcher(Arc<Mutex<Seen>>);

impl Observer for Watcher {
    fn row(&mut self, row: &Row<'_>) {
        let mut seen = self.0.lock().unwrap();
        if seen.rows == 0 {
            seen.first_ns = row.at_ns;
        }
        seen.rows += 1;
        seen.last_ns = row.at_ns;
        seen.off_grid += u64::from(!(row.at_ns - seen.first_ns).is_multiple_of(PERIOD_NS));
        for board in row.boards.iter().filter(|board| board.outcome == Outcome::Fresh) {
            seen.fresh += 1;
            // Age at the start of the row: a value of this cycle was asked for after it.
            let age_ns = row.at_ns.saturating_sub(board.reading.unwrap().asked_ns);
            seen.oldest_fresh_ns = seen.oldest_fresh_ns.max(age_ns);
        }
    }
}

/// Memory of this process, bytes.
fn resident_bytes() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: u64 = statm.split(' ').nth(1).unwrap().parse().unwrap();
    pages * 4_096
}

/// Rows below the header, each later than the one before.
fn rows_in(file: &Path) -> u64 {
    let decoder = zstd::Decoder::new(std::fs::File::open(file).unwrap()).unwrap();
    let lines = BufReader::new(decoder).lines().map(Result::unwrap);
    // Without what the recording says of itself and of what happened.
    let mut lines = lines.filter(|line| !line.starts_with('#'));
    let columns = lines.next().unwrap().split(',').count();
    let (mut rows, mut before) = (0, -1.0);
    for line in lines {
        assert_eq!(line.split(',').count(), columns, "row {rows}: {line}");
        let time_s: f64 = line.split(',').next().unwrap().parse().unwrap();
        assert!(time_s > before, "row {rows} at {time_s} s, after {before} s");
        (rows, before) = (rows + 1, time_s);
    }
    rows
}

#[test]
fn an_hour_of_faults_leaves_no_trace() {
    let hours: f64 = std::env::var("PNEUDRIVE_SOAK_HOURS").map_or(1.0, |text| text.parse().unwrap());
    let truth = SharedTruth::new(BOARDS.into());
    let mut rig = faulty_rig(BOARDS, FAULTS, &truth);
    rig.run_until(200_000_000);
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent));
    let line = TappedLine::new(VirtualBus::new(rig), truth.clone());
    let bus = pneudrive_host::bus::Bus::new(line, options).unwrap();

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("soak.csv.zst");
    let boards: Vec<u8> = (0..BOARDS).collect();
    let (recorder, tap) = Recorder::create(&file, &boards, SensorScale::ORIGINAL, false).unwrap();
    let seen = Arc::new(Mutex::new(Seen::default()));
    let observers: Vec<Box<dyn Observer>> = vec![tap, Box::new(Watcher(Arc::clone(&seen)))];
    let pace = Pace::every(Duration::from_nanos(PERIOD_NS));
    let polled = PollerOptions::for_devices(BOARDS.into()).pace(pace);
    let mut polling = Polling::new(bus, polled, Box::new(NewEveryCycle(0)), observers);

    let start_ns = polling.bus_mut().line().now_ns();
    let end_ns = start_ns + (hours * 3_600e9) as u64;
    let warm_ns = start_ns + (end_ns - start_ns) / 20;
    let mut warm_bytes = None;
    while polling.bus_mut().line().now_ns() < end_ns {
        let due = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due);
        polling.cycle().unwrap();
        if warm_bytes.is_none() && due > warm_ns {
            warm_bytes = Some(resident_bytes());
        }
        // Time is virtual, the disk's is not.
        while recorder.rows_waiting() > 400 {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }
    let (warm_bytes, end_bytes) = (warm_bytes.unwrap(), resident_bytes());
    let grown = end_bytes.saturating_sub(warm_bytes);
    let statistics = polling.finish();
    let counters = polling.bus_mut().line().bus().counters().clone();
    drop(polling);
    let summary = recorder.finish().unwrap();
    let seen = seen.lock().unwrap();
    let mut truth = truth.lock();
    truth.end(end_ns);

    println!(
        "{hours} h: {} rows, {} exchanges, {} lost, faults {:?}",
        summary.rows, statistics.exchanges, statistics.lost, counters.faults
    );
    println!(
        "memory {} KiB after a twentieth of the time, {} KiB at the end; {} of {} rows off the grid; oldest command at a valve {:.0} ms; {} MB on disk",
        warm_bytes / 1_024,
        end_bytes / 1_024,
        seen.off_grid,
        seen.rows,
        truth.oldest_command_ns() as f64 / 1e6,
        summary.bytes / 1_000_000
    );
    assert_eq!((truth.wrong_pressures(), truth.wrong_commands()), (0, 0), "wrong values believed, obeyed");
    assert_eq!(seen.oldest_fresh_ns, 0, "a value of an earlier cycle was presented as fresh");
    assert!(statistics.boards.iter().all(|board| board.state == BoardState::Present), "{statistics:?}");
    // Nothing is lost but to faults: a fault costs a few exchanges, an absence one every 100 ms.
    let strikes: u64 = counters.faults.values().sum();
    assert!(strikes > 300 && statistics.lost < 12 * strikes, "{} lost by {strikes} faults", statistics.lost);
    assert!(statistics.lost * 100 < statistics.exchanges, "{statistics:?}");
    // The grid is that of the first row, to the nanosecond, and all rows but those behind a fault
    // are on it.
    assert!(seen.off_grid * 500 < seen.rows, "{} of {} rows off the grid", seen.off_grid, seen.rows);
    let slots = (seen.last_ns - seen.first_ns) / PERIOD_NS + 1;
    assert!(slots - seen.rows <= statistics.missed_ticks, "{slots} periods, {seen:?}, {statistics:?}");
    assert_eq!((summary.rows, rows_in(&file)), (seen.rows, seen.rows), "rows recorded, rows in the file");
    assert!(grown < 4 << 20, "memory grew by {grown} bytes");
}
