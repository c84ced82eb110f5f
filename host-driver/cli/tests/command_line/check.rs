//! The self-test as users run it. What it finds is tested in virtual time
//! (`host-driver/check/tests/virtual_rigs.rs`).

use crate::command_line::program::{program, refused, run, signal};
use crate::command_line::schema::{CHECK, conforms};
use crate::support::pty::PtyBoards;
use rustix::process::Signal;
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::Child;
use std::sync::atomic::Ordering;

/// Boards behind this pty answer with whatever they are commanded, at once: no rate and no dead
/// time, and nothing wrong.
#[test]
fn a_check_says_what_it_could_not_measure_and_is_compared_with_the_one_before() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (page, baseline) = (path("check.html"), path("base.json"));
    let args = ["check", "--port", &port, "--stretch", "0.5", "--json", "--allowance-us", "50000"];
    let args = [&args[..], &["--page", &page, "--baseline", &baseline]].concat();
    let value = |report: &Value, quantity: &str, channel: usize| {
        let values = report["boards"][0]["values"].as_array().unwrap();
        let found = values.iter().find(|one| one["quantity"] == quantity && one["channel"] == channel);
        found.unwrap().clone()
    };
    let (code, stdout, stderr) = run(&args);
    assert_eq!(code, Some(0), "{stdout}{stderr}");
    let first: Value = serde_json::from_str(&stdout).unwrap();
    conforms(&first, CHECK);
    assert_eq!((&first["verdict"], &first["schema"]), (&"not_measured".into(), &1.into()), "{stdout}");
    assert_eq!(value(&first, "hold", 3)["verdict"], "pass");
    assert!(value(&first, "fill_rate", 3)["note"].as_str().unwrap().contains("too few readings"));
    assert!(fs::read_to_string(&page).unwrap().contains("<h1>Check of"));
    // As if channel 3 had been held elsewhere then.
    let mut stored: Value = serde_json::from_str(&fs::read_to_string(&baseline).unwrap()).unwrap();
    for one in stored["boards"][0]["values"].as_array_mut().unwrap() {
        if one["quantity"] == "hold" && one["channel"] == 3 {
            one["value"] = 5.0.into();
        }
    }
    fs::write(&baseline, stored.to_string()).unwrap();
    // A disk that is full at the end takes nothing away from what is shown.
    let args: Vec<_> = args.iter().map(|&arg| if arg == page { "/dev/full" } else { arg }).collect();
    let (code, stdout, stderr) = run(&args);
    assert_eq!(code, Some(1), "{stdout}{stderr}");
    assert!(stderr.contains("error: /dev/full: No space left"), "{stderr}");
    assert!(stderr.contains("the check failed"), "{stderr}");
    let second: Value = serde_json::from_str(&stdout).unwrap();
    let hold = value(&second, "hold", 3);
    assert_eq!((&hold["verdict"], &hold["before"]), (&"fail".into(), &5.0.into()));
    assert_eq!(value(&second, "hold", 2)["verdict"], "pass");
    assert_eq!(second["baseline_utc"], first["started_utc"]);
}

/// What is said of a check of so many boards that `end` breaks off once it has begun, on both
/// outputs. It becomes no baseline.
fn broken_off(count: u8, end: impl FnOnce(&PtyBoards, &Child)) -> (String, String) {
    let boards = PtyBoards::start(count);
    let port = boards.path().to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let baseline = folder.path().join("base.json");
    let args = ["check", "--port", port, "-n", &count.to_string(), "--allowance-us", "50000"];
    let mut child =
        program(&[&args[..], &["--baseline", baseline.to_str().unwrap()]].concat()).spawn().unwrap();
    let mut said = String::new();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    while !said.contains("checking board 0") {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
    }
    end(&boards, &child);
    let output = child.wait_with_output().unwrap();
    stderr.read_to_string(&mut said).unwrap();
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stdout}{said}");
    assert!(!baseline.exists() && stdout.contains("is no baseline\n"), "{stdout}");
    (stdout, said)
}

/// Nobody has seen whether the boards work.
#[test]
fn a_check_that_was_interrupted_says_nothing_of_the_boards() {
    let (stdout, stderr) = broken_off(2, |_, child| signal(child, Signal::INT));
    for line in ["board 0: broken off: interrupted\n", "board 1: broken off: not done\n"] {
        assert!(stdout.contains(&format!("not measured: {line}")), "{stdout}");
    }
    assert!(stdout.contains("it says nothing of boards that it had not finished"), "{stdout}");
    assert!(!stdout.contains("fail") && !stdout.contains("does not work"), "{stdout}");
    assert!(stderr.contains("error: the check was broken off") && !stderr.contains("failed"), "{stderr}");
}

#[test]
fn a_board_that_ends_a_check_fails_it() {
    let (stdout, stderr) = broken_off(1, |boards, _| boards.last_unplugged.store(true, Ordering::Relaxed));
    assert!(stdout.contains("fail: board 0: broken off: the board does not answer\n"), "{stdout}");
    assert!(stdout.contains("it does not work as it should"), "{stdout}");
    assert!(stderr.contains("the check failed"), "{stderr}");
}

/// Nobody asked for it, and it was sent 0 kPa alone.
#[test]
fn a_board_that_is_not_there_does_not_fail_the_check_of_another() {
    let boards = PtyBoards::start(2);
    boards.last_unplugged.store(true, Ordering::Relaxed);
    let port = boards.path().to_str().unwrap();
    let args = ["check", "--port", port, "-n", "2", "--board", "0", "--stretch", "0.5", "--wait", "0.2"];
    let folder = tempfile::tempdir().unwrap();
    let baseline = folder.path().join("base.json");
    let more = ["--allowance-us", "100000", "--baseline", baseline.to_str().unwrap()];
    let (code, stdout, stderr) = run(&[&args[..], &more].concat());
    assert_eq!(code, Some(0), "{stdout}{stderr}");
    assert!(
        stderr.contains("warning: board(s) 1 never answered; are there fewer boards than --devices says?\n"),
        "{stderr}"
    );
}

#[test]
fn what_cannot_be_checked_is_refused_before_anything_moves() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(path("low.toml"), "[boards.0.channels.3.limits]\nmax_kpa = 90.0\n").unwrap();
    fs::write(path("bad.json"), "{}").unwrap();
    refused(&["check", "--port", "x", "--rig", &path("low.toml")], 2, "channel 3: a check up to 72.0 kPa");
    refused(&["check", "--port", "x", "--baseline", &path("bad.json")], 2, "--new-baseline replaces it");
    for (option, file) in
        [("--page", "/proc/check.html"), ("--baseline", "/proc/base.json"), ("--page", "/no/check.html")]
    {
        refused(
            &["check", "--port", "x", option, file],
            2,
            &format!("{file}: nothing can be written there: "),
        );
    }
    refused(&["check", "--port", "x", "--stretch", "0.1"], 2, "expected 0.5 to 10");
    refused(&["check", "--port", "x", "--board", "2"], 2, "means boards 0 to 0");
    refused(&["check", "--port", "x", "--rate", "50000"], 2, "the wire's limit");
}
