//! What a measured drive settles: a board whose gain is not what the rig file says does to a closed
//! loop what other valves and tubes do, and without the drives the diagnosis takes the board's
//! error for the pneumatics'. The host polls virtual boards and asks them for their drives, in
//! virtual time.

use pneudrive_host::bus::BusOptions;
use pneudrive_host::line::Line;
use pneudrive_host::poller::{
    BoardCommand, CommandSource, Pace, PageShare, PollerOptions, Polling, SourceStatus,
};
use pneudrive_model::data::{ChannelId, LoadOptions, load};
use pneudrive_model::diagnosis::{Request, diagnose};
use pneudrive_model::rig::Rig;
use pneudrive_protocol::SensorScale;
use pneudrive_record::{PageColumns, Recorder, RecorderOptions};
use pneudrive_sim::plant::Nuisances;
use pneudrive_sim::record::{Excitation, SetPoints};
use pneudrive_sim::rig::RigOptions;
use std::time::Duration;
use system_tests::blind::score::named;
use system_tests::virtual_bus;

const SCALE: SensorScale = SensorScale::ORIGINAL;
const SECONDS: f64 = 60.0;
/// Gain of the boards, and of the rig file.
const GAINS: [u16; 2] = [6, 10];

/// Set points like those of the blind recordings, after the second in which boards boot.
struct Movements([SetPoints; 4]);

impl CommandSource for Movements {
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        let t_s = since_start_ns as f64 * 1e-9;
        let kpa = self.0.each_mut().map(|points| points.at(t_s));
        commands.fill(kpa.map(|kpa| SCALE.counts(kpa).unwrap()));
        if t_s < SECONDS { SourceStatus::Continues } else { SourceStatus::Ended }
    }
}

/// The report on one board with these effects, that the host polled at 500 Hz.
fn report(effects: &[&str], seed: u64, measured: bool) -> serde_json::Value {
    let mut rig = RigOptions { boards: 1, seed, strict: true, ..RigOptions::default() };
    rig.plant.nuisances = Nuisances::laboratory();
    rig.effects = effects.iter().map(|text| text.parse().unwrap()).collect();
    rig.control.kp = GAINS[0];
    let mut stated = rig.clone();
    stated.control.kp = GAINS[1];

    let options = PollerOptions::for_devices(1)
        .pace(Pace::every(Duration::from_millis(2)))
        .drives(measured.then(|| PageShare::new(1.0).unwrap()));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let pages = PageColumns { drives: measured, sensors: false };
    let how = RecorderOptions::default().pages(pages);
    let (recorder, tap) = Recorder::create_with(&file, &options.boards, SCALE, &how).unwrap();
    let movements =
        Movements([0, 1, 2, 3].map(|place| SetPoints::new(Excitation::Mixed, [50.0, 300.0], seed, place)));
    let bus = virtual_bus::bus(&rig, BusOptions::default());
    let mut polling = Polling::new(bus, options, Box::new(movements), vec![tap]);
    loop {
        let due = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due);
        if polling.cycle().unwrap() == SourceStatus::Ended {
            break;
        }
        // Virtual time passes faster than the writer writes, which loses rows that wait for more
        // than 5 s.
        while recorder.rows_waiting() > 1_000 {
            std::thread::yield_now();
        }
    }
    polling.finish();
    drop(polling);
    recorder.finish().unwrap();

    let rig = Rig::parse("rig.toml", &stated.rig_toml().unwrap()).unwrap();
    let limits = |channel| rig.sensor_limits(channel);
    // Half of the board is enough, and half the work.
    let channels = [0, 1].map(|channel| ChannelId { board: 0, channel });
    let options = LoadOptions { limits: Some(&limits), channels: Some(&channels), ..LoadOptions::default() };
    let loaded = load(&file, options).unwrap();
    let diagnosis = diagnose(&loaded.recording, &rig, Request::default(), &|_, _| {}).unwrap();
    serde_json::to_value(&diagnosis.report).unwrap()
}

/// The error sits in the board: nothing is wrong with the pneumatics, which only the drives show.
#[test]
fn a_board_with_another_gain_is_no_fault_of_the_pneumatics() {
    let without = report(&[], 47, false);
    assert_eq!(without["verdict"], "unexplained", "{}", without["sentence"]);
    let measured = report(&[], 47, true);
    assert_eq!(measured["verdict"], "adequate", "{}", measured["sentence"]);
    assert!(measured["causes"].as_array().unwrap().is_empty(), "{}", measured["sentence"]);
}

/// The two hide each other: the board's gain, and a spool that lags by 20 ms.
#[test]
fn what_a_wrong_gain_hides_is_named_where_the_drives_are_measured() {
    let effect = ["valve_lag=0.02"];
    let without = report(&effect, 48, false);
    assert!(!named(&without).contains("valve_lag"), "{}", without["sentence"]);
    let measured = report(&effect, 48, true);
    assert_eq!(named(&measured), "valve_lag", "{}", measured["sentence"]);
    let lag_s = measured["causes"][0]["parameters"]["time_constant"]["value"].as_f64().unwrap();
    assert!((lag_s / 0.02 - 1.0).abs() < 0.1, "{lag_s} s");
}
