//! What is refused before a byte is sent, and with which words.

use crate::command_line::program::{program, refused, rows, run, until};
use crate::support::pty::PtyBoards;
use std::fs;

#[test]
fn unusable_arguments_are_refused_with_advice() {
    refused(&[], 2, "no --port given");
    refused(&["--port", "/dev/no-such-port"], 2, "no such port; is the adapter plugged in?");
    refused(&["--port", "simm"], 2, "simm: no such port; did you mean --port sim, the virtual boards?");
    refused(&["--port", "/dev/null"], 2, "not a serial port");
    refused(&["--port", "x", "--devices", "0"], 2, "--devices 0: must be 1 to 4");
    refused(&["--port", "x", "--devices", "5"], 2, "need --max-devices");
    refused(
        &["--port", "x", "--devices", "256", "--max-devices", "256"],
        2,
        "--echo present or --echo absent",
    );
    refused(&["--port", "x", "--max-devices", "257"], 2, "257 is not in 1..=256");
    refused(&["--port", "x", "--baud", "300"], 2, "300 baud is outside 1200 to 7812500 baud");
    refused(&["--port", "x", "--rate", "5001"], 2, "at most 5000.0 Hz, the wire's limit for 1 board");
    refused(&["--port", "x", "--rate", "0"], 2, "--rate 0: must be above 0");
    refused(&["--port", "x", "--rate", "NaN"], 2, "--rate NaN");
    refused(&["--port", "x", "--filter=1.5"], 2, "filter weight");
    refused(&["--port", "x", "--duration", "-1"], 2, "--duration");
    for command in ["NaN", "-100", "776", "1,2,3", "1,2,3,4,5", "a"] {
        refused(&["--port", "x", "--command", command], 2, "--command");
    }
    refused(&["--port", "x", "--command", "1:5"], 2, "boards 0 to 0");
    refused(&["--port", "x", "--record", "run.txt"], 2, "ends in .csv, .csv.gz, .csv.zst or .mcap");
    refused(&["--port", "x", "--record", "/no/such/folder/run.csv"], 2, "no such folder");
    for address in ["nohost", "nohost:", "nohost:90000"] {
        let message = format!("--udp {address}: expected HOST:PORT, such as 127.0.0.1:9870");
        refused(&["--port", "x", "--udp", address], 2, &message);
    }
    refused(&["--port", "x", "--record", "run.csv", "ping"], 2, "not to `ping`");
    refused(&["timing", "--capacitor-nf", "0"], 2, "capacitance");
    refused(&["timing", "--baud", "1"], 2, "1 baud");
    for devices in ["-1", "1000000000"] {
        refused(&["--port", "x", "--devices", devices], 2, "expected a number of boards, 1 to 4");
    }
    refused(&["generate", "aprbs", "--high", "5000"], 2, "--high 5000: the highest set point is 689.5 kPa");
    refused(&["generate", "aprbs", "/no/such/x.csv"], 2, "x.csv: cannot be created: there is no such folder");
}

#[test]
fn a_file_that_is_not_what_its_name_says_is_named_so() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["csv.gz", "csv.zst", "mcap"] {
        let file = folder.path().join(format!("run.{ending}"));
        fs::write(&file, [0x00, 0xff, 0xfe, 0x80]).unwrap();
        let path = file.to_str().unwrap();
        for arguments in [&["info", path][..], &["replay", path, "--view"]] {
            refused(arguments, 2, "the file is damaged at its beginning, or is no .");
        }
    }
}

#[test]
fn output_that_cannot_be_written_is_in_the_exit_status() {
    for arguments in [&["timing"][..], &["generate", "steps", "-"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = program(arguments).stdout(full).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert_eq!(stderr.matches("error: standard output: ").count(), 1, "{stderr}");
    }
}

#[test]
fn a_generated_file_that_exists_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("steps.csv");
    fs::write(&file, "precious").unwrap();
    refused(&["generate", "steps", file.to_str().unwrap()], 2, "steps.csv: exists and is not replaced");
    assert_eq!(fs::read_to_string(&file).unwrap(), "precious");
}

#[test]
fn a_bad_trajectory_is_refused_before_the_port_is_touched() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("steps.csv");
    fs::write(&file, "t_s,b0_cmd0_kpa\n0,100\n1,900\n").unwrap();
    let path = file.to_str().unwrap();
    refused(&["--port", "/dev/no-such-port", "--trajectory", path], 2, "row 3, column b0_cmd0_kpa");
    refused(
        &["--port", "x", "--trajectory", "/no/such.csv"],
        2,
        "/no/such.csv: cannot be opened: there is no such file; `pneudrive-host generate` makes trajectories",
    );
    refused(&["replay", "/no/such.csv"], 2, "there is no such file; a run with `--record FILE` writes one");
    refused(&["replay", "/no/such.csv", "--view"], 2, "there is no such file; a run with `--record FILE`");
}

#[test]
fn what_is_above_a_limit_is_refused_before_the_port_is_touched() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let rig = file("rig.toml", "[limits]\nmax_kpa = 300.0\n[boards.1.channels.3.limits]\nmax_kpa = 100.0\n");
    let steps = file("steps.csv", "t_s,b0_cmd0_kpa\n0,100\n1.5,250\n");
    let with = |more: &[&str], message: &str| {
        refused(&[&["--port", "/dev/no-such-port", "--devices", "2"], more].concat(), 2, message);
    };
    with(
        &["--max-kpa", "200", "--command", "201"],
        "200.8 kPa for channel 0 of board 0 is above its limit of 200",
    );
    with(&["--max-kpa", "200", "--command", "200"], "no such port");
    with(
        &["--rig", &rig, "--command", "150"],
        "--command: 150.3 kPa for channel 3 of board 1 is above its limit of 100",
    );
    with(
        &["--max-kpa", "200", "--trajectory", &steps],
        "steps.csv: at 1.5 s: 250.0 kPa for channel 0 of board 0",
    );
    with(&["--max-kpa", "-1"], "expected a number of kPa gauge from 0 on");
    with(&["--max-rate-kpa-s", "0"], "expected a number above 0");
    let misspelt = file("misspelt.toml", "[limits]\nmax = 300.0\n");
    with(&["--rig", &misspelt], "misspelt.toml:2: unknown key limits.max; did you mean max_kpa?");
    with(&["--rig", "/no/such.toml"], "/no/such.toml: cannot be read: there is no such file");
    let expected = "expected a rig file (TOML), and this is a table, such as a recording or a trajectory";
    with(&["--rig", &steps], expected);
    with(&["--rig", "/no/such.toml"], "; `pneudrive-host init` writes one");
}

/// Who counts boards from 1 would else poll board 0 without any limit.
#[test]
fn a_rig_file_whose_boards_cannot_be_those_of_the_bus_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    let file = rig.to_str().unwrap();
    let limits = "[boards.1.limits]\nmax_kpa = 50.0\n";
    fs::write(&rig, format!("[bus]\nboards = 1\n{limits}")).unwrap();
    let contradicts = "rig.toml:3: [boards.1] has limits, but [bus] boards = 1 means board 0 alone";
    let with = |more: &[&str], message: &str| {
        refused(&[more, &["--port", "/dev/no-such-port", "--rig", file]].concat(), 2, message);
    };
    for command in [&["--command", "300"][..], &["check"], &["calibrate"], &["ping"]] {
        with(command, contradicts);
    }
    with(&["--devices", "2", "--command", "300"], "is above its limit of 50 kPa");
    fs::write(&rig, limits).unwrap();
    with(&["--command", "300"], "rig.toml:1: [boards.1] has limits, but no [bus] boards means board 0 alone");
    with(&["ping"], "no such port");
    // More than switches tell apart, in the file as on the command line.
    fs::write(&rig, "[bus]\nboards = 9\n").unwrap();
    with(
        &[],
        "rig.toml:2: [bus] boards = 9: must be 1 to 4; boards with more than a two-way address switch need --max-devices",
    );
    with(&["--max-devices", "9"], "no such port");
    with(&["--devices", "4"], "no such port");
    // Narrowed on purpose.
    fs::write(&rig, limits).unwrap();
    let narrowed = ["--devices", "1", "--port", "/dev/no-such-port", "--rig", file];
    let (_, _, stderr) = run(&narrowed);
    assert!(stderr.contains("warning: ") && stderr.contains("--devices 1 means board 0 alone"), "{stderr}");
    assert!(stderr.contains("no such port"), "{stderr}");
}

#[test]
fn nobody_there_is_an_error_and_leaves_no_recording() {
    let boards = PtyBoards::start(1);
    boards.last_unplugged.store(true, std::sync::atomic::Ordering::Relaxed);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let port = boards.path().to_str().unwrap();
    refused(
        &["--port", port, "--wait", "0.1", "--record", file.to_str().unwrap()],
        1,
        "none of the 1 board(s) answered within 0.1 s; the last try said: board 0 (0xFFFF): no answer after ",
    );
    assert!(!file.exists());
    refused(&["ping", "--port", port, "--wait", "0.1"], 1, "none of the 1 board(s) answered");
}

#[test]
fn a_second_host_is_refused_by_name() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let mut first = program(&["--port", &port, "--record", file.to_str().unwrap()]).spawn().unwrap();
    until("the first host", || rows(&file) > 10);
    refused(&["ping", "--port", &port], 2, "in use by another process");
    refused(&["--port", &port], 2, "in use by another process");
    first.kill().unwrap();
    first.wait().unwrap();
}
