//! The extended model: simulated by effects, saved, loaded, and simulated again from the command
//! line.

use crate::common::Folder;
use crate::common::cli::run;
use crate::common::regulator::{regulator, scatter};
use pneudrive_model::data::{ChannelId, LoadOptions, load};
use pneudrive_model::diagnosis::{Correction, ExtendedFile, Request, Variable, diagnose};
use pneudrive_model::rig::Rig;

const RIG: &str = "[supply]\npressure_kpa = 550.0\n[chamber]\nradius_m = 0.024\nlength_m = 0.2\n\
[controller]\nrate_hz = 1000.0\nkp = 10.0\nsaturation = 400.0\n[sensor]\nbits = 10\nzero_counts = 102.4\nkpa_per_count = 0.841645\n";
const CHANNEL: ChannelId = ChannelId { board: 0, channel: 0 };

/// Commands with drives, and pressures only to have a column to fit something to.
fn driven() -> String {
    let mut text = "t_s,b0_cmd0_kpa,b0_u0,b0_p0_kpa\n".to_owned();
    let mut p = 80.0_f64;
    for k in 0..1500_u32 {
        let (command, drive) = (150.0 + 100.0 * scatter(k / 50), 0.5 * scatter(7000 + k / 20));
        text.push_str(&format!("{:.2},{command:.2},{drive:.4},{p:.3}\n", f64::from(k) * 0.01));
        p = (p + 2.0 * drive).clamp(20.0, 300.0);
    }
    text
}

/// The simulated pressures in a CSV file.
fn pressures(folder: &Folder, name: &str) -> Vec<f64> {
    let loaded = load(&folder.path(name), LoadOptions::default()).unwrap();
    let channel = loaded.recording.channel(CHANNEL).unwrap();
    channel.pressure_kpa.as_ref().unwrap().iter().map(|p| f64::from(*p)).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Fits with `arguments`, turns the parameters into an extended model without effects, simulates
/// both, and returns by how much they differ and how far the pressure moves, kPa.
fn plain_and_extended(data: &str, arguments: &[&str], simulate: &[&str]) -> (f64, f64) {
    let folder = Folder::new();
    folder.write("run.csv", data.as_bytes());
    folder.write("rig.toml", RIG.as_bytes());
    let fitted = [&["fit", "run.csv", "--starts", "1", "--out", "p.toml"], arguments].concat();
    let fit = run(folder.root(), &fitted);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let mut file = ExtendedFile::load(&folder.path("p.toml")).unwrap();
    // The plain rollout has no noise in its loop.
    file.channels.values_mut().for_each(|c| c.noise_kpa = 0.0);
    file.save(&folder.path("e.toml")).unwrap();
    for (parameters, out) in [("p.toml", "plain.csv"), ("e.toml", "extended.csv")] {
        let simulated =
            [&["simulate", "run.csv", "--parameters", parameters, "--out", out], simulate].concat();
        let done = run(folder.root(), &simulated);
        assert_eq!(done.status, 0, "{}", done.stderr);
    }
    let (plain, extended) = (pressures(&folder, "plain.csv"), pressures(&folder, "extended.csv"));
    let spread = largest_difference(&plain, &vec![plain[0]; plain.len()]);
    (largest_difference(&plain, &extended), spread)
}

/// Two integrators (classical Runge-Kutta, exponential Rosenbrock) of the same equations.
#[test]
fn without_effects_it_is_the_plain_model() {
    let (apart, moved) = plain_and_extended(&regulator(0), &["--model", "linear"], &[]);
    assert!(apart < 1e-3 && moved > 50.0, "linear: {apart} of {moved} kPa");
    let rig = ["--rig", "rig.toml", "--fit-seconds", "3"];
    let (apart, moved) = plain_and_extended(&driven(), &rig, &[]);
    assert!(apart < 0.005 && moved > 10.0, "driven: {apart} of {moved} kPa");
}

/// In the board's loop both are stepped once a loop, and rounding of command and sample differs by
/// less than a count.
#[test]
fn without_effects_it_is_the_plain_model_in_the_boards_loop() {
    let rig = ["--rig", "rig.toml", "--fit-seconds", "3"];
    let (apart, moved) = plain_and_extended(&driven(), &rig, &["--controller", "on"]);
    assert!(apart < 0.85 && moved > 50.0, "{apart} of {moved} kPa");
}

/// From a recording to the extended model, its file, and back to pressures: what `simulate` gives
/// is what the report's gain was measured with.
#[test]
fn what_a_diagnosis_measured_is_what_its_file_simulates() {
    let folder = Folder::new();
    folder.write("run.csv", regulator(6).as_bytes());
    let recording = load(&folder.path("run.csv"), LoadOptions::default()).unwrap().recording;
    let diagnosis = diagnose(&recording, &Rig::default(), Request::default(), &|_, _| {}).unwrap();
    let named: Vec<&str> = diagnosis.report.causes.iter().map(|c| c.effect.as_str()).collect();
    assert_eq!(named, ["transport_delay"], "{}", diagnosis.report.sentence);
    let mut extended = diagnosis.extended.clone();
    for corrected in [false, true] {
        // A correction of a few kPa/s must arrive in the simulation too, and be the same on both
        // ways.
        let mut model = diagnosis.extended_models[0].clone();
        if corrected {
            let correction = Correction {
                variable: Variable::Pressure,
                knots: vec![60.0, 100.0, 140.0, 180.0, 220.0, 240.0],
                heights: vec![0.0, 20.0, -20.0, 10.0, 0.0, -30.0],
            };
            model.correction = Some(correction.clone());
            extended.channels.get_mut("b0c0").unwrap().correction = Some(correction);
        }
        extended.save(&folder.path("e.toml")).unwrap();
        let arguments = ["simulate", "run.csv", "--parameters", "e.toml", "--out", "s.csv"];
        let done = run(folder.root(), &arguments);
        assert_eq!(done.status, 0, "{}", done.stderr);
        assert!(done.stdout.contains("linear model with transport_delay"), "{}", done.stdout);
        let simulated = pressures(&folder, "s.csv");
        let data = &diagnosis.channels[0];
        let expected = data.readings(&model);
        let there: Vec<f64> = data.rows.iter().map(|&row| simulated[row as usize]).collect();
        let apart = largest_difference(&expected, &there);
        assert!(apart < 1e-3, "correction {corrected}: {apart} kPa");
        let without = data.readings(&diagnosis.extended_models[0]);
        let moved = largest_difference(&expected, &without);
        assert_eq!(moved > 1.0, corrected, "the correction moves the simulation by {moved} kPa");
    }
}

/// Measured pressures are not needed: a file of commands is enough.
#[test]
fn commands_alone_are_enough() {
    let folder = Folder::new();
    folder.write("run.csv", regulator(6).as_bytes());
    let done = run(folder.root(), &["diagnose", "run.csv", "--out", "d"]);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let only: String = regulator(6)
        .lines()
        .map(|line| line.rsplit_once(',').map_or(line, |(commands, _)| commands).to_owned() + "\n")
        .collect();
    folder.write("commands.csv", only.as_bytes());
    let arguments = [
        "simulate",
        "commands.csv",
        "--parameters",
        "d/extended.toml",
        "--start-kpa",
        "150",
        "--out",
        "s.csv",
    ];
    let done = run(folder.root(), &arguments);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let whole = ["simulate", "run.csv", "--parameters", "d/extended.toml", "--out", "w.csv"];
    assert_eq!(run(folder.root(), &whole).status, 0);
    let (a, b) = (pressures(&folder, "s.csv"), pressures(&folder, "w.csv"));
    let apart = largest_difference(&a[300..], &b[300..]);
    assert!(apart < 1e-3, "{apart} kPa after the start is forgotten");
}

/// A reference may be either file; what it lacks is said.
#[test]
fn both_kinds_of_calibration_are_taken_as_a_reference() {
    let folder = Folder::new();
    folder.write("run.csv", driven().as_bytes());
    folder.write("regulator.csv", regulator(0).as_bytes());
    folder.write("rig.toml", RIG.as_bytes());
    let fit = run(
        folder.root(),
        &["fit", "regulator.csv", "--model", "linear", "--starts", "2", "--out", "fitted.toml"],
    );
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let first = run(folder.root(), &["diagnose", "regulator.csv", "--out", "first"]);
    assert_eq!(first.status, 0, "{}", first.stderr);
    for reference in ["fitted.toml", "first/extended.toml"] {
        let done =
            run(folder.root(), &["diagnose", "regulator.csv", "--reference", reference, "--out", "second"]);
        assert_eq!(done.status, 0, "{reference}: {}", done.stderr);
        assert!(done.stdout.contains("Nothing has moved"), "{reference}: {}", done.stdout);
    }
    folder.write("other.toml", b"schema = \"something/1\"\n");
    for (reference, said) in [
        ("other.toml", "schema is something/1, expected pneudrive-extended/1"),
        ("none.toml", "none.toml: cannot be opened: there is no such file"),
        ("fitted.toml", "b0c0 has no parameter leak_in"),
    ] {
        let arguments =
            ["diagnose", "run.csv", "--rig", "rig.toml", "--reference", reference, "--out", "third"];
        let done = run(folder.root(), &arguments);
        assert_eq!(done.status, 2, "{reference}: {}", done.stdout);
        assert!(done.stderr.contains(said), "{reference}: {}", done.stderr);
        assert!(!folder.path("third").exists());
    }
}

/// A 95 % band comes with what `diagnose` wrote, holds about that share of another recording of the
/// same kind, and is refused of a model that has none.
#[test]
fn a_band_holds_what_another_recording_measured() {
    let folder = Folder::new();
    let whole = regulator(6);
    // The first half is diagnosed; the second was never seen.
    let rows: Vec<&str> = whole.lines().collect();
    let part = |rows: &[&str]| [&[whole.lines().next().unwrap()], rows].concat().join("\n") + "\n";
    folder.write("run.csv", part(&rows[1..2501]).as_bytes());
    folder.write("later.csv", part(&rows[2501..]).as_bytes());
    let done = run(folder.root(), &["diagnose", "run.csv", "--out", "d"]);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let simulate = |parameters: &str| {
        let arguments =
            ["simulate", "later.csv", "--parameters", parameters, "--out", "s.csv", "--band", "band.csv"];
        run(folder.root(), &arguments)
    };
    let done = simulate("d/extended.toml");
    assert_eq!(done.status, 0, "{}", done.stderr);
    let text = std::fs::read_to_string(folder.path("band.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("t_s,b0c0_low_kpa,b0c0_high_kpa"));
    let measured = pressures(&folder, "later.csv");
    let held = lines.zip(&measured).filter(|(line, measured)| {
        let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
        (numbers[1]..=numbers[2]).contains(*measured)
    });
    let share = held.count() as f64 / measured.len() as f64;
    assert!((0.9..0.99).contains(&share), "{share}");
    assert!(done.stdout.contains(&format!("95 % band holds {:.1} %", 100.0 * share)), "{}", done.stdout);

    let fit =
        run(folder.root(), &["fit", "run.csv", "--model", "linear", "--starts", "1", "--out", "p.toml"]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    std::fs::remove_file(folder.path("band.csv")).unwrap();
    let same =
        ["simulate", "later.csv", "--parameters", "d/extended.toml", "--out", "s.csv", "--band", "s.csv"];
    let refused = run(folder.root(), &same);
    assert!(refused.status == 2 && refused.stderr.contains("choose another name"), "{}", refused.stderr);
    let refused = simulate("p.toml");
    assert_ne!(refused.status, 0);
    assert!(refused.stderr.contains("no band") && refused.stderr.contains("diagnose"), "{}", refused.stderr);
    assert!(!folder.path("band.csv").exists());
}

#[test]
fn the_noise_that_a_fit_stores_is_the_measurements_and_not_the_models_error() {
    let folder = Folder::new();
    folder.write("late.csv", regulator(30).as_bytes());
    let fit =
        run(folder.root(), &["fit", "late.csv", "--model", "linear", "--starts", "2", "--out", "p.toml"]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let saved: toml::Table = std::fs::read_to_string(folder.path("p.toml")).unwrap().parse().unwrap();
    let stored = |name: &str| saved["channels"]["b0c0"][name].as_float().unwrap();
    let noise_kpa = 0.34 / 3.0_f64.sqrt();
    // The pressure never rests, and some of its movement counts as noise.
    let estimated = stored("noise_kpa");
    assert!(noise_kpa < estimated && estimated < 2.0 * noise_kpa, "{estimated} of {noise_kpa}");
    assert!(stored("rms") > 5.0 * estimated, "a dead time is no noise: {}", stored("rms"));
}
