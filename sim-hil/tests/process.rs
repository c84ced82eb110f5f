//! The program `pneudrive-sim` as a user has it: first line, last line, exit status, messages.

use crate::common::packet;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::fs::OpenOptions;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdout, Command, Output, Stdio};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pneudrive-sim"));
    command.args(arguments);
    command
}

fn output(arguments: &[&str]) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = command(arguments).output().unwrap();
    (status.code(), String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
}

/// Starts it; gives the path that its first line has.
fn start(arguments: &[&str]) -> (Child, BufReader<ChildStdout>, String) {
    let mut child = command(arguments).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap());
    let mut path = String::new();
    lines.read_line(&mut path).unwrap();
    (child, lines, path.trim_end().to_owned())
}

#[test]
fn first_line_is_the_port_and_on_a_signal_the_last_is_json() {
    for signal in [Signal::TERM, Signal::INT] {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("port");
        let (mut child, mut lines, path) =
            start(&["--devices", "2", "--timing", "instant", "--link", link.to_str().unwrap()]);
        assert_eq!(std::fs::read_link(&link).unwrap().to_str().unwrap(), path);

        // Board 1 answers as soon as it has measured.
        let mut port = OpenOptions::new().read(true).write(true).open(&link).unwrap();
        let mut answer = [0; 10];
        let reader = {
            let mut port = port.try_clone().unwrap();
            std::thread::spawn(move || port.read_exact(&mut answer).map(|()| answer))
        };
        while !reader.is_finished() {
            port.write_all(&packet(1, 102).encode()).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        assert_eq!(reader.join().unwrap().unwrap()[..2], [0xFF, 0xFE]);

        kill_process(Pid::from_child(&child), signal).unwrap();
        let mut rest = String::new();
        lines.read_to_string(&mut rest).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0));
        let json: Value = serde_json::from_str(&rest).unwrap();
        for name in ["requests", "answers"] {
            assert!(json[name].as_u64().unwrap() >= 1, "{rest}");
        }
        for name in ["collisions", "early", "overlong"] {
            assert_eq!(json[name], 0, "{rest}");
        }
        assert!(json["faults"].as_object().unwrap().is_empty());
        assert!(std::fs::symlink_metadata(&link).is_err(), "the link is still there");
    }
}

#[test]
fn it_ends_by_itself_after_its_duration_and_counts_faults() {
    let (status, stdout, _) = output(&["--duration", "0.2", "--fault", "stray=1000", "--seed", "3"]);
    assert_eq!(status, Some(0));
    let json: Value = serde_json::from_str(stdout.lines().nth(1).unwrap()).unwrap();
    assert!(json["faults"]["stray"].as_u64().unwrap() > 100, "{stdout}");
    assert!(json["pace"]["virtual_s"].as_f64().unwrap() >= 0.2);
}

/// The law that the boards run, not that of `record`.
#[test]
fn the_rig_file_describes_the_boards() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rig.toml");
    let (status, _, stderr) = output(&["--duration", "0.01", "--rig-out", file.to_str().unwrap()]);
    assert_eq!(status, Some(0), "{stderr}");
    let rig: toml::Table = std::fs::read_to_string(file).unwrap().parse().unwrap();
    let law = pneudrive_control::BoardConfig::default();
    let expected = [
        ("rate_hz", 1e6 / law.loop_period.get() as f64),
        ("kp", law.kp.into()),
        ("kd", law.kd.into()),
        ("saturation", law.saturation.into()),
        ("filter", f64::from(law.filter_previous) / 256.0),
    ];
    for (key, value) in expected {
        assert_eq!(rig["controller"][key].as_float(), Some(value), "{key}");
    }
    assert_eq!(rig["supply"]["pressure_kpa"].as_float(), Some(550.0));
}

#[test]
fn unusable_arguments_are_status_2_and_say_what_would_be_right() {
    let cases: [(&[&str], &str); 18] = [
        (&["--devices", "0"], "0 boards: a bus has 1 to 256"),
        (&["--devices", "257"], "257 boards"),
        (&["--baud", "300"], "300 baud is outside 1200 to 7812500 baud"),
        (&["--effect", "supply_sg=40"], "supply_sag"),
        (&["--effect", "supply_sag=NaN"], "supply_sag"),
        (&["--fault", "bitflip=1"], "the nearest is 'bit_flip'"),
        (&["--fault", "unplug@1,board=4"], "there is no board 4 among 4"),
        (&["--duration", "0"], "'0' is no number of seconds above 0"),
        (&["--link", "/nonexistent/port", "--timing", "instant"], "cannot make the link /nonexistent/port"),
        (&["--rig-out", "/nonexistent/rig.toml"], "cannot write the rig file /nonexistent/rig.toml"),
        (&["--rig-out", "rig.toml", "--firmware", "firmware.elf"], "cannot be used with"),
        (&["--duration", "-1"], "'-1' is no number of seconds above 0"),
        (&["--devices", "-1"], "expected a whole number from 1 to 256"),
        (
            &["record", "--out", "x.csv", "--range", "-50", "5000"],
            "range_kpa low is -50 kPa: expected 0 to 680",
        ),
        (&["record", "--out", "x.csv", "--channels", "100000"], "channels is 100000: expected 1 to 1024"),
        (&["record", "--out", "x.csv", "--open-loop", "5"], "amplitude is 5: expected 0 to 1"),
        (&["record", "--out", "/nonexistent/x.csv"], "x.csv: cannot be created: there is no such folder"),
        (&["record", "--out", "x.csv", "--rig-out", "./x.csv"], "--out and --rig-out are the same file"),
    ];
    for (arguments, message) in cases {
        let (status, stdout, stderr) = output(arguments);
        assert_eq!((status, stdout.as_str()), (Some(2), ""), "{arguments:?}: {stderr}");
        assert!(stderr.starts_with("error: ") && stderr.contains(message), "{arguments:?}: {stderr}");
    }
}

#[test]
fn a_recording_that_exists_is_replaced_only_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, rig) = (path("run.csv"), path("run.toml"));
    let record = |more: &[&str]| {
        output(&[&["record", "--seconds", "0.1", "--out", &csv, "--rig-out", &rig], more].concat())
    };
    std::fs::write(&rig, "precious").unwrap();
    let (status, _, stderr) = record(&[]);
    let message = "run.toml: exists; choose another name, or pass --overwrite";
    assert!(status == Some(2) && stderr.contains(message), "{stderr}");
    assert!(!std::path::Path::new(&csv).exists() && std::fs::read_to_string(&rig).unwrap() == "precious");
    assert_eq!(record(&["--overwrite"]).0, Some(0));
    let first = std::fs::read(&csv).unwrap();
    let (status, _, stderr) = record(&["--seed", "2"]);
    assert!(status == Some(2) && stderr.contains("run.csv: exists; choose another name"), "{stderr}");
    assert_eq!(std::fs::read(&csv).unwrap(), first);
    assert_eq!(record(&["--seed", "2", "--overwrite"]).0, Some(0));
    assert_ne!(std::fs::read(&csv).unwrap(), first);
}

/// A day of simulated time is not over before the signal.
#[test]
fn an_interrupted_recording_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let arguments = ["record", "--seconds", "100000", "--rate", "1000", "--out", file.to_str().unwrap()];
    let child = command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    while std::fs::read_dir(folder.path()).unwrap().count() == 0 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let Output { status, stderr, .. } = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(stderr).unwrap();
    assert!(status.code() == Some(1) && stderr.contains("run.csv: interrupted"), "{status}: {stderr}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_lists_and_the_help_say_what_can_be_given() {
    let (status, faults, _) = output(&["faults"]);
    assert!(status == Some(0) && faults.contains("--fault bit_flip=1e-4,on=answers"));
    let (status, effects, _) = output(&["effects"]);
    assert!(status == Some(0) && effects.contains("supply_sag") && effects.contains("kPa"));
    let (status, help, _) = output(&["--help"]);
    assert!(status == Some(0) && help.contains("Examples:") && help.contains("Exit status"));
}

#[test]
fn completions_and_man_pages_come_from_the_definition() {
    let (code, completions, _) = output(&["completions", "bash"]);
    assert!(code == Some(0) && completions.contains("_pneudrive__sim()") && completions.contains("--effect"));
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(output(&["man", folder.path().to_str().unwrap()]).0, Some(0));
    let page = std::fs::read_to_string(folder.path().join("pneudrive-sim-record.1")).unwrap();
    assert!(page.contains("rig\\-out"), "{page}");
    let (code, _, stderr) = output(&["man", "/no/such/folder"]);
    assert!(code == Some(2) && stderr.contains("/no/such/folder"), "{stderr}");
}
