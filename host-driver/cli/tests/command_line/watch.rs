//! `--watch`: the calibrated model beside a run. The program that runs it is a script here, which
//! speaks as `pneudrive-model watch` does.

use crate::command_line::program::{refused, run};
use crate::support::pty::PtyBoards;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

const BEGIN: &str = r#"echo '{"schema":"pneudrive-watch/1","text":"learning b0c0, b0c2","kind":"begin","channels":["b0c0","b0c2"],"learn_s":600}'"#;
const CHANGED: &str = r#"echo '{"schema":"pneudrive-watch/1","text":"b0c2 has changed","kind":"changed","channel":"b0c2","t_s":1.0,"since_s":0.5,"explanations":[{"effect":"exhaust_leak","probability":0.83}]}'"#;

fn script(path: &Path, lines: &[&str]) -> String {
    fs::write(path, format!("#!/bin/sh\n{}\n", lines.join("\n"))).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn what_the_watch_finds_is_told_and_recorded_and_every_row_reaches_it() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let got = path("got.csv");
    let lines = ["read header", BEGIN, "echo \"$header\" > \"$5.csv\"", "read row", CHANGED];
    let more = ["echo \"$row\" >> \"$5.csv\"", "cat >> \"$5.csv\"", "exit 3"];
    let program = script(Path::new(&path("model")), &[&lines[..], &more].concat());
    let (model, recording) = (path("got"), path("run.csv"));
    let (code, stdout, stderr) = run(&[
        "--port",
        &port,
        "--rate",
        "100",
        "--duration",
        "1",
        "--allowance-us",
        "1000000",
        "--plain",
        "--record",
        &recording,
        "--watch",
        &model,
        "--watch-program",
        &program,
    ]);
    assert_eq!(code, Some(0), "{stdout}{stderr}");
    assert!(stderr.contains("learning b0c0, b0c2\n") && stderr.contains("b0c2 has changed\n"), "{stderr}");
    assert!(!stderr.contains("nothing is watched"), "{stderr}");
    let recorded = fs::read_to_string(&recording).unwrap();
    for event in
        ["\"kind\":\"watch\",\"text\":\"learning", "\"kind\":\"changed\",\"board\":0,\"text\":\"b0c2"]
    {
        assert!(recorded.contains(event), "{event}: {recorded}");
    }
    let rows = |text: &str| text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect();
    let (recorded, seen): (Vec<String>, Vec<String>) =
        (rows(&recorded), rows(&fs::read_to_string(&got).unwrap()));
    assert!(recorded.len() > 10);
    assert_eq!(seen, recorded);
}

#[test]
fn a_watch_that_cannot_be_is_refused_before_anything_moves() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let with = |program: &str, expected: &str| {
        let args = [
            "--port",
            &port,
            "--duration",
            "1",
            "--plain",
            "--watch",
            "cal.toml",
            "--watch-program",
            program,
        ];
        refused(&args, 2, expected);
    };
    with("/nowhere/model", "/nowhere/model: not found");
    let complains = ["read header", "echo 'error: cal.toml: no such file' >&2", "exit 2"];
    with(&script(Path::new(&path("complains")), &complains), "--watch cal.toml: cal.toml: no such file");
    with(&script(Path::new(&path("silent")), &["exit 7"]), "without a word");
    with(&script(Path::new(&path("strange")), &["read header", "echo hello"]), "not understood");
}

#[test]
fn a_watch_that_ends_early_is_told_and_the_run_goes_on() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let lines = ["read header", BEGIN, "read row", "echo 'error: line 7: broken' >&2", "exit 1"];
    let program = script(&folder.path().join("dies"), &lines);
    let (code, stdout, stderr) = run(&[
        "--port",
        &port,
        "--rate",
        "100",
        "--duration",
        "1",
        "--allowance-us",
        "1000000",
        "--plain",
        "--watch",
        "cal.toml",
        "--watch-program",
        &program,
    ]);
    assert_eq!(code, Some(0), "{stdout}{stderr}");
    assert!(stderr.contains("nothing is watched any more: line 7: broken"), "{stderr}");
}
