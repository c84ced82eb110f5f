//! One rig file for the whole system: what the host's reader takes, the toolkit's takes, and the other way round.

#![allow(clippy::unwrap_used)]

use pneudrive_model::rig::Rig as ModelRig;
use pneudrive_rig::Rig;

const PAGE: &str = include_str!("../../docs/rig.md");

/// Both readers accept `text`, or both refuse it.
#[track_caller]
fn both(text: &str, good: bool) {
    let (host, model) = (Rig::parse("rig.toml", text), ModelRig::parse("rig.toml", text));
    assert_eq!(host.is_ok(), good, "host: {text:?}: {:?}", host.err());
    assert_eq!(model.is_ok(), good, "toolkit: {text:?}: {:?}", model.err());
}

#[test]
fn the_documented_example_means_the_same_to_both() {
    let example = PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let (host, model) =
        (Rig::parse("rig.toml", example).unwrap(), ModelRig::parse("rig.toml", example).unwrap());
    assert_eq!(host.number("supply.pressure_kpa"), model.supply.map(|supply| supply.pressure_kpa));
    assert_eq!(host.number("chamber.length_m"), model.chamber.and_then(|chamber| chamber.length_m));
    assert_eq!(host.number("controller.kp"), model.controller.map(|controller| controller.kp));
    assert_eq!(
        host.usual_sensor().map(|sensor| sensor.zero_counts),
        model.sensor.map(|sensor| sensor.zero_counts)
    );
    // The strictest limit of any channel bounds what experiments command.
    assert_eq!(model.highest_set_point_kpa, host.limit(0, 3).max_kpa);
    both("", true);
    both("[zzz]\n", false);
}

/// A number that one of them refuses must not pass the other: a file that runs the boards can be fitted with.
#[test]
fn both_have_the_same_ranges() {
    let supply = "[supply]\npressure_kpa = ";
    let chamber = |rest: &str| format!("[chamber]\n{rest}");
    let cylinder = |key: &str| {
        let others: String = [("radius_m", "0.02"), ("length_m", "0.2"), ("offset_m", "0.04")]
            .into_iter()
            .filter(|(name, _)| *name != key)
            .map(|(name, value)| format!("{name} = {value}\n"))
            .collect();
        chamber(&format!("{others}{key} = "))
    };
    let controller = |key: &str| {
        let others: String = [("rate_hz", "1000.0"), ("kp", "10.0"), ("saturation", "400.0")]
            .into_iter()
            .filter(|(name, _)| *name != key)
            .map(|(name, value)| format!("{name} = {value}\n"))
            .collect();
        format!("[controller]\n{others}{key} = ")
    };
    let cases = [
        (supply.to_owned(), 0.1, 2000.0),
        ("[ambient]\npressure_kpa_abs = ".to_owned(), 30.0, 120.0),
        ("[ambient]\ntemperature_k = ".to_owned(), 200.0, 400.0),
        ("[valve]\ndischarge_coefficient = ".to_owned(), 0.05, 1.5),
        ("[valve]\ncritical_ratio = ".to_owned(), 0.05, 0.7),
        ("[limits]\nmax_kpa = ".to_owned(), 0.0, 2000.0),
        (chamber("volume_m3 = "), 1e-8, 10.0),
        (cylinder("radius_m"), 5e-4, 2.0),
        (cylinder("length_m"), 5e-4, 10.0),
        (cylinder("offset_m"), 0.0, 2.0),
        (controller("rate_hz"), 1.0, 100_000.0),
        (controller("kp"), 1e-6, 1e6),
        (controller("kd"), 0.0, 1e6),
        (controller("saturation"), 1e-6, 1e6),
        (controller("filter"), 0.0, 0.9999),
        ("[sensor]\nbits = 10\nzero_counts = 100.0\nkpa_per_count = ".to_owned(), 1e-6, 100.0),
    ];
    for (text, low, high) in cases {
        for (value, good) in
            [(low, true), (high, true), (low - 0.01, false), (high * 1.01, false), (f64::NAN, false)]
        {
            both(&format!("{text}{value:?}\n").replace("NaN", "nan"), good);
        }
    }
    for (bits, good) in [("4", true), ("24", true), ("3", false), ("25", false), ("10.0", false)] {
        both(&format!("[sensor]\nbits = {bits}\nzero_counts = 1.0\nkpa_per_count = 0.8\n"), good);
    }
}
