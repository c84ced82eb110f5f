//! The ends of every range, from both sides.

use pneudrive_rig::Rig;

#[track_caller]
fn is(text: &str, good: bool) {
    let read = Rig::parse("rig.toml", text);
    assert_eq!(read.is_ok(), good, "{text:?}: {read:?}");
}

#[test]
fn what_is_at_the_end_of_a_range_is_taken_and_what_is_beyond_is_not() {
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
            is(&format!("{text}{value:?}\n").replace("NaN", "nan"), good);
        }
    }
    for (bits, good) in [("4", true), ("24", true), ("3", false), ("25", false), ("10.0", false)] {
        is(&format!("[sensor]\nbits = {bits}\nzero_counts = 1.0\nkpa_per_count = 0.8\n"), good);
    }
}
