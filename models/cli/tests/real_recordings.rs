//! The ventilator recordings (see docs/models.md). They are not in the repository: PNEUDRIVE_DATA
//! names the folder that holds `respiraworks/`; without it these tests say loudly that they were
//! skipped.

use crate::common::cli::{json, run};
use crate::common::{Folder, real_data};
use pneudrive_model::data::{Drive, LoadOptions, load};
use std::path::Path;

#[test]
fn all_sixteen_are_read_without_a_blemish() {
    let Some(data) = real_data("all_sixteen_are_read_without_a_blemish") else { return };
    for valve in ["solenoid", "pinch_valve"] {
        for k in 1..=8 {
            let path = data.join(format!("respiraworks/{valve}/run{k}.csv"));
            let loaded = load(&path, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(loaded.recording.rows(), 2340, "{}", path.display());
            assert!((loaded.quality.sampling.rate_hz - 100.0).abs() < 0.01);
            assert!(matches!(loaded.recording.channels[0].drive, Some(Drive::Separate { .. })));
            assert!(loaded.quality.findings.is_empty(), "{}: {:?}", path.display(), loaded.quality.findings);
        }
    }
}

#[test]
fn a_ventilator_run_is_compared() {
    let Some(data) = real_data("a_ventilator_run_is_compared") else { return };
    let rig = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/ventilator_solenoid.toml");
    let path = data.join("respiraworks/solenoid/run1.csv");
    let folder = Folder::new();
    let arguments = ["compare", path.to_str().unwrap(), "--rig", rig, "--fit-seconds", "15", "--out", "r"];
    let done = run(folder.root(), &arguments);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let result = json(&folder.path("r/compare.json"));
    for model in result["channels"][0]["models"].as_array().unwrap() {
        // A pressure that swings by 1.1 kPa: a model that is no better than its mean would have R2
        // = 0.
        let r2 = model["rollout"]["r2"].as_f64().unwrap_or(f64::NEG_INFINITY);
        assert!(r2 > 0.8, "{}: R2 = {r2}", model["model"]);
    }
}

/// Every run has a resistance between the sensor and the lung. One run alone must show it where it
/// tells enough, and nothing else in any, whatever a base model suggests that is far off.
#[test]
fn the_resistance_behind_the_sensor_is_named_in_runs_of_the_solenoid() {
    let Some(data) = real_data("the_resistance_behind_the_sensor_is_named_in_runs_of_the_solenoid") else {
        return;
    };
    the_resistance_is_named(&data, "solenoid", &[1, 2, 3, 4, 8], 4);
}

#[test]
fn the_resistance_behind_the_sensor_is_named_in_runs_of_the_pinch_valve() {
    let Some(data) = real_data("the_resistance_behind_the_sensor_is_named_in_runs_of_the_pinch_valve") else {
        return;
    };
    the_resistance_is_named(&data, "pinch_valve", &[1, 2, 3, 4, 5, 8], 1);
}

/// `surest`: the run in which most of the error is surely taken off blocks that were not fitted.
fn the_resistance_is_named(data: &Path, valve: &str, shown_in: &[usize], surest: usize) {
    let rig = format!("{}/../examples/ventilator_{valve}.toml", env!("CARGO_MANIFEST_DIR"));
    for number in 1..=8 {
        let path = data.join(format!("respiraworks/{valve}/run{number}.csv"));
        let folder = Folder::new();
        let done = run(folder.root(), &["diagnose", path.to_str().unwrap(), "--rig", &rig, "--out", "d"]);
        assert_eq!(done.status, 0, "{}", done.stderr);
        let report = json(&folder.path("d/report.json"));
        let causes = report["causes"].as_array().unwrap();
        if !shown_in.contains(&number) && causes.is_empty() {
            continue;
        }
        assert_eq!(named(&report), ["line_restriction"], "{valve} {number}");
        assert_eq!(causes[0]["equivalent"].as_array().map(Vec::len), Some(0), "{valve} {number}");
        let taken = causes[0]["gain"]["reduction"].as_f64().unwrap();
        assert!(taken > 0.2, "{valve} {number}: {taken}");
        let least = causes[0]["gain"]["ci95"][0].as_f64().unwrap();
        assert!(number != surest || least > 0.5, "{valve} {number}: {least}");
    }
}

/// Four runs of one ventilator with four settings of the lung (compliance 50, 20, 20, 20 ml/hPa;
/// resistance 5, 5, 20, 50 hPa s/l): the resistance of each is told, in the order of the settings,
/// and from the others' valves that of a run which was not there.
#[test]
fn several_runs_of_one_machine_tell_its_loads() {
    let Some(data) = real_data("several_runs_of_one_machine_tell_its_loads") else { return };
    let rig = format!("{}/../examples/ventilator_pinch_valve.toml", env!("CARGO_MANIFEST_DIR"));
    let path = |k: usize| data.join(format!("respiraworks/pinch_valve/run{k}.csv")).display().to_string();
    let folder = Folder::new();
    let runs: Vec<String> = [1, 3, 4, 6].map(path).to_vec();
    let mut arguments = vec!["diagnose"];
    arguments.extend(runs.iter().map(String::as_str));
    arguments.extend(["--rig", &rig, "--out", "m"]);
    let done = run(folder.root(), &arguments);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let report = json(&folder.path("m/report.json"));
    assert_eq!(named(&report), ["line_restriction"], "{}", done.stdout);
    let machine = &report["machine"];
    assert!(machine["joint_rmse_before_kpa"].as_f64().unwrap() > 0.2, "{machine}");
    assert!(machine["joint_rmse_after_kpa"].as_f64().unwrap() < 0.08, "{machine}");
    let sizes = |name: &str| -> Vec<f64> {
        let recordings = machine["recordings"].as_array().unwrap().iter();
        recordings.map(|r| r["load"]["b0c0"][name]["value"].as_f64().unwrap()).collect()
    };
    let resistances = sizes("line_restriction.resistance");
    let most = |of: &[usize]| of.iter().map(|&k| resistances[k]).fold(0.0, f64::max);
    assert!(most(&[0, 1]) < resistances[2] && resistances[2] < resistances[3], "{resistances:?}");
    let volumes = sizes("chamber_volume.ratio");
    assert!(volumes[1..].iter().all(|v| (0.3..0.5).contains(v)), "{volumes:?}");

    let eighth = path(8);
    let known = ["diagnose", &eighth, "--rig", &rig, "--machine", "m/extended-run1.toml", "--out", "k"];
    let done = run(folder.root(), &known);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let report = json(&folder.path("k/report.json"));
    assert_eq!(named(&report), ["line_restriction"], "{}", done.stdout);
    assert!(done.stdout.contains("taken as they were calibrated"), "{}", done.stdout);
    assert!(folder.path("k/extended.toml").is_file() && folder.path("k/report.html").is_file());
}

fn named(report: &serde_json::Value) -> Vec<&str> {
    let causes = report["causes"].as_array().into_iter().flatten();
    causes.filter_map(|cause| cause["effect"].as_str()).collect()
}
