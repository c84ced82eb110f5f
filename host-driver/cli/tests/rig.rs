//! The rig file, as the program uses it: where the boards are, and what their counts mean.

use crate::support::pty::PtyBoards;
use pneudrive_protocol::Counts;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn run(args: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pneudrive-host"));
    // Answers may take long on a busy machine; that is no loss here.
    let patient: &[&str] = if args.contains(&"--allowance-us") {
        &[]
    } else {
        &["--echo", "absent", "--allowance-us", "1000000"]
    };
    let output = command.args(args).args(patient).stdin(Stdio::null()).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// A rig file for `boards`, with more in it.
fn rig(folder: &Path, boards: &PtyBoards, count: u16, more: &str) -> PathBuf {
    let file = folder.join("rig.toml");
    let port = boards.path().display();
    fs::write(&file, format!("[bus]\nport = \"{port}\"\nboards = {count}\nrate_hz = 200\n{more}")).unwrap();
    file
}

#[test]
fn port_boards_rate_and_unit_come_from_the_file_and_the_command_line_before_it() {
    let boards = PtyBoards::start(2);
    let folder = tempfile::tempdir().unwrap();
    let file = rig(folder.path(), &boards, 2, "[display]\nunit = \"bar\"\n[boards.1]\nname = \"elbow\"\n");
    let file = file.to_str().unwrap();
    let patient = ["--duration", "0.3", "--echo", "absent", "--allowance-us", "1000000"];
    let (code, stdout, stderr) = run(&[&["--rig", file, "--json"], &patient[..]].concat());
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((&json["devices"], &json["port"]), (&2.into(), &boards.path().to_str().unwrap().into()));
    let most = 200.0 * json["seconds"].as_f64().unwrap() + 1.0;
    assert!(json["cycles"].as_f64().unwrap() <= most, "at 200 Hz: {stdout}");
    assert!(stderr.contains("of its four channels, bar"), "{stderr}");
    let (code, stdout, stderr) =
        run(&[&["--rig", file, "-n", "1", "--unit", "psi", "--json"], &patient[..]].concat());
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("\"devices\":1,") && stderr.contains("channels, psi"), "{stdout}{stderr}");
    let (code, stdout, _) = run(&["ping", "--rig", file, "--count", "2"]);
    assert_eq!(code, Some(0));
    assert!(stdout.contains("board 1 (elbow): 2 of 2 answered"), "{stdout}");
    assert!(stdout.contains("-0.003 -0.003 -0.003 -0.003 bar"), "{stdout}");
}

/// The virtual boards here read what they are commanded.
#[test]
fn set_points_and_pressures_are_converted_with_each_channels_own_calibration() {
    let boards = PtyBoards::start(2);
    let folder = tempfile::tempdir().unwrap();
    let calibration = "[boards.1.channels.2.sensor]\nzero_counts = 110.0\nkpa_per_count = 0.9\n";
    let file = rig(folder.path(), &boards, 2, calibration);
    let run_csv = folder.path().join("run.csv");
    let (rig, record) = (file.to_str().unwrap(), run_csv.to_str().unwrap());
    let (code, _, stderr) = run(&["--rig", rig, "--command", "100", "--duration", "0.3", "--record", record]);
    assert_eq!(code, Some(0), "{stderr}");
    let text = fs::read_to_string(&run_csv).unwrap();
    assert!(text.contains("# calibration: {\"1\":[{"), "{text}");
    assert!(text.contains("# rig: \"[bus]\\nport = "), "{text}");
    let header: Vec<&str> = text.lines().find(|line| line.starts_with("t_s")).unwrap().split(',').collect();
    let row: Vec<&str> = text.lines().rfind(|line| !line.starts_with('#')).unwrap().split(',').collect();
    let cell = |name: &str| row[header.iter().position(|column| *column == name).unwrap()];
    // 100 kPa are 221.2 counts nominally; here they are 221.1 too, which mean 99.9 kPa.
    assert_eq!((cell("b1_cmd1_kpa"), cell("b1_cmd2_kpa")), ("99.819", "99.900"));
    assert_eq!((cell("b1_p1_kpa"), cell("b1_p2_kpa")), ("99.819", "99.900"));
    // What is recorded is played again to the count.
    let again = folder.path().join("again.csv");
    let args = ["--rig", rig, "--trajectory", record, "--record", again.to_str().unwrap()];
    let (code, _, stderr) = run(&args);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(fs::read_to_string(&again).unwrap().contains(",99.900,"));
    let commands = boards.stop();
    assert!(commands.iter().any(|(board, command)| *board == 1 && command[2] == Counts::saturating(221)));
    assert_eq!(commands.last().unwrap().1, [Counts::ATMOSPHERE; 4]);
}

/// 102 counts, everybody's 0 kPa, would be 6 kPa at a sensor whose zero is 95.
#[test]
fn a_vent_is_0_kpa_at_the_lowest_zero() {
    let boards = PtyBoards::start(1);
    let folder = tempfile::tempdir().unwrap();
    let calibration = "[boards.0.channels.0.sensor]\nzero_counts = 95.0\nkpa_per_count = 0.84\n";
    let file = rig(folder.path(), &boards, 1, calibration);
    let (code, _, stderr) =
        run(&["--rig", file.to_str().unwrap(), "--command", "50,0,0,0", "--duration", "0.2"]);
    assert_eq!(code, Some(0), "{stderr}");
    let commands = boards.stop();
    assert_eq!(commands.last(), Some(&(0, [Counts::saturating(95); 4])));
    assert!(commands.iter().all(|(_, command)| command[1..] == [Counts::saturating(95); 3]));
}

#[test]
fn a_calibration_that_no_board_has_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rig.toml");
    fs::write(&file, "[sensor]\nbits = 12\nzero_counts = 409.6\nkpa_per_count = 0.21\n").unwrap();
    let (code, _, stderr) = run(&["--port", "x", "--rig", file.to_str().unwrap()]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("rig.toml:2: sensor.bits = 12: expected 10"), "{stderr}");
}

/// The rig file's reader knows no protocol, and has a limit of its own: the same one.
#[test]
fn the_line_rates_of_the_rig_file_are_those_of_the_command_line() {
    use pneudrive_host::rig::Rig;
    use pneudrive_protocol::Baud;
    let taken = |rate: u32| Rig::parse("rig.toml", &format!("[bus]\nbaud = {rate}\n")).is_ok();
    assert!(taken(Baud::MIN) && taken(Baud::MAX));
    assert!(!taken(Baud::MIN - 1) && !taken(Baud::MAX + 1));
}
