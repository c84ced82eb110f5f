//! What is read, what is refused, and the exact sentences.

use pneudrive_rig::{Limit, Rig, Sensor, Unit};

const MIXED: &str = "\
[bus]
port = \"/dev/ttyUSB0\"
boards = 3
rate_hz = 500
[display]
unit = \"psi\"
[supply]
pressure_kpa = 550.0
[sensor]
bits = 10
zero_counts = 102.4
kpa_per_count = 0.841645
[limits]
max_kpa = 300
max_rate_kpa_s = 500.0

[boards.0]
name = \"shoulder\"
limits = { max_kpa = 250.0 }
[boards.0.sensor]
zero_counts = 101.0
kpa_per_count = 0.84
[boards.0.channels.3]
name = \"front left\"
[boards.0.channels.3.limits]
max_kpa = 100.0
[boards.0.channels.3.sensor]
zero_counts = 104.5
kpa_per_count = 0.85
[boards.12.channels.1.limits]
max_rate_kpa_s = 20.0
";

fn refused(text: &str) -> String {
    Rig::parse("rig.toml", text).expect_err("it is refused").to_string()
}

#[test]
fn the_strictest_limit_and_the_nearest_calibration_hold() {
    let rig = Rig::parse("rig.toml", MIXED).unwrap();
    let limit = |max_kpa, rate| Limit { max_kpa: Some(max_kpa), max_rate_kpa_s: Some(rate) };
    assert_eq!(rig.limit(3, 0), limit(300.0, 500.0));
    assert_eq!(rig.limit(0, 0), limit(250.0, 500.0));
    assert_eq!(rig.limit(0, 3), limit(100.0, 500.0));
    assert_eq!((rig.limit(12, 0), rig.limit(12, 1)), (limit(300.0, 500.0), limit(300.0, 20.0)));
    let zero = |board, channel| rig.sensor(board, channel).unwrap().zero_counts;
    assert_eq!((zero(1, 0), zero(0, 0), zero(0, 3)), (102.4, 101.0, 104.5));
    assert_eq!(rig.usual_sensor(), Some(Sensor { zero_counts: 102.4, kpa_per_count: 0.841_645 }));
    assert_eq!(rig.sensor_place(0, 3), Some(("boards.0.channels.3.sensor".to_owned(), 27)));
    assert_eq!(rig.sensor_place(0, 1), Some(("boards.0.sensor".to_owned(), 20)));
    assert_eq!(rig.sensor_place(9, 1), Some(("sensor".to_owned(), 9)));
    assert_eq!((rig.board_name(0), rig.channel_name(0, 3)), (Some("shoulder"), Some("front left")));
    assert_eq!((rig.board_name(1), rig.channel_name(0, 2)), (None, None));
    assert_eq!((rig.unit(), rig.bus().boards, rig.bus().rate_hz), (Unit::Psi, Some(3), Some(500.0)));
    assert_eq!(rig.boards().into_iter().collect::<Vec<_>>(), [0, 12]);
}

#[test]
fn an_empty_file_says_nothing() {
    let rig = Rig::parse("rig.toml", "").unwrap();
    assert_eq!((rig.limit(0, 0), rig.sensor(0, 0)), (Limit::default(), None));
    assert_eq!((rig.unit(), rig.bus().port), (Unit::Kpa, None));
}

/// A misspelt key must not leave a limit out in silence.
#[test]
fn errors_name_line_key_and_what_is_expected() {
    for (text, expected) in [
        (
            "[limits]\nmax_kpa = -3.0\n",
            "rig.toml:2: limits.max_kpa = -3.0: expected a number from 0 to 2000 kPa gauge",
        ),
        (
            "[limits]\n\nmax_rate_kpa_s = 0\n",
            "rig.toml:3: limits.max_rate_kpa_s = 0: expected a number above 0, at most 1000000 kPa/s",
        ),
        ("[limits]\nmax_kpa = nan\n", "rig.toml:2: limits.max_kpa = nan: expected a number from"),
        ("[limits]\nmax_kpa = \"3\"\n", "rig.toml:2: limits.max_kpa = \"3\": expected a number from"),
        ("[limits]\nmax_pka = 3.0\n", "rig.toml:2: unknown key limits.max_pka; did you mean max_kpa?"),
        ("[limit]\nmax_kpa = 3.0\n", "rig.toml:1: unknown table limit; did you mean limits?"),
        ("\nmax_kpa = 3.0\n", "rig.toml:2: unknown key max_kpa; it belongs under [limits]"),
        ("limits = 3.0\n", "rig.toml:1: limits = 3.0: expected a table, [limits]: what may be commanded"),
        (
            "[zzz]\n",
            "rig.toml:1: unknown table zzz; expected one of bus, display, limits, supply, ambient, chamber, valve, \
             controller, sensor, boards",
        ),
        (
            "[boards.256.limits]\nmax_kpa = 3\n",
            "rig.toml:1: unknown board boards.256; expected a number from 0 to 255",
        ),
        (
            "[boards.1.channels.4.limits]\nmax_kpa = 3\n",
            "rig.toml:1: unknown channel boards.1.channels.4; expected a number from 0 to 3",
        ),
        ("[boards.01]\n", "rig.toml:1: unknown board boards.01; expected"),
        (
            "[display]\nunit = \"PSI\"\n",
            "rig.toml:2: display.unit = \"PSI\": expected \"kPa\" or \"bar\" or \"psi\"",
        ),
        ("[bus]\nboards = 2.5\n", "rig.toml:2: bus.boards = 2.5: expected a whole number from 1 to 256"),
        ("[bus]\nport = \"\"\n", "rig.toml:2: bus.port = \"\": expected a serial port"),
        (
            "[boards.0]\nname = \"a name that is much too long for a screen\"\n",
            "rig.toml:2: boards.0.name = \"a name that is much too long for a scre..: expected a name of 1 to 24",
        ),
        ("[supply]\n", "rig.toml:1: [supply] needs pressure_kpa (a number from 0.1 to 2000 kPa gauge"),
        (
            "\n[boards.2.sensor]\nzero_counts = 100.0\n",
            "rig.toml:2: [boards.2.sensor] needs kpa_per_count (a number from 0.000001 to 100 kPa)",
        ),
        (
            "[chamber]\nradius_m = 0.02\n",
            "rig.toml:1: [chamber] needs radius_m and length_m (and offset_m where a joint bends it), or volume_m3 alone",
        ),
        (
            "[chamber]\nvolume_m3 = 0.02\nradius_m = 0.02\nlength_m = 0.2\n",
            "rig.toml:1: [chamber] has volume_m3 and a cylinder's radius_m, length_m or offset_m; keep one description",
        ),
        (
            "[boards.1.channels.0.chamber]\nvolume_m3 = 1e-4\n\n[boards.1.channels.2.chamber]\nlength_m = 0.2\n",
            "rig.toml:4: [boards.1.channels.2.chamber] needs radius_m and length_m",
        ),
        (
            "[boards.1.valve]\ncritical_ratio = 0.3\n",
            "rig.toml:1: [boards.1.valve] needs discharge_coefficient (a number from 0.05 to 1.5)",
        ),
        (
            "[boards.1.channels.2.controller]\nkp = 3\n",
            "rig.toml:1: unknown table boards.1.channels.2.controller; expected one of name, limits, sensor, chamber, valve",
        ),
        ("[boards.1.limits\n", "rig.toml:1: "),
        ("[bus]\nport = \"a\"\nport = \"b\"\n", "rig.toml:3: "),
    ] {
        let message = refused(text);
        assert!(message.starts_with(expected), "{text:?}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
    assert!(
        Rig::load("/nowhere/rig.toml".as_ref()).unwrap_err().to_string().starts_with("/nowhere/rig.toml: ")
    );
}

/// What a fit saved carries the rig that it was made with.
#[test]
fn a_rig_in_another_file_is_checked_with_its_lines() {
    let text = "schema = \"x\"\n[rig.supply]\npressure_kpa = 550\n[rig.valve]\ncritical_ratio = 5\n";
    let refused = |text: &str| Rig::check_table("fit.toml", text, "rig").unwrap_err();
    let error = refused(text);
    assert_eq!(error.to_string(), "fit.toml:5: valve.critical_ratio = 5: expected a number from 0.05 to 0.7");
    assert_eq!(error.sentence(), "valve.critical_ratio = 5: expected a number from 0.05 to 0.7");
    assert_eq!(Rig::check_table("fit.toml", &text.replace("= 5\n", "= 0.5\n"), "rig"), Ok(()));
    assert_eq!(refused("schema = 1\n").to_string(), "fit.toml:1: [rig] is missing");
}

#[test]
fn the_lowest_maximum_of_all_channels() {
    let rig = |text: &str| Rig::parse("rig.toml", text).unwrap().lowest_max_kpa();
    assert_eq!(rig(MIXED), Some(100.0));
    assert_eq!(rig("[limits]\nmax_kpa = 300\n[boards.0]\nname = \"arm\"\n"), Some(300.0));
    assert_eq!((rig(""), rig("[limits]\nmax_rate_kpa_s = 3\n")), (None, None));
}
