//! The program, run.

use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pneudrive-host"));
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

pub fn run(args: &[&str]) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = program(args).output().unwrap();
    (status.code(), String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
}

/// It must end with `status` and say `message`.
#[track_caller]
pub fn refused(args: &[&str], status: i32, message: &str) {
    let (code, stdout, stderr) = run(args);
    assert_eq!(code, Some(status), "{args:?}: {stdout}{stderr}");
    assert!(stderr.contains(message), "{args:?} said: {stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

pub fn until(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < Duration::from_secs(60), "waiting for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// Complete rows below the header.
pub fn rows(path: &Path) -> usize {
    fs::read_to_string(path).map_or(0, |text| table(&text).count().saturating_sub(1))
}

/// Header and rows.
pub fn table(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.starts_with('#'))
}
