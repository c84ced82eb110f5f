//! The rig file: what is read, what is refused, and the exact sentences.

use pneudrive_model::rig::Rig;

/// The example of the documentation, complete.
const COMPLETE: &str = r#"
[supply]
pressure_kpa = 550.0
[ambient]
pressure_kpa_abs = 101.325
temperature_k = 293.15
[chamber]
radius_m = 0.024
length_m = 0.20
offset_m = 0.045
[valve]
discharge_coefficient = 1.0
critical_ratio = 0.30
[controller]
rate_hz = 1000.0
kp = 10.0
kd = 0.0
saturation = 400.0
filter = 0.0
[sensor]
bits = 10
zero_counts = 102.4
kpa_per_count = 0.841645
"#;

fn message(text: &str) -> String {
    Rig::parse("rig.toml", text).expect_err("refused").to_string()
}

#[test]
fn the_complete_rig_and_the_empty_one_are_read() {
    let rig = Rig::parse("rig.toml", COMPLETE).unwrap();
    let chamber = rig.chamber.clone().unwrap();
    // pi 0.024^2 0.2 and pi 0.024^2 0.045
    assert!((chamber.rest_volume_m3() - 3.619_115e-4).abs() < 1e-9);
    assert!((chamber.volume_per_rad_m3() - 8.143_008e-5).abs() < 1e-10);
    assert_eq!(Rig::parse("rig.toml", &toml::to_string(&rig).unwrap()).unwrap(), rig);
    assert_eq!(Rig::parse("rig.toml", "").unwrap(), Rig::default());
    assert!((Rig::default().ambient_or_standard().pressure_kpa_abs - 101.325).abs() < 1e-12);
}

#[test]
fn unknown_keys_are_refused_with_the_nearest() {
    for (text, expected) in [
        ("[chamber]\nradius = 0.02", "rig.toml: unknown key chamber.radius; did you mean radius_m?"),
        ("[suply]\npressure_kpa = 1", "rig.toml: unknown key suply; did you mean supply?"),
        (
            "[supply]\npressure_kPa = 1",
            "rig.toml: unknown key supply.pressure_kPa; did you mean pressure_kpa?",
        ),
        ("kp = 3", "rig.toml: unknown key kp; it belongs under [controller]"),
        (
            "[valve]\nxyz = 1",
            "rig.toml: unknown key valve.xyz; the known keys are discharge_coefficient, critical_ratio",
        ),
        (
            "[zzz]\n",
            "rig.toml: unknown key zzz; the known tables are supply, ambient, chamber, valve, controller, sensor, limits, boards, bus, display",
        ),
        ("supply = 550", "rig.toml: unknown key supply; [supply] is a table with the keys pressure_kpa"),
    ] {
        assert_eq!(message(text), expected);
    }
}

#[test]
fn values_out_of_range_name_key_value_and_meaning() {
    for (text, expected) in [
        (
            "[supply]\npressure_kpa = 550000.0",
            "rig.toml: supply.pressure_kpa = 550000 is not possible: it must be 0.1 to 2000 kPa; it is the gauge pressure before the fill valves (1 bar = 100 kPa, 1 psi = 6.895 kPa)",
        ),
        (
            "[ambient]\ntemperature_k = 20.0",
            "rig.toml: ambient.temperature_k = 20 is not possible: it must be 200 to 400 K; it is in kelvin: add 273.15 to degrees Celsius",
        ),
        (
            "[valve]\ncritical_ratio = nan",
            "rig.toml: valve.critical_ratio = NaN is not possible: it must be 0.05 to 0.7; it is b of ISO 6358: 0.2 to 0.5 for valves, 0.528 for an ideal nozzle",
        ),
        (
            "[chamber]\nradius_m = 24.0\nlength_m = 0.2",
            "rig.toml: chamber.radius_m = 24 is not possible: it must be 0.0005 to 2 m; it is in metres",
        ),
        (
            "[chamber]\nradius_m = 0.024",
            "rig.toml: [chamber] needs radius_m and length_m (and offset_m where a joint bends it), or volume_m3 alone",
        ),
        (
            "[chamber]\nradius_m = 0.024\nlength_m = 0.2\nvolume_m3 = 0.001",
            "rig.toml: [chamber] has volume_m3 and a cylinder's radius_m, length_m or offset_m; keep one description",
        ),
    ] {
        assert_eq!(message(text), expected);
    }
}

#[test]
fn wrong_types_and_missing_keys_name_the_place() {
    let text = message("[supply]\npressure_kpa = \"high\"");
    assert!(text.starts_with("rig.toml: TOML parse error at line 2"), "{text}");
    let text = message("[controller]\nrate_hz = 1000.0\nsaturation = 400.0");
    assert!(text.contains("missing field `kp`"), "{text}");
}

#[test]
fn a_tank_has_a_constant_volume() {
    let rig = Rig::parse("rig.toml", "[chamber]\nvolume_m3 = 0.005").unwrap();
    let chamber = rig.chamber.unwrap();
    assert!((chamber.rest_volume_m3() - 0.005).abs() < 1e-15);
    assert!(chamber.volume_per_rad_m3().abs() < 1e-15);
}
