//! Several recordings of one rig, and what is told of them.

use crate::command_line::lag;
use crate::common::Folder;
use crate::common::cli::{json, run};

const VALVE: &str = "[supply]\npressure_kpa = 550\n[chamber]\nvolume_m3 = 1e-4\n";

fn with(rig: &str) -> String {
    format!("# rig: {}\n{}", serde_json::json!(rig), lag())
}

#[test]
fn recordings_whose_rig_files_say_different_things_are_not_taken_for_one_rig() {
    let folder = Folder::new();
    folder.write("one.csv", with(VALVE).as_bytes());
    folder.write("other.csv", with(&VALVE.replace("550", "300")).as_bytes());
    folder.write("rig.toml", VALVE.as_bytes());
    for (first, second, values) in
        [("one.csv", "other.csv", "550.0, 300.0"), ("other.csv", "one.csv", "300.0, 550.0")]
    {
        let refused = run(folder.root(), &["diagnose", first, second, "--out", "both"]);
        let expected = format!(
            "{first} and {second} were recorded with rig files that say different things: supply.pressure_kpa ({values}); say with --rig"
        );
        assert!(refused.status == 2 && refused.stderr.contains(&expected), "{}", refused.stderr);
        assert!(!folder.path("both").exists());
    }
    let given =
        run(folder.root(), &["diagnose", "one.csv", "other.csv", "--rig", "rig.toml", "--out", "both"]);
    assert!(!given.stderr.contains("different things"), "{}", given.stderr);
}

#[test]
fn without_a_rig_file_it_is_said_what_channels_are_taken_for() {
    let folder = Folder::new();
    folder.write("lag.csv", lag().as_bytes());
    let done = run(folder.root(), &["diagnose", "lag.csv", "--out", "alone"]);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let said = "No drive is recorded and the rig file (--rig) has no [controller], or there is none: channels are taken for pressure regulators.";
    assert!(done.stderr.contains(said), "{}", done.stderr);
    let notes = json(&folder.path("alone/report.json"))["notes"].to_string();
    assert!(notes.contains(said), "{notes}");
}

#[test]
fn a_channel_that_is_left_out_is_told_of_on_the_terminal() {
    let folder = Folder::new();
    let rows = lag().replace("b0_p0_kpa", "b0_p0_kpa,b0_cmd1_kpa,b0_pI_kpa");
    let rows: Vec<String> = rows
        .lines()
        .map(|row| if row.starts_with('t') { row.to_owned() } else { format!("{row},10,9") })
        .collect();
    folder.write("run.csv", rows.join("\n").as_bytes());
    let done = run(folder.root(), &["diagnose", "run.csv", "--out", "alone"]);
    assert_eq!(done.status, 0, "{}", done.stderr);
    for part in [
        "Left out: b0c1: column b0_p1_kpa is missing.",
        "Column b0_pI_kpa is not used: the format knows b0_p1_kpa.",
    ] {
        assert!(done.stderr.contains(part), "{}", done.stderr);
    }
}
