//! Recordings that are looked at or commanded again, and trajectories that are drawn first.

use crate::command_line::program::{refused, run, table};
use crate::support::pty::PtyBoards;
use pneudrive_protocol::Counts;
use std::fs;

/// 0.6 s of boards 0 and 1 at 100 Hz, as a recording that was begun 7 s after its run. Board 1
/// falls silent at the end.
fn recording() -> String {
    let mut text = "# program: \"test\"\n# boards: [0,1]\n# rig_file: \"arm.toml\"\n# rig: \"[boards.1]\\nname = \\\"elbow\\\"\\n[display]\\nunit = \\\"bar\\\"\\n\"\nt_s".to_owned();
    for board in 0..2 {
        (0..4).for_each(|k| text += &format!(",b{board}_cmd{k}_kpa"));
        (0..4).for_each(|k| text += &format!(",b{board}_p{k}_kpa"));
    }
    for row in 0..60 {
        text += &format!("\n{:.2},50,60,70,80,49.7,60.6,70.7,80.8", 7.0 + 0.01 * f64::from(row));
        text += if row < 55 { ",10,10,10,10,9.3,10.1,10.1,10.1" } else { ",10,10,10,10,,,," };
        if row == 30 {
            text += "\n# event: {\"t_s\":7.305,\"kind\":\"key\",\"text\":\"vented from the keyboard\"}";
        }
    }
    text + "\n"
}

#[test]
fn a_recording_is_shown_with_its_events_names_and_unit_and_without_a_port() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    fs::write(&file, recording()).unwrap();
    let path = file.to_str().unwrap();
    // Slowly, because lines come once a second.
    let (code, stdout, stderr) = run(&["replay", path, "--view", "--plain", "--speed", "0.25"]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("bar\n") && stdout.contains("the recording is over"), "{stdout}");
    // Set points are whole counts.
    assert!(stdout.contains("b0 0.497/0.502 0.606/0.603"), "{stdout}");
    assert!(stdout.contains("b1 0.093/0.098"), "{stdout}");
    assert!(stdout.contains("100.0 Hz") && !stdout.contains("3.6 Hz"), "{stdout}");
    assert!(stderr.contains("vented from the keyboard"), "{stderr}");
}

/// Told now and then, it stays in the view until it is old.
#[test]
fn a_recorded_supply_is_shown_with_its_board() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let rows = (0..200).map(|row| {
        let supply = if row == 2 { "549.66" } else { "" };
        format!("{:.2},50,60,70,80,49.7,60.6,70.7,80.8,{supply}\n", 0.1 * f64::from(row))
    });
    let names = "t_s,b0_cmd0_kpa,b0_cmd1_kpa,b0_cmd2_kpa,b0_cmd3_kpa,b0_p0_kpa,b0_p1_kpa,b0_p2_kpa,b0_p3_kpa";
    fs::write(&file, format!("{names},b0_supply_kpa\n{}", rows.collect::<String>())).unwrap();
    let (code, stdout, stderr) =
        run(&["replay", file.to_str().unwrap(), "--view", "--plain", "--speed", "4"]);
    assert_eq!(code, Some(0), "{stderr}");
    let lines: Vec<_> = stdout.lines().filter(|line| line.contains("b0 49.7/")).collect();
    let shown = |line: &&str| line.ends_with(" supply 549.7");
    assert!(lines.iter().any(shown), "{stdout}");
    assert!(!lines.last().is_none_or(shown), "after 10 s it is old: {stdout}");
}

#[test]
fn a_recording_is_commanded_again_from_its_first_row_on() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(path("run.csv"), recording()).unwrap();
    let args = ["replay", &path("run.csv"), "--port", &port, "--rate", "100", "--record", &path("again.csv")];
    let (code, stdout, stderr) = run(&args);
    assert_eq!(code, Some(0), "{stdout}{stderr}");
    let again = fs::read_to_string(path("again.csv")).unwrap();
    let rows: Vec<_> = table(&again).collect();
    // 0.59 s, although the recording begins at 7 s.
    assert!((40..=70).contains(&rows.len()), "{} rows", rows.len());
    let commands = boards.stop();
    let count = |kpa: f64| Counts::new((102.4 + kpa / 0.841_645).round() as u16).unwrap();
    let wanted = [50.0, 60.0, 70.0, 80.0].map(count);
    assert!(commands.iter().any(|(board, command)| *board == 0 && *command == wanted), "{commands:?}");
}

#[test]
fn what_cannot_be_replayed_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(path("other.csv"), "a,b\n1,2\n").unwrap();
    fs::write(path("run.csv"), recording()).unwrap();
    refused(&["replay", &path("nothing.csv"), "--view"], 2, "nothing.csv");
    refused(&["replay", &path("other.csv"), "--view"], 2, "no recording");
    refused(&["replay", &path("run.csv")], 2, "no --port given");
    refused(&["replay", &path("run.csv"), "--view", "--record", "x.csv"], 2, "--view only shows");
    refused(&["replay", &path("run.csv"), "--port", "x", "--max-kpa", "75"], 2, "above its limit of 75 kPa");
}

#[test]
fn a_preview_draws_checks_limits_and_needs_no_port() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("steps.csv");
    fs::write(&file, "t_s,b0_cmd0_kpa,b0_cmd1_kpa\n0,0,0\n1,120,0\n2,40,0\n").unwrap();
    let path = file.to_str().unwrap();
    let (code, stdout, stderr) = run(&["--trajectory", path, "--preview", "--max-kpa", "150"]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("2.0 s, nothing has been commanded"), "{stdout}");
    assert!(stdout.contains("board 0: channel 0\n  0.0 to 120.0 kPa, limit 150.0"), "{stdout}");
    assert!(stdout.contains("board 0: channels 1, 2, 3\n  0.0 to 0.0 kPa"), "{stdout}");
    refused(&["--trajectory", path, "--preview", "--max-kpa", "100"], 2, "above its limit of 100 kPa");
    refused(&["--preview"], 2, "--trajectory");
}
