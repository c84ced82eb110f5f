//! The rig file: what is read, what is refused, and the exact sentences.

use pneudrive_data::rig::Rig;

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

/// Format, ranges and messages are those of the crate `pneudrive_rig`, and are tested there.
#[test]
fn mistakes_are_refused_with_line_key_and_what_is_expected() {
    for (text, expected) in [
        ("[chamber]\nradius = 0.02", "rig.toml:2: unknown key chamber.radius; did you mean radius_m?"),
        (
            "[supply]\npressure_kpa = 550000.0",
            "rig.toml:2: supply.pressure_kpa = 550000.0: expected a number from 0.1 to 2000 kPa gauge (1 bar = 100 kPa, 1 psi = 6.895 kPa)",
        ),
        ("[controller]\nrate_hz = 1000.0\nsaturation = 400.0", "rig.toml:1: [controller] needs kp ("),
        // What is the host's business is checked all the same: it is the same file.
        ("[limits]\nmax_pka = 3.0", "rig.toml:2: unknown key limits.max_pka; did you mean max_kpa?"),
    ] {
        let message = message(text);
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn the_lowest_maximum_of_all_channels_bounds_experiments() {
    let text = "[supply]\npressure_kpa = 550.0\n[limits]\nmax_kpa = 300\nmax_rate_kpa_s = 50.0\n\
                [boards.1.channels.2.limits]\nmax_kpa = 120.5\n";
    assert_eq!(Rig::parse("rig.toml", text).unwrap().highest_set_point_kpa, Some(120.5));
    assert_eq!(Rig::parse("rig.toml", "[supply]\npressure_kpa = 550\n").unwrap().highest_set_point_kpa, None);
}

#[test]
fn a_tank_has_a_constant_volume() {
    let rig = Rig::parse("rig.toml", "[chamber]\nvolume_m3 = 0.005").unwrap();
    let chamber = rig.chamber.unwrap();
    assert!((chamber.rest_volume_m3() - 0.005).abs() < 1e-15);
    assert!(chamber.volume_per_rad_m3().abs() < 1e-15);
}
