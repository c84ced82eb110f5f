//! How a run ends, and what it leaves and says.

use crate::command_line::program::{program, rows, run, signal, until};
use crate::command_line::schema::{RUN, conforms};
use crate::support::counts;
use crate::support::pty::PtyBoards;
use pneudrive_protocol::Counts;
use rustix::process::Signal;
use std::fs;

#[test]
fn the_json_object_keeps_its_contract() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let (code, stdout, stderr) = run(&[
        "--port",
        port,
        "-n",
        "2",
        "--rate",
        "200",
        "--duration",
        "0.5",
        "--json",
        "--allowance-us",
        "1000000",
        "--echo",
        "absent",
    ]);
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    conforms(&json, RUN);
    assert_eq!((&json["schema"], &json["program"]), (&1.into(), &"pneudrive-host".into()));
    assert_eq!((&json["version"], &json["port"]), (&env!("CARGO_PKG_VERSION").into(), &port.into()));
    assert_eq!(json["ended"], "duration");
    let started = json["started_utc"].as_str().unwrap();
    assert!(started.starts_with("20") && started.ends_with('Z'), "{stdout}");
    assert_eq!(json["devices"], 2);
    let cycles = json["cycles"].as_u64().unwrap();
    assert!((2..=102).contains(&cycles), "at most 0.5 s at 200 Hz and both ends: {cycles}");
    for (group, names) in
        [("loop_hz", &["mean", "std", "min"][..]), ("cycle_us", &["p50", "p99", "p999", "max"])]
    {
        for name in names {
            assert!(json[group][name].is_number(), "{group}.{name} in {stdout}");
        }
    }
    for name in ["seconds", "exchanges", "lost", "rejected", "cpu_share"] {
        assert!(json[name].is_number(), "{name} in {stdout}");
    }
    for board in json["boards"].as_array().unwrap() {
        assert!(board["answered"].as_u64().unwrap() > 0 && board["lost"].is_u64(), "{stdout}");
        assert_eq!(board["state"], "present");
    }
    let sum = json["boards"].as_array().unwrap().iter().map(|b| b["answered"].as_u64().unwrap()).sum::<u64>();
    assert_eq!(json["exchanges"].as_u64().unwrap(), sum + json["lost"].as_u64().unwrap());
}

#[test]
fn signals_end_a_run_with_the_boards_at_zero() {
    for stop in [Signal::INT, Signal::TERM, Signal::HUP] {
        let boards = PtyBoards::start(2);
        let port = boards.path().to_str().unwrap().to_owned();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.csv");
        let args = ["--port", &port, "-n", "2", "--command", "100", "--record", file.to_str().unwrap()];
        let child = program(&args).spawn().unwrap();
        until("rows", || rows(&file) > 10);
        signal(&child, stop);
        let output = child.wait_with_output().unwrap();
        let stdout = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0), "{stop:?}: {stdout}");
        let last = fs::read_to_string(&file).unwrap().lines().last().unwrap().to_owned();
        assert!(last.contains("\"kind\":\"end\",\"text\":\"signal: "), "{last}");
        assert!(stdout.contains("cycles of 2 board(s)") && stdout.contains("run.csv"), "{stdout}");
        let commands = boards.stop();
        assert!(commands.contains(&(1, counts(221))), "100 kPa was commanded");
        for board in [0, 1] {
            let last = commands.iter().rfind(|(of, _)| *of == board).unwrap();
            assert_eq!(last.1, [Counts::ATMOSPHERE; 4]);
        }
    }
}

#[test]
fn a_port_that_vanishes_ends_the_run_with_its_reason() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let child = program(&["--port", &port, "--record", file.to_str().unwrap()]).spawn().unwrap();
    until("rows", || rows(&file) > 10);
    drop(boards);
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("the port is gone"), "{stderr}");
    assert!(stderr.contains("0 kPa was not confirmed by board(s) 0"), "{stderr}");
}

/// `pneudrive-host .. | head -1`
#[test]
fn a_reader_that_has_seen_enough_is_no_panic() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    for args in [
        &["bench", "--port", port, "-n", "1", "--cycles", "50", "--allowance-us", "1000000"][..],
        &["ping", "--port", port],
        &["timing"],
        &["--port", port, "--duration", "0.3"],
    ] {
        let mut child = program(args).spawn().unwrap();
        drop(child.stdout.take());
        let stderr = String::from_utf8(child.wait_with_output().unwrap().stderr).unwrap();
        assert!(!stderr.contains("panicked"), "{args:?}: {stderr}");
    }
}

/// A board that is not there is no failure, unless all are required. It may hear all the same:
/// where it was told more than 0 kPa, it is one.
#[test]
fn a_board_that_never_answered_is_a_failure_where_all_are_required() {
    let boards = PtyBoards::start(2);
    boards.last_unplugged.store(true, std::sync::atomic::Ordering::Relaxed);
    let port = boards.path().to_str().unwrap();
    let args = ["--port", port, "-n", "2", "--wait", "0.2", "--duration", "0.5", "--allowance-us", "100000"];
    let (code, stdout, stderr) = run(&args);
    assert_eq!(code, Some(0), "{stdout}{stderr}");
    assert!(
        stderr.contains("warning: board(s) 1 never answered; are there fewer boards than --devices says?\n"),
        "{stderr}"
    );
    assert_eq!(stderr.matches("board 1 is missing").count(), 1, "{stderr}");
    let (code, _, stderr) = run(&[&args[..], &["--require-all"]].concat());
    assert!(code == Some(1) && stderr.contains("error: --require-all: never answered: board 1"), "{stderr}");
    let (code, _, stderr) = run(&[&args[..], &["--command", "100"]].concat());
    assert!(
        code == Some(1) && stderr.contains("set points were sent to board(s) 1 all the same"),
        "{stderr}"
    );
}

/// That it is gone at the end does not make it one that was never there.
#[test]
fn a_board_that_has_answered_and_is_gone_is_a_failure() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let child = program(&["--port", &port, "-n", "2", "--record", file.to_str().unwrap()]).spawn().unwrap();
    until("rows", || rows(&file) > 10);
    boards.last_unplugged.store(true, std::sync::atomic::Ordering::Relaxed);
    let before = rows(&file);
    until("rows without it", || rows(&file) > before + 10);
    signal(&child, Signal::INT);
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(
        stderr.contains("0 kPa was not confirmed by board(s) 1") && !stderr.contains("never"),
        "{stderr}"
    );
}
