//! `--realtime`, `--lock-memory` and `--pin-core`: given, or refused before anything is sent.

use crate::support::pty::PtyBoards;
use pneudrive_host::real_time::RealTime;
use rustix::thread::{CpuSet, sched_getaffinity};
use std::fs;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Scheduling policy in /proc/PID/task/TID/stat (sched.h).
const SCHED_OTHER: &str = "0";
const SCHED_FIFO: &str = "1";

/// The program for a user who may neither lock memory nor have a priority.
fn as_anybody(args: &[&str]) -> Output {
    // Root may everything: become nobody. Others cannot, and need not.
    let script = "ulimit -l 64; ulimit -r 0; \
        if [ \"$(id -u)\" = 0 ]; then exec setpriv --reuid 65534 --regid 65534 --clear-groups \"$@\"; else exec \"$@\"; fi";
    let host = env!("CARGO_BIN_EXE_pneudrive-host");
    Command::new("bash").args(["-c", script, "bash", host]).args(args).output().unwrap()
}

#[test]
fn what_is_not_permitted_is_refused_and_nothing_is_sent() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    for (flag, message) in [
        ("--realtime", "real-time priority 40: not permitted; allow it with"),
        ("--realtime=7", "real-time priority 7: not permitted; allow it with"),
        ("--lock-memory", "locking memory: not permitted ("),
        ("--pin-core=100000", "core 100000: this process may use the cores ["),
    ] {
        let check = &["check", "--devices", "1"][..];
        for command in [&["--duration", "0.1"][..], &["bench", "--devices", "1"], &["ping"], check] {
            let Output { status, stderr, .. } = as_anybody(&[&["--port", &port, flag], command].concat());
            let stderr = String::from_utf8(stderr).unwrap();
            assert_eq!(status.code(), Some(2), "{flag} {command:?}: {stderr}");
            assert!(stderr.contains(message), "{flag} {command:?}: {stderr}");
        }
    }
    assert!(boards.stop().is_empty(), "bytes were sent");
}

/// Name, last core and scheduling policy of each thread.
fn threads(child: &Child) -> Vec<(String, String, String)> {
    let Ok(tasks) = fs::read_dir(format!("/proc/{}/task", child.id())) else { return Vec::new() };
    let thread = |task: fs::DirEntry| {
        let stat = fs::read_to_string(task.path().join("stat")).ok()?;
        let (head, tail) = stat.split_once('(')?.1.rsplit_once(')')?;
        // proc(5): the state is field 3, the processor field 39, the policy field 41.
        let fields: Vec<_> = tail.split_whitespace().collect();
        Some((head.to_owned(), fields.get(36)?.to_string(), fields.get(38)?.to_string()))
    };
    tasks.flatten().filter_map(thread).collect()
}

#[test]
fn the_bus_thread_gets_what_it_is_given_and_no_other_does() {
    let boards = PtyBoards::start(1);
    let allowed = sched_getaffinity(None).unwrap();
    let core = (0..CpuSet::MAX_CPU).find(|&core| allowed.is_set(core)).unwrap();
    let may_have_priority = RealTime::default().priority(7).check().is_ok();
    let mut command = Command::new(env!("CARGO_BIN_EXE_pneudrive-host"));
    command.arg("--port").arg(boards.path()).arg(format!("--pin-core={core}"));
    if may_have_priority {
        command.arg("--realtime=7");
    } else {
        eprintln!("this user may have no real-time priority: only the core is tested");
    }
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let started = Instant::now();
    let bus = loop {
        let threads = threads(&child);
        if let Some(bus) = threads.iter().find(|(name, ..)| name == "pneudrive-bus") {
            let wanted = if may_have_priority { SCHED_FIFO } else { SCHED_OTHER };
            // It starts like any thread, and asks then.
            if bus.2 == wanted {
                let others = threads.iter().filter(|(name, ..)| name != "pneudrive-bus");
                assert!(others.clone().count() > 0);
                others.for_each(|(name, _, policy)| assert_eq!(policy, SCHED_OTHER, "{name}"));
                break bus.clone();
            }
        }
        assert!(started.elapsed() < Duration::from_secs(60), "no bus thread in {threads:?}");
        std::thread::sleep(Duration::from_millis(5));
    };
    assert_eq!(bus.1, core.to_string());
    child.kill().unwrap();
    child.wait().unwrap();
}
