//! Recordings that cannot carry a diagnosis: each is said in a sentence, and nothing is named from
//! it.

use crate::common::Folder;
use crate::common::cli;
use crate::common::cli::{json, run};

const RIG: &str = "[supply]\npressure_kpa = 550.0\n[chamber]\nradius_m = 0.024\nlength_m = 0.2\n\
[controller]\nrate_hz = 1000.0\nkp = 10.0\nsaturation = 400.0\n[sensor]\nbits = 10\nzero_counts = 102.4\nkpa_per_count = 0.841645\n";

/// A number from -1 to 1 that looks random.
fn scatter(k: u32) -> f64 {
    f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 23) - 1.0
}

/// Two regulators, each a lag of 0.2 s behind a command of its own, with noise; (time, commands,
/// pressures).
fn rows(seconds: f64) -> Vec<(f64, [f64; 2], [f64; 2])> {
    let mut p = [100.0, 150.0];
    (0..(seconds * 100.0) as u32)
        .map(|k| {
            let command = [150.0 + 120.0 * scatter(k / 60), 150.0 + 120.0 * scatter(50_000 + k / 45)];
            let noisy = [p[0] + 0.3 * scatter(90_000 + k), p[1] + 0.3 * scatter(190_000 + k)];
            for (p, c) in p.iter_mut().zip(command) {
                *p = c + (*p - c) * (-0.05_f64).exp();
            }
            (f64::from(k) * 0.01, command, noisy)
        })
        .collect()
}

const BOTH: &str = "t_s,b0_cmd0_kpa,b0_p0_kpa,b0_cmd1_kpa,b0_p1_kpa";

fn csv(header: &str, lines: impl Iterator<Item = String>) -> String {
    std::iter::once(header.to_owned()).chain(lines).map(|line| line + "\n").collect()
}

/// Diagnoses `text`; the rig file is there if it is asked for.
fn diagnose(text: &str, rig: bool) -> (cli::Run, Folder) {
    let folder = Folder::new();
    folder.write("run.csv", text.as_bytes());
    folder.write("rig.toml", RIG.as_bytes());
    let mut arguments = vec!["diagnose", "run.csv", "--out", "d"];
    if rig {
        arguments.extend(["--rig", "rig.toml"]);
    }
    (run(folder.root(), &arguments), folder)
}

/// It is refused with status 2, the sentence says why, and there is no result that could be read.
#[track_caller]
fn refused(text: &str, rig: bool, said: &str) {
    let (done, folder) = diagnose(text, rig);
    assert_eq!(done.status, 2, "{}", done.stdout);
    assert!(done.stderr.contains(said), "expected \"{said}\" in: {}", done.stderr);
    assert!(!folder.path("d").exists(), "there is a result all the same");
}

#[test]
fn the_same_recording_without_a_defect_is_diagnosed() {
    let text = csv(
        BOTH,
        rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3},{:.2},{:.3}", c[0], p[0], c[1], p[1])),
    );
    let (done, folder) = diagnose(&text, false);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let report = json(&folder.path("d/report.json"));
    assert_eq!(report["verdict"], "adequate", "{}", report["sentence"]);
}

#[test]
fn too_short() {
    let text = csv(
        "t_s,b0_cmd0_kpa,b0_p0_kpa",
        rows(5.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3}", c[0], p[0])),
    );
    refused(&text, false, "record at least 20 s");
}

#[test]
fn nothing_moves() {
    let still = rows(40.0);
    let text = csv(
        "t_s,b0_u0,b0_p0_kpa",
        still.iter().map(|(t, _, p)| format!("{t:.2},0.02,{:.3}", 100.0 + 0.01 * p[0])),
    );
    refused(&text, true, "the drive of b0c0 never changes");
}

#[test]
fn one_channel_does_not_move() {
    let lines = rows(40.0);
    let text = csv(
        BOTH,
        lines
            .iter()
            .map(|(t, c, p)| format!("{t:.2},{:.2},{:.3},150,{:.3}", c[0], p[0], 150.0 + 0.01 * p[1])),
    );
    refused(&text, false, "the command of b0c1 never changes");
    refused(&text, false, "or diagnose b0c0 alone");
}

#[test]
fn a_constant_command() {
    let text = csv(
        "t_s,b0_cmd0_kpa,b0_p0_kpa",
        rows(40.0).iter().map(|(t, _, p)| format!("{t:.2},150,{:.3}", 150.0 + 0.01 * p[0])),
    );
    refused(&text, false, "the command of b0c0 never changes");
    refused(&text, true, "the command of b0c0 never changes");
}

#[test]
fn psi_for_kpa_and_kpa_for_psi() {
    let head = "t_s,b0_cmd0_kpa,b0_p0_kpa";
    let psi =
        csv(head, rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.4}", c[0], p[0] / 6.894_757)));
    refused(&psi, false, "the pressure column looks like psi where the command is in kPa");
    refused(&psi, true, "the pressure column looks like psi where the command is in kPa");
    let kpa =
        csv(head, rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.3},{:.4}", c[0] / 6.894_757, p[0])));
    refused(&kpa, false, "the pressure column looks like kPa where the command is in psi");
    let bar = csv(head, rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.3},{:.5}", c[0], p[0] / 100.0)));
    refused(&bar, false, "the pressure column looks like bar where the command is in kPa");
}

#[test]
fn milliseconds_for_seconds() {
    let text = csv(
        "t_s,b0_cmd0_kpa,b0_p0_kpa",
        rows(40.0).iter().map(|(t, c, p)| format!("{:.0},{:.2},{:.3}", 1e3 * t, c[0], p[0])),
    );
    refused(&text, false, "t_s must be in seconds");
}

#[test]
fn swapped_channels() {
    let text = csv(
        BOTH,
        rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3},{:.2},{:.3}", c[0], p[1], c[1], p[0])),
    );
    refused(&text, false, "the pressure of b0c0 follows the command of b0c1");
}

/// Without commands the drives tell: a pressure rises where its valve fills.
#[test]
fn swapped_and_reversed_drives() {
    let mut p = [100.0, 150.0];
    let driven: Vec<(f64, [f64; 2], [f64; 2])> = (0..4000_u32)
        .map(|k| {
            let u = [0.4 * scatter(k / 20), 0.4 * scatter(60_000 + k / 25)];
            let row = (f64::from(k) * 0.01, u, p);
            for (p, u) in p.iter_mut().zip(u) {
                *p = f64::clamp(*p + 3.0 * u, 20.0, 400.0);
            }
            row
        })
        .collect();
    let head = "t_s,b0_u0,b0_p0_kpa,b0_u1,b0_p1_kpa";
    let swapped = csv(
        head,
        driven.iter().map(|(t, u, p)| format!("{t:.2},{:.3},{:.3},{:.3},{:.3}", u[0], p[1], u[1], p[0])),
    );
    refused(&swapped, true, "the pressure of b0c0 follows the drive of b0c1");
    let reversed = csv(
        head,
        driven.iter().map(|(t, u, p)| format!("{t:.2},{:.3},{:.3},{:.3},{:.3}", u[0], p[0], -u[1], p[1])),
    );
    refused(&reversed, true, "the pressure of b0c1 falls where its drive rises");
}

#[test]
fn missing_columns() {
    let only = csv("t_s,b0_cmd0_kpa", rows(40.0).iter().map(|(t, c, _)| format!("{t:.2},{:.2}", c[0])));
    refused(&only, false, "b0c0: column b0_p0_kpa is missing");
    let neither = csv("t_s,b0_p0_kpa", rows(40.0).iter().map(|(t, _, p)| format!("{t:.2},{:.3}", p[0])));
    refused(&neither, false, "neither a drive (b0_u0) nor a command (b0_cmd0_kpa) is recorded");
    let drive = csv(
        "t_s,b0_u0,b0_p0_kpa",
        rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.3},{:.3}", 0.003 * c[0], p[0])),
    );
    refused(&drive, false, "the rig file has no [supply]");
    // One of two channels can be used: it is, and the other is said to be left out.
    let half = csv(
        "t_s,b0_cmd0_kpa,b0_p0_kpa,b0_cmd1_kpa",
        rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3},{:.2}", c[0], p[0], c[1])),
    );
    let (done, folder) = diagnose(&half, false);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let report = json(&folder.path("d/report.json"));
    let notes = report["notes"].to_string();
    assert!(notes.contains("Left out: b0c1: column b0_p1_kpa is missing."), "{notes}");
}

/// A sensor that ends at 200 kPa: what it cannot see is not compared, it is said, and no cause is
/// made of it.
#[test]
fn a_clipped_sensor() {
    let head = "t_s,b0_cmd0_kpa,b0_p0_kpa";
    let clipped = |limit: f64| {
        csv(head, rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3}", c[0], p[0].min(limit))))
    };
    let (done, folder) = diagnose(&clipped(200.0), false);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let report = json(&folder.path("d/report.json"));
    let notes = report["notes"].to_string();
    assert!(
        notes.contains("at a limit of the sensor") && report["causes"] == serde_json::json!([]),
        "{report}"
    );
    refused(&clipped(100.0), false, "too many to diagnose anything from the rest");
}

/// Pressures that have nothing to do with the commands: there is an error, but no name for it.
#[test]
fn a_pressure_that_follows_nothing() {
    let text = csv(
        "t_s,b0_cmd0_kpa,b0_p0_kpa",
        rows(40.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3}", c[0], p[1])),
    );
    let (done, folder) = diagnose(&text, false);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let report = json(&folder.path("d/report.json"));
    assert_eq!(report["causes"], serde_json::json!([]), "{}", report["sentence"]);
}

/// Recordings that do not belong together.
#[test]
fn recordings_with_different_channels() {
    let folder = Folder::new();
    let one = csv(
        "t_s,b0_cmd0_kpa,b0_p0_kpa",
        rows(25.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3}", c[0], p[0])),
    );
    let two = csv(
        "t_s,b0_cmd1_kpa,b0_p1_kpa",
        rows(25.0).iter().map(|(t, c, p)| format!("{t:.2},{:.2},{:.3}", c[1], p[1])),
    );
    folder.write("one.csv", one.as_bytes());
    folder.write("two.csv", two.as_bytes());
    let done = run(folder.root(), &["diagnose", "one.csv", "two.csv", "--out", "d"]);
    assert_eq!(done.status, 2);
    assert!(done.stderr.contains("one.csv has the channels b0c0 and two.csv has b0c1"), "{}", done.stderr);
    // The same movements again, and the same rows of another file.
    folder.write("again.csv", format!("# the next day\n{one}").as_bytes());
    let done = run(folder.root(), &["diagnose", "one.csv", "again.csv", "--out", "d"]);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let report = json(&folder.path("d/report.json"));
    assert_eq!(report["data"]["rows"], 5000);
    assert_eq!(report["data"]["file"], "one.csv, again.csv");
}
