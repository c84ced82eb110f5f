//! From a trajectory over simulated chambers to a recording that the toolkit reads: the
//! measured-data format end to end, in virtual time.

use pneudrive_model::data::{ChannelId, Drive, LoadOptions, load};
use pneudrive_sim::rig::RigOptions;
use std::path::Path;
use system_tests::take::Take;

/// Two seconds after power-up the boards obey; then a step for board 1, and back.
const STEPS: &str = "t_s,b1_cmd2_kpa\n0,0\n2,150\n3.5,50\n5,50\n";

#[test]
fn what_the_host_records_the_toolkit_reads() {
    for name in ["run.csv", "run.csv.gz", "run.csv.zst", "run.mcap"] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        let rig = RigOptions { boards: 2, strict: true, ..RigOptions::default() };
        let take = Take { commands: STEPS, rate_hz: 500, drives: false, begins_s: 0.5 };
        let taken = take.record(&rig, &file);
        assert_eq!((taken.rows, taken.cycles), (2_501, 2_501), "5 s at 500 Hz, both ends included");

        let loaded = load(&file, LoadOptions::default()).unwrap();
        let recording = &loaded.recording;
        assert_eq!(recording.rows(), 2_501, "{name}: {:?}", loaded.quality);
        assert!(recording.breaks.is_empty(), "{name}: time is missing: {:?}", loaded.quality);
        assert!((recording.rate_hz() - 500.0).abs() < 1.0, "{} Hz", recording.rate_hz());
        let channel = recording.channel(ChannelId { board: 1, channel: 2 }).unwrap();
        let at = |time_s: f64| {
            let row = recording.row_at(time_s);
            let command = recording.command(channel, "the test").unwrap()[row];
            (command, recording.pressure(channel, "the test").unwrap()[row])
        };
        for (time_s, kpa) in [(1.9, 0.0), (3.4, 150.0), (4.9, 50.0)] {
            let (command, pressure) = at(time_s);
            assert!((command - kpa).abs() < 0.5, "{name}: {command} kPa commanded at {time_s} s, not {kpa}");
            assert!((pressure - kpa).abs() < 5.0, "{name}: {pressure} kPa at {time_s} s, not {kpa}");
        }
        // The row of a step holds the old pressure: what was answered cannot contain the effect of
        // the command sent.
        let (command, pressure) = at(2.0);
        assert!((command - 150.0).abs() < 0.5 && pressure < 5.0, "{command} kPa, {pressure} kPa");
        let other = recording.channel(ChannelId { board: 0, channel: 2 }).unwrap();
        let still = recording.pressure(other, "the test").unwrap();
        assert!(still.iter().all(|kpa| kpa.abs() < 5.0), "{name}: board 0 was not to move");
    }
}

/// The drives that boards tell are the toolkit's `u`: vented at power-up, full when a step begins,
/// small when it is over.
#[test]
fn drives_that_the_host_asks_for_are_the_toolkits_input() {
    for name in ["run.csv", "run.mcap"] {
        let folder = tempfile::tempdir().unwrap();
        assert_drives_are_read(&folder.path().join(name));
    }
}

fn assert_drives_are_read(file: &Path) {
    let rig = RigOptions { boards: 2, strict: true, ..RigOptions::default() };
    let taken = Take { commands: STEPS, rate_hz: 500, drives: true, begins_s: 0.5 }.record(&rig, file);
    let counters = taken.counters[1];
    // After each poll that was answered.
    assert!(counters.answered > 2_490, "{counters:?}");
    assert_eq!((counters.pages_asked, counters.pages_answered), (counters.answered, counters.answered));

    let loaded = load(file, LoadOptions::default()).unwrap();
    let recording = &loaded.recording;
    let channel = recording.channel(ChannelId { board: 1, channel: 2 }).unwrap();
    let Some(Drive::Spool(drive)) = &channel.drive else { panic!("no drive: {:?}", channel.drive) };
    let at = |time_s: f64| drive[recording.row_at(time_s)];
    // The board was on for a while before the first row.
    assert_eq!(at(0.5), -1.0, "it vents for 2 s after power-up");
    assert_eq!(at(2.01), 1.0, "it fills, 10 ms after the step");
    assert_eq!(at(3.51), -1.0, "it vents, 10 ms after the step down");
    for time_s in [3.4, 4.9] {
        assert!(at(time_s).abs() < 0.3, "{} at {time_s} s, where the pressure has settled", at(time_s));
    }
}
