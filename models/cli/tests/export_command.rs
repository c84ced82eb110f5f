//! `pneudrive-model export`: what it writes, and what it refuses.

use std::io::Read as _;

use crate::common::Folder;
use crate::common::cli::run;

const MODEL: &str = r#"
schema = "pneudrive-extended/1"
model = "linear"
[rig.supply]
pressure_kpa = 500.0
[rig.chamber]
volume_m3 = 2e-4
[channels.b0c0]
drive = "command"
noise_kpa = 0.3
command_range_kpa = 300.0
parameters = { alpha = 5.0, beta = 4.5 }
[channels.b1c3]
drive = "command"
noise_kpa = 0.3
command_range_kpa = 300.0
parameters = { alpha = 2.0, beta = 2.0 }
"#;

/// What begins like a shared library for this machine number.
fn library(machine: u8) -> Vec<u8> {
    let mut bytes = b"\x7fELF".to_vec();
    bytes.resize(64, 0);
    bytes[18] = machine;
    bytes
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("extended.toml", MODEL.as_bytes());
    folder.write("x86.so", &library(0x3e));
    folder.write("arm.so", &library(0xb7));
    folder
}

#[test]
fn the_native_actuator_of_a_first_order_channel_is_that_channel() {
    let folder = folder();
    let arguments = ["export", "mujoco", "--native", "--parameters", "extended.toml", "--out", "robot"];
    let done = run(folder.root(), &arguments);
    assert_eq!(done.status, 0, "{}", done.stderr);
    // 1 / alpha and beta / alpha.
    let row = done.stdout.lines().find(|line| line.starts_with("b0c0")).unwrap();
    let values: Vec<f64> = row.split_whitespace().skip(1).map(|v| v.parse().unwrap()).collect();
    assert_eq!(values, [0.2, 0.9, 0.0, 0.0, 0.0], "{row}");
    let xml = std::fs::read_to_string(folder.path("robot/native.xml")).unwrap();
    // A chamber of 2e-4 m^3 and 0.2 m: 1e-3 m^2, 0.9 N per kPa.
    assert!(xml.contains(r#"dynprm="0.200000" gaintype="fixed" gainprm="0.900000""#), "{xml}");
    assert!(xml.contains(r#"name="b1c3""#) && xml.contains(r#"ctrlrange="0 300.000""#), "{xml}");
}

#[test]
fn a_unit_holds_the_libraries_the_parameters_and_its_description() {
    let folder = folder();
    let done = run(
        folder.root(),
        &[
            "export",
            "fmu",
            "--parameters",
            "extended.toml",
            "--out",
            "u.fmu",
            "--library",
            "x86.so",
            "--also",
            "arm.so",
        ],
    );
    assert_eq!(done.status, 0, "{}", done.stderr);
    let mut zip = zip::ZipArchive::new(std::fs::File::open(folder.path("u.fmu")).unwrap()).unwrap();
    let mut text = |name: &str| {
        let mut text = Vec::new();
        zip.by_name(name).unwrap().read_to_end(&mut text).unwrap();
        text
    };
    assert_eq!(text("binaries/x86_64-linux/pneudrive_chamber.so"), library(0x3e));
    assert_eq!(text("binaries/aarch64-linux/pneudrive_chamber.so"), library(0xb7));
    assert_eq!(text("resources/parameters.toml"), MODEL.as_bytes());
    let description = String::from_utf8(text("modelDescription.xml")).unwrap();
    for words in [
        r#"name="b1c3.set_point" valueReference="200" causality="input""#,
        r#"name="b0c0.supply" valueReference="103" causality="input" variability="continuous" start="500" unit="kPa""#,
        r#"name="b0c0.pressure" valueReference="107" causality="output""#,
        "canGetAndSetFMUState",
    ] {
        assert!(description.contains(words), "{words} in {description}");
    }
    assert!(!description.contains("b0c0.fill"), "set points drive it");
    let settings = String::from_utf8(text("resources/settings.toml")).unwrap();
    assert!(settings.contains("step_s = 0.001") && settings.contains(r#"["b0c0", "b1c3"]"#), "{settings}");
}

#[test]
fn what_cannot_be_exported_is_refused_with_a_sentence() {
    let folder = folder();
    let refused = |arguments: &[&str], words: &str| {
        let done = run(folder.root(), &[&["export"], arguments].concat());
        assert!(done.status == 2 && done.stderr.contains(words), "{}: {}", done.status, done.stderr);
    };
    let file = ["--parameters", "extended.toml", "--out", "x"];
    refused(&[&["c"], &file[..], &["--library", "nowhere.so"]].concat(), "nowhere.so: there is no such file");
    refused(&["c", "--parameters", "nowhere.toml", "--out", "x", "--library", "x86.so"], "nowhere.toml");
    refused(&[&["mujoco", "--native"], &file[..], &["--max-kpa", "-3"]].concat(), "--max-kpa");
    refused(&[&["fmu"], &file[..], &["--library", "extended.toml"]].concat(), "not a shared library");
    let twice = ["--library", "x86.so", "--also", "x86.so"];
    refused(&[&["fmu"], &file[..], &twice].concat(), "a second library for x86_64-linux");
    refused(&[&["fmu"], &file[..], &["--library", "x86.so", "--step", "0"]].concat(), "--step 0");
    assert!(!folder.path("x").is_file());
}

/// A nonlinear channel, and one with an effect where `effects` says so.
fn nonlinear(effects: &str) -> String {
    let channel = "drive = \"spool\"\nnoise_kpa = 0.3\ncommand_range_kpa = 300.0\nparameters = { gain = 1.5, corner = 0.03, \
leak_in = 0.004, leak_out = 0.003, threshold_in = 0.05, threshold_out = -0.04, volume_weight = 1.0 }\n";
    format!(
        "schema = \"pneudrive-extended/1\"\nmodel = \"nonlinear\"\n[rig.supply]\npressure_kpa = 500.0\n[rig.chamber]\nvolume_m3 = \
2e-4\n[channels.b0c0]\n{channel}{effects}"
    )
}

#[test]
fn a_package_for_jax_has_the_parameters_in_the_models_order() {
    let folder = folder();
    folder.write("nonlinear.toml", nonlinear("").as_bytes());
    let done = run(folder.root(), &["export", "jax", "--parameters", "nonlinear.toml", "--out", "arm"]);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let package = std::fs::read_to_string(folder.path("arm/__init__.py")).unwrap();
    assert!(
        package.contains("\"b0c0\": Channel((0.004, 0.003, 1.5, 0.05, -0.04, 0.03, 1.0), CONSTANTS, 4)"),
        "{package}"
    );
    assert!(package.contains("supply_kpa=500.0, volume_m3=0.0002, ambient_kpa_abs=101.325"), "{package}");
    let model = std::fs::read_to_string(folder.path("arm/model.py")).unwrap();
    assert!(model.contains("def dp(p_kpa, drive") && !model.contains("from ."), "it needs JAX only");
}

#[test]
fn what_jax_cannot_hold_is_refused_by_name() {
    let folder = folder();
    let effects = "[channels.b0c0.effects.valve_lag]\ntime_constant = 0.015\n";
    folder.write("effects.toml", nonlinear(effects).as_bytes());
    folder.write("nonlinear.toml", nonlinear("").as_bytes());
    let export =
        |file: &str, out: &str| run(folder.root(), &["export", "jax", "--parameters", file, "--out", out]);
    for (file, out, said) in [
        ("effects.toml", "arm", "b0c0 has valve_lag, which a pure function of the pressure cannot hold"),
        ("extended.toml", "arm", "the base model is linear"),
        ("nonlinear.toml", "robot-arm", "Python cannot import a package of that name"),
        ("nonlinear.toml", "2nd", "Python cannot import a package of that name"),
    ] {
        let done = export(file, out);
        assert_eq!(done.status, 2, "{}", done.stdout);
        assert!(done.stderr.contains(said), "{}", done.stderr);
        assert!(!folder.path(out).exists(), "something was written");
    }
}
