//! A fixed subset of the blind tests: the truth plant hides an effect, the diagnosis gets the data
//! file and the nominal rig.
//!
//! Shorter than the published cases (60 s, two channels) so that it takes a few minutes at most;
//! the whole table is `cargo run -p system-tests --example blind`, see docs/diagnosis-trust.md.

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::{Request, diagnose};
use pneudrive_model::rig::Rig;
use pneudrive_sim::plant::{Effect, Nuisances};
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};
use system_tests::blind::plan::{Case, Kind};
use system_tests::blind::score::{Outcome, named, score};

/// Hides `arguments` in a recording and scores what is named.
fn blind(kind: Kind, arguments: &[&str], seed: u64) -> (Outcome, String) {
    let (outcome, report) = blind_report(kind, arguments, seed);
    (outcome, named(&report))
}

/// The same with the whole report.
fn blind_report(kind: Kind, arguments: &[&str], seed: u64) -> (Outcome, serde_json::Value) {
    report_of(kind, arguments, seed, true, 60.0)
}

/// The same without the drive's columns: the board's loop is part of the simulation.
fn closed_loop(arguments: &[&str], seed: u64, seconds: f64) -> (Outcome, serde_json::Value) {
    report_of(Kind::Single, arguments, seed, false, seconds)
}

fn report_of(
    kind: Kind,
    arguments: &[&str],
    seed: u64,
    drive: bool,
    seconds: f64,
) -> (Outcome, serde_json::Value) {
    let effects: Vec<Effect> = arguments.iter().map(|text| text.parse().unwrap()).collect();
    let defaults = RecordingSettings::default();
    let mut plant = defaults.plant.clone();
    plant.channels = 2;
    plant.nuisances = Nuisances::laboratory();
    let settings = RecordingSettings {
        plant,
        effects,
        seed,
        seconds,
        rate_hz: 100.0,
        control_loop: if drive { Loop::Row } else { defaults.control_loop },
        columns: Columns { drive, ..Columns::default() },
        ..defaults
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    write_csv(&file, 2, settings.columns, Recorder::new(&settings).unwrap()).unwrap();
    let rig = Rig::parse("rig.toml", &rig_toml(&settings).unwrap()).unwrap();
    let limits = |channel| rig.sensor_limits(channel);
    let loaded = load(&file, LoadOptions { limits: Some(&limits), ..LoadOptions::default() }).unwrap();
    let diagnosis = diagnose(&loaded.recording, &rig, Request::default(), &|_, _| {}).unwrap();
    let report = serde_json::to_value(&diagnosis.report).unwrap();
    let case = Case {
        hard: None,
        number: 0,
        kind,
        effects: arguments.iter().map(|a| a.split(['=', ':', '@']).next().unwrap().to_owned()).collect(),
        arguments: arguments.iter().map(|a| (*a).to_owned()).collect(),
        size: "moderate".to_owned(),
        seed,
        drive,
    };
    (score(&case, &report), report)
}

fn assert_found(argument: &str, seed: u64) {
    let (outcome, named) = blind(Kind::Single, &[argument], seed);
    assert!(
        matches!(outcome, Outcome::Right | Outcome::Tied),
        "hidden {argument}, named {named}: {outcome:?}"
    );
}

#[test]
fn play_in_the_valve_is_named() {
    assert_found("valve_hysteresis", 11);
}

#[test]
fn a_sagging_supply_is_named() {
    assert_found("supply_sag", 12);
}

#[test]
fn a_growing_chamber_is_named() {
    assert_found("wall_compliance", 13);
}

#[test]
fn a_lagging_spool_is_named() {
    assert_found("valve_lag", 14);
}

#[test]
fn nothing_is_named_where_nothing_is_hidden() {
    for seed in [15, 16] {
        let (outcome, report) = blind_report(Kind::Null, &[], seed);
        assert_eq!(outcome, Outcome::Clean, "seed {seed}: named {}", named(&report));
        assert_eq!(report["verdict"], "adequate", "{}", report["sentence"]);
    }
}

/// Slugs of water come and go: the error depends on nothing that is measured, and is far beyond
/// noise and wander.
#[test]
fn an_error_without_a_pattern_is_unexplained_and_not_adequate() {
    let (outcome, report) = blind_report(Kind::OffCatalogue, &["line_water"], 17);
    assert_eq!(outcome, Outcome::Unnamed, "named {}", named(&report));
    assert_eq!(report["verdict"], "unexplained", "{}", report["sentence"]);
}

/// Air that gets warmer and colder makes the inflow swing much like a supply whose pressure cycles.
#[test]
fn a_cycle_of_the_supplys_temperature_is_not_called_one_of_its_pressure() {
    let (outcome, report) = blind_report(Kind::OffCatalogue, &["supply_temperature:period_s=7"], 18);
    assert_eq!(outcome, Outcome::Unnamed, "named {}", named(&report));
    assert_eq!(report["verdict"], "unexplained", "{}", report["sentence"]);
    assert!(report["sentence"].to_string().contains("explains it as well"), "{}", report["sentence"]);
}

#[test]
fn a_cycle_of_the_supplys_pressure_is_named() {
    assert_found("supply_ripple:amplitude_kpa=30,period_s=3", 19);
}

/// What a board's converter mixes or repeats, its loop follows.
#[test]
fn what_the_converter_does_is_named_without_the_drives_columns() {
    for (argument, seed) in [("sensor_crosstalk", 20), ("stale_samples:spell_s=0.1", 21)] {
        let (outcome, report) = closed_loop(&[argument], seed, 60.0);
        assert_eq!(outcome, Outcome::Right, "hidden {argument}, named {}", named(&report));
    }
}

/// The loop chatters behind the tube: the base model alone goes far astray, and nothing explains
/// from there.
#[test]
fn a_narrow_tube_is_named_without_the_drives_columns() {
    let (outcome, report) = closed_loop(&["line_restriction=0.8"], 22, 60.0);
    assert_eq!(outcome, Outcome::Right, "named {}", named(&report));
    assert_eq!(report["verdict"], "explained", "{}", report["sentence"]);
}

/// A loop around friction or play hunts, and no simulation hunts in step with it.
#[test]
fn stiction_and_play_are_told_apart_without_the_drives_columns() {
    for (effect, parameter, size, seed) in
        [("valve_stiction", "threshold", 0.06, 23), ("valve_hysteresis", "half_width", 0.05, 24)]
    {
        let (outcome, report) = closed_loop(&[&format!("{effect}={size}")], seed, 100.0);
        assert_eq!(outcome, Outcome::Right, "hidden {effect}, named {}", named(&report));
        let found = report["causes"][0]["parameters"][parameter]["value"].as_f64().unwrap();
        assert!((found / size - 1.0).abs() < 0.15, "{effect} of {size} fitted as {found}");
        assert!(report["notes"].to_string().contains("hunts"), "{}", report["notes"]);
    }
}

/// Taken as always in balance, the space before the muffler would be named as something else beside
/// it.
#[test]
fn a_muffler_is_named_with_the_space_before_it_and_nothing_else() {
    let (outcome, report) = blind_report(Kind::Single, &["vent_restriction=0.8"], 25);
    assert_eq!(outcome, Outcome::Right, "named {}", named(&report));
    let of = |name: &str| report["causes"][0]["parameters"][name]["value"].as_f64().unwrap();
    // 8 ml of a chamber of 362 ml; 1 / 0.8 of the open port.
    assert!((of("volume_ratio") / 0.0221 - 1.0).abs() < 0.2, "{}", of("volume_ratio"));
    assert!((of("area_ratio") / 1.25 - 1.0).abs() < 0.1, "{}", of("area_ratio"));
}

/// Pressures of several channels move together, so what one valve does shows in traces on the
/// others.
#[test]
fn an_effect_on_one_channel_is_said_to_act_there_alone() {
    let (outcome, report) = blind_report(Kind::OneChannel, &["valve_asymmetry=0.7@b0c1"], 26);
    assert_eq!(outcome, Outcome::Right, "named {}", named(&report));
    assert_eq!(report["causes"][0]["channels"], serde_json::json!(["b0c1"]));
}
