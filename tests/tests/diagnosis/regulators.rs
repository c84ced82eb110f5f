//! Regulators with their own loop: a recording of commands and pressures and no rig is compared
//! with the linear model.

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::json::Report;
use pneudrive_model::diagnosis::{Diagnosis, Request, diagnose};
use pneudrive_model::rig::Rig;
use system_tests::regulator::{Defect, HIGHEST_KPA, recording};

fn diagnosed(defect: Defect, seed: u64) -> Diagnosis {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("regulator.csv");
    std::fs::write(&file, recording(defect, 120.0, 50.0, seed)).unwrap();
    let loaded = load(&file, LoadOptions::default()).unwrap();
    diagnose(&loaded.recording, &Rig::default(), Request::default(), &|_, _| {}).unwrap()
}

fn named(report: &Report) -> Vec<Vec<&str>> {
    report
        .causes
        .iter()
        .map(|c| std::iter::once(c.effect.as_str()).chain(c.equivalent.iter().map(String::as_str)).collect())
        .collect()
}

/// One cause, the hidden one, alone or in a tie of at most three, at its size.
#[track_caller]
fn assert_named(defect: Defect, effect: &str, parameter: &str, size: f64) {
    let diagnosis = diagnosed(defect, 7);
    let report = &diagnosis.report;
    assert_eq!(report.baseline.model, "linear");
    let named = named(report);
    assert_eq!(named.len(), 1, "{defect:?}: {named:?}");
    assert!(named[0].contains(&effect) && named[0].len() <= 3, "{defect:?}: {named:?}");
    if report.causes[0].effect == effect {
        let value = report.causes[0].parameters[parameter].value;
        assert!((value / size - 1.0).abs() < 0.1, "{defect:?}: {parameter} {value}, not {size}");
    }
    // One crossing of a dead band that is missed by a hair leaves a large error until the next: its
    // gain is a matter of luck.
    if effect == "dead_band" {
        return;
    }
    let gain = &report.causes[0].gain;
    assert!(gain.ci95[0] > 0.0 && gain.test_rmse_after_kpa < 0.5, "{defect:?}: {gain:?}");
}

#[test]
fn a_healthy_regulator_is_adequate() {
    for seed in [1, 2, 3] {
        let diagnosis = diagnosed(Defect::None, seed);
        assert!(diagnosis.report.causes.is_empty(), "{:?}", named(&diagnosis.report));
        assert!(diagnosis.report.baseline.test_rmse_kpa < 0.35, "{}", diagnosis.report.sentence);
    }
}

#[test]
fn a_dead_time_is_named() {
    assert_named(Defect::DeadTime(0.06), "transport_delay", "delay", 0.06);
}

#[test]
fn a_second_lag_is_named() {
    assert_named(Defect::Lag(0.05), "valve_lag", "time_constant", 0.05);
}

#[test]
fn hysteresis_is_named() {
    assert_named(Defect::Hysteresis(4.0), "valve_hysteresis", "half_width", 4.0 / HIGHEST_KPA);
}

#[test]
fn a_dead_band_is_named() {
    assert_named(Defect::DeadBand(6.0), "dead_band", "width", 6.0 / HIGHEST_KPA);
}

#[test]
fn a_rate_limit_is_named() {
    assert_named(Defect::RateLimit(500.0), "rate_limit", "limit", 500.0);
}

#[test]
fn falling_slower_than_rising_is_named() {
    assert_named(Defect::Asymmetry(1.6), "valve_asymmetry", "ratio", 1.0 / 1.6);
}

#[test]
fn an_offset_is_named() {
    assert_named(Defect::Offset(3.0), "offset", "offset", 3.0);
}
