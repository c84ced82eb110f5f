//! A host that is killed (kill -9) leaves a recording that the toolkit opens, whenever it happens.

use pneudrive_host::bus::BusOptions;
use pneudrive_host::line::Line;
use pneudrive_host::poller::{Pace, PollerOptions, Polling, SetPoints};
use pneudrive_model::data::{LoadOptions, load};
use pneudrive_protocol::SensorScale;
use pneudrive_record::Recorder;
use pneudrive_sim::rig::RigOptions;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use system_tests::virtual_bus;

const FILE: &str = "PNEUDRIVE_TEST_RECORDING";

/// What the process that is killed does: it records two virtual boards without end, faster than any
/// real ones.
fn record_until_killed(file: &Path) {
    let rig = RigOptions { boards: 2, ..RigOptions::default() };
    let pace = Pace::every(Duration::from_millis(2));
    let options = PollerOptions::for_devices(2).pace(pace);
    let (_recorder, tap) = Recorder::create(file, &options.boards, SensorScale::ORIGINAL, false).unwrap();
    let bus = virtual_bus::bus(&rig, BusOptions::default());
    let mut polling = Polling::new(bus, options, Box::new(SetPoints::new(2)), vec![tap]);
    let started = Instant::now();
    // If nobody kills it, it ends by itself.
    while started.elapsed() < Duration::from_secs(120) {
        for _ in 0..100 {
            let due_ns = polling.next_cycle_ns();
            polling.bus_mut().line_mut().sleep_until(due_ns);
            polling.cycle().unwrap();
        }
        // The disk has its share of the processor.
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn the_recording_of_a_killed_host_opens() {
    if let Some(file) = std::env::var_os(FILE) {
        return record_until_killed(Path::new(&file));
    }
    // Rows come in blocks, and how many the first of them hold is the scheduler's business: the
    // kill waits for bytes of rows, of which 100 rows take fewer in each format.
    for (name, bytes, ms) in
        [("run.csv", 40_000, 0), ("run.csv.gz", 20_000, 130), ("run.csv.zst", 20_000, 370)]
    {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        let mut child = Command::new(std::env::current_exe().unwrap())
            // This test once more, as the host.
            .args(["--exact", "killed_recording::the_recording_of_a_killed_host_opens"])
            .env(FILE, &file)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let started = Instant::now();
        let size = || file.metadata().map_or(0, |status| status.len());
        let header = loop {
            assert!(started.elapsed() < Duration::from_secs(60), "{name}: no header");
            match size() {
                0 => std::thread::sleep(Duration::from_millis(5)),
                bytes => break bytes,
            }
        };
        while size() < header + bytes {
            assert!(started.elapsed() < Duration::from_secs(60), "{name}: {} bytes", size());
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(ms));
        child.kill().unwrap();
        child.wait().unwrap();

        let loaded = load(&file, LoadOptions::default()).unwrap();
        let recording = &loaded.recording;
        println!("{name}: {} bytes, {} rows", size(), recording.rows());
        assert!(recording.rows() > 100, "{name}: {} rows", recording.rows());
        assert_eq!(recording.channels.len(), 8, "{name}");
        assert!((recording.rate_hz() - 500.0).abs() < 1.0, "{name}: {} Hz", recording.rate_hz());
    }
}
