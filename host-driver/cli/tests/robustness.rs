//! The program while its surroundings misbehave: the port goes and comes back, the process is
//! stopped, the machine is busy.

use crate::support::pty::PtyBoards;
use rustix::process::{Pid, Signal, kill_process};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Allowances of a second: the machine that runs the tests may be busy with others.
const PATIENT: &[&str] = &["--allowance-us", "1000000", "--late-us", "1000000"];
/// Where no exchange may be lost.
const VERY_PATIENT: &[&str] = &["--allowance-us", "10000000", "--echo", "absent"];

/// A host that records, with its output in files.
struct Host {
    child: Child,
    folder: tempfile::TempDir,
}

impl Host {
    fn start(port: &Path, more: &[&str]) -> Self {
        Self::start_in(tempfile::tempdir().unwrap(), port, more)
    }

    fn start_in(folder: tempfile::TempDir, port: &Path, more: &[&str]) -> Self {
        let file = |name: &str| File::create(folder.path().join(name)).unwrap();
        let args = ["--rate", "200", "--json"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_pneudrive-host"));
        command.arg("--port").arg(port).args(args).args(more);
        command.arg("--record").arg(folder.path().join("run.csv"));
        command.stdin(Stdio::null()).stdout(file("stdout")).stderr(file("stderr"));
        Self { child: command.spawn().unwrap(), folder }
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(name)).unwrap_or_default()
    }

    /// Rows of the recording without its header.
    fn rows(&self) -> Vec<String> {
        let text = self.text("run.csv");
        text.lines().filter(|line| !line.starts_with('#')).skip(1).map(str::to_owned).collect()
    }

    #[track_caller]
    fn says(&mut self, what: &str) {
        self.until(what, |host| host.text("stderr").contains(what));
    }

    #[track_caller]
    fn until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let started = Instant::now();
        while !done(self) {
            let ended = self.child.try_wait().unwrap();
            assert!(ended.is_none(), "ended ({ended:?}) before {what}: {}", self.text("stderr"));
            assert!(started.elapsed() < Duration::from_secs(60), "no {what} in {}", self.text("stderr"));
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[track_caller]
    fn more_rows(&mut self) {
        let before = self.rows().len();
        self.until("more rows", |host| host.rows().len() > before + 10);
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Ends it by Ctrl-C: it must not fail. Returns its JSON object.
    #[track_caller]
    fn stop(&mut self) -> serde_json::Value {
        self.signal(Signal::INT);
        let status = self.child.wait().unwrap();
        let stderr = self.text("stderr");
        assert!(status.success() && !stderr.contains("panicked"), "{status:?}: {stderr}");
        serde_json::from_str(&self.text("stdout")).unwrap()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Times of the rows, s.
fn times(rows: &[String]) -> Vec<f64> {
    rows.iter().map(|row| row.split(',').next().unwrap().parse().unwrap()).collect()
}

/// Whether the row has no pressures: nobody answered.
fn is_empty(row: &str) -> bool {
    row.ends_with(",,,,")
}

/// Boards behind a link, as udev makes them for adapters.
fn plug_in(link: &Path) -> PtyBoards {
    let boards = PtyBoards::start(1);
    // Made aside and moved over, as udev does it: there is never half a link.
    let aside = link.with_extension("new");
    std::os::unix::fs::symlink(boards.path(), &aside).unwrap();
    fs::rename(&aside, link).unwrap();
    boards
}

/// A host that has polled a board and recorded it, and whose adapter has been unplugged then. The
/// adapter's link still stands in the host's folder.
fn unplugged(arguments: &[&str]) -> (PathBuf, Host) {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("usb-adapter");
    let boards = plug_in(&link);
    let mut host = Host::start_in(folder, &link, arguments);
    host.more_rows();
    drop(boards);
    (link, host)
}

#[test]
fn an_adapter_that_is_unplugged_and_plugged_in_again_is_polled_on() {
    let (link, mut host) = unplugged(PATIENT);
    host.says("the port is gone (adapter unplugged, or the other end closed); waiting for it to come back");
    let empty_rows = |host: &Host| host.rows().iter().filter(|row| is_empty(row)).count();
    host.until("rows without pressures", |host| empty_rows(host) >= 3);
    // The old link is still there, and its pseudo-terminal's name is given to the next one that
    // anybody opens: it is not for us.
    let somebody = PtyBoards::start(1);
    let before = empty_rows(&host);
    host.until("more rows without pressures", |host| empty_rows(host) >= before + 3);
    assert!(somebody.stop().is_empty(), "a stranger's terminal was written to");
    fs::remove_file(&link).unwrap();

    let boards = plug_in(&link);
    host.says("the port is back after ");
    host.until("pressures again", |host| host.rows().last().is_some_and(|row| !is_empty(row)));
    let json = host.stop();
    assert_eq!(json["boards"][0]["state"], "present", "{json}");
    assert!(!boards.stop().is_empty());

    let rows = host.rows();
    assert_eq!(json["recording"]["rows"], rows.len(), "{json}");
    assert!(times(&rows).windows(2).all(|pair| pair[0] < pair[1]), "time goes on in the recording");
    let gone = rows.iter().position(|row| is_empty(row)).unwrap();
    assert!(rows[..gone].len() > 10 && !is_empty(rows.last().unwrap()));
}

#[test]
fn a_run_that_ends_while_the_port_is_gone_says_that_the_boards_are_not_safe() {
    let (_link, mut host) = unplugged(PATIENT);
    host.says("waiting for it to come back");
    host.signal(Signal::INT);
    assert_eq!(host.child.wait().unwrap().code(), Some(1));
    let stderr = host.text("stderr");
    assert!(stderr.contains("0 kPa was not confirmed by board(s) 0"), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&host.text("stdout")).unwrap();
    assert_eq!(json["boards"][0]["state"], "missing", "{json}");
}

#[test]
fn a_port_that_vanishes_ends_a_run_that_is_told_so() {
    let (_link, mut host) = unplugged(&[PATIENT, &["--no-reopen"]].concat());
    assert_eq!(host.child.wait().unwrap().code(), Some(1));
    assert!(host.text("stderr").contains("the port is gone"));
}

/// Another host took the port while it was gone: this one says so and waits.
#[test]
fn a_port_that_comes_back_in_other_hands_is_not_shared() {
    let (link, mut host) = unplugged(PATIENT);
    host.says("waiting for it to come back");
    fs::remove_file(&link).unwrap();

    let boards = PtyBoards::start(1);
    let options = pneudrive_host::line::SerialOptions::default();
    let other = pneudrive_host::line::SerialPort::open(boards.path(), options).unwrap();
    std::os::unix::fs::symlink(boards.path(), &link).unwrap();
    host.says("the port cannot be used yet: ");
    host.says("in use by another process");
    drop(other);
    host.says("the port is back after ");
    host.stop();
}

/// Ctrl-Z and fg, or a debugger.
#[test]
fn a_stopped_process_goes_on_and_says_so() {
    let boards = PtyBoards::start(1);
    let mut host = Host::start(boards.path(), &["--allowance-us", "200000"]);
    host.more_rows();
    host.signal(Signal::STOP);
    std::thread::sleep(Duration::from_millis(2_000));
    host.signal(Signal::CONT);
    host.says("the host stood still for ");
    host.more_rows();
    let json = host.stop();
    assert_eq!(json["boards"][0]["state"], "present", "{json}");
    let times = times(&host.rows());
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "time goes on in the recording");
    assert!(times.windows(2).any(|pair| pair[1] - pair[0] > 1.0), "and shows the gap");
}

/// Every core has something else to do all the time.
#[test]
fn a_busy_machine_costs_speed_and_nothing_else() {
    let boards = PtyBoards::start(1);
    let mut host = Host::start(boards.path(), VERY_PATIENT);
    host.more_rows();
    let enough = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(2, usize::from) {
            scope.spawn(|| {
                while !enough.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        std::thread::sleep(Duration::from_millis(700));
        enough.store(true, Ordering::Relaxed);
    });
    host.more_rows();
    let json = host.stop();
    assert_eq!((&json["lost"], &json["boards"][0]["state"]), (&0.into(), &"present".into()), "{json}");
}
