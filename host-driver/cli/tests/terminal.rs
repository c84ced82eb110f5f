//! The program on a terminal: a real pty, which closes, and keys.

use crate::support::counts;
use crate::support::pty::PtyBoards;
use pneudrive_host::poller::VENTED;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longer than anything here should take, on any machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A terminal of 80x24 characters with the program on it.
struct Terminal {
    keyboard: Option<File>,
    screen: Arc<Mutex<vt100::Parser>>,
    closes: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
    child: Child,
}

impl Terminal {
    fn run(args: &[&str]) -> Self {
        Self::run_in(args, ".".as_ref())
    }

    fn run_in(args: &[&str], folder: &std::path::Path) -> Self {
        Self::run_as(args, folder, "xterm-256color")
    }

    fn run_as(args: &[&str], folder: &std::path::Path, term: &str) -> Self {
        Self::run_sized(args, folder, term, [24, 80])
    }

    fn run_sized(args: &[&str], folder: &std::path::Path, term: &str, size: [u16; 2]) -> Self {
        let [ws_row, ws_col] = size;
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        tcsetwinsize(&master, Winsize { ws_row, ws_col, ws_xpixel: 0, ws_ypixel: 0 }).unwrap();
        let name = ptsname(&master, Vec::new()).unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave: OwnedFd = rustix::fs::open(name.as_c_str(), flags, Mode::empty()).unwrap();
        let stdio = || Stdio::from(slave.try_clone().unwrap());
        let child = Command::new(env!("CARGO_BIN_EXE_pneudrive-host"))
            .args(args)
            .current_dir(folder)
            .env("TERM", term)
            .stdin(stdio())
            .stdout(stdio())
            .stderr(stdio())
            .spawn()
            .unwrap();
        let screen = Arc::new(Mutex::new(vt100::Parser::new(24, 80, 0)));
        let closes = Arc::new(AtomicBool::new(false));
        let keyboard = File::from(master);
        let (output, shown, stop) = (keyboard.try_clone().unwrap(), Arc::clone(&screen), Arc::clone(&closes));
        let reader = std::thread::spawn(move || read(output, &shown, &stop));
        Self { keyboard: Some(keyboard), screen, closes, reader: Some(reader), child }
    }

    fn press(&mut self, keys: &str) {
        self.keyboard.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    fn wait_for(&self, text: &str) {
        let started = Instant::now();
        loop {
            let contents = self.screen.lock().unwrap().screen().contents();
            if contents.contains(text) {
                return;
            }
            assert!(started.elapsed() < PATIENCE, "{text:?} not in\n{contents}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Closes the window.
    fn close(&mut self) {
        self.closes.store(true, Ordering::Relaxed);
        self.reader.take().map(JoinHandle::join);
        self.keyboard = None;
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    fn end(&mut self) -> ExitStatus {
        let started = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            if started.elapsed() > PATIENCE {
                self.child.kill().unwrap();
                panic!("the program did not end");
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        self.close();
    }
}

/// Shows what the program writes, until the window closes.
fn read(mut output: File, screen: &Mutex<vt100::Parser>, closes: &AtomicBool) {
    let mut bytes = [0; 4096];
    while !closes.load(Ordering::Relaxed) {
        let mut files = [PollFd::new(&output, PollFlags::IN)];
        let patience = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
        if poll(&mut files, Some(&patience)).unwrap() == 0 {
            continue;
        }
        let Ok(count @ 1..) = output.read(&mut bytes) else { return };
        screen.lock().unwrap().process(&bytes[..count]);
    }
}

/// Boards, and the arguments of a run that commands them 511 counts.
fn boards() -> (PtyBoards, Vec<String>) {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let args = ["--port", &port, "--rate", "50", "--command", "343.9", "--late-us", "1000"];
    let args = args.map(str::to_owned).to_vec();
    (boards, args)
}

fn run(args: &[String], more: &[&str]) -> Terminal {
    let all: Vec<&str> = args.iter().map(String::as_str).chain(more.iter().copied()).collect();
    Terminal::run(&all)
}

#[test]
fn a_terminal_that_closes_ends_the_run_with_the_boards_at_zero() {
    for hang_ups in [0, 1, 3] {
        let (boards, args) = boards();
        let mut terminal = run(&args, &[]);
        terminal.wait_for("board 0: present");
        terminal.close();
        // The kernel sends one, a shell one more to its jobs.
        (0..hang_ups).for_each(|_| terminal.signal(Signal::HUP));
        let status = terminal.end();
        assert_eq!(status.code(), Some(0), "{hang_ups} hang-ups: {status}");
        let commanded = boards.stop();
        assert!(commanded.iter().any(|(_, command)| *command == counts(511)));
        assert_vented(commanded.last().unwrap().1);
    }
}

/// 0 kPa, or whatever the host ends with that is no more than that.
fn assert_vented(command: [pneudrive_protocol::Counts; 4]) {
    assert!(command.iter().zip(VENTED).all(|(counts, vented)| *counts <= vented), "{command:?}");
}

#[test]
fn with_keep_running_it_goes_on_without_a_view_and_without_a_load() {
    let (boards, args) = boards();
    let mut terminal = run(&args, &["--keep-running"]);
    terminal.wait_for("board 0: present");
    terminal.close();
    terminal.signal(Signal::HUP);
    std::thread::sleep(Duration::from_millis(500));
    let before = cpu_ticks(&terminal.child);
    std::thread::sleep(Duration::from_secs(2));
    assert!(terminal.child.try_wait().unwrap().is_none(), "it has ended");
    // A loop that spins takes 200 ticks of 10 ms; 50 cycles a second take a few.
    let ticks = cpu_ticks(&terminal.child) - before;
    assert!(ticks < 50, "{ticks} ticks in 2 s");
    terminal.signal(Signal::TERM);
    assert_eq!(terminal.end().code(), Some(0));
    assert_vented(boards.stop().last().unwrap().1);
}

/// Time on a core, in ticks of 10 ms.
fn cpu_ticks(child: &Child) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap()
}

#[test]
fn keys_vent_release_and_end() {
    let (boards, args) = boards();
    let mut terminal = run(&args, &[]);
    terminal.wait_for("board 0: present");
    terminal.press(" ");
    terminal.wait_for("VENTED");
    terminal.press("r");
    terminal.wait_for("Release? Set points stay at 0 kPa.");
    terminal.press("y");
    terminal.wait_for("the boards are released");
    terminal.press("\u{1b}");
    terminal.wait_for("End the run?");
    terminal.press("n");
    terminal.wait_for("? keys");
    terminal.press("\u{1b}");
    terminal.wait_for("End the run?");
    terminal.press("y");
    assert_eq!(terminal.end().code(), Some(0));
    let commanded = boards.stop();
    let last_pressure = commanded.iter().rposition(|(_, command)| *command == counts(511)).unwrap();
    assert!(last_pressure < commanded.len() - 1, "vented, and not back after the release");
    assert_vented(commanded.last().unwrap().1);
}

/// Set points move only on an armed board, by a ramp, and a vent disarms it.
#[test]
fn keys_set_pressures_on_an_armed_board() {
    let (boards, mut args) = boards();
    args[5] = "0".to_owned();
    let mut terminal = run(&args, &["--max-kpa", "300", "--allowance-us", "50000"]);
    terminal.wait_for("board 0: present");
    terminal.wait_for("scale 0 to 300.0 kPa");
    terminal.press("50\r");
    terminal.press("a");
    terminal.wait_for("ARMED");
    terminal.press("301\r");
    terminal.wait_for("above the highest set point of this channel, 300.0 kPa");
    terminal.press("50");
    terminal.wait_for("set point: 50_ kPa");
    terminal.press("\r");
    terminal.wait_for("50.2  kPa");
    terminal.press("+");
    terminal.wait_for("60.3  kPa");
    terminal.press("v");
    terminal.wait_for("VENTED");
    terminal.press("+");
    terminal.press("?");
    terminal.wait_for("r, then y");
    terminal.press("?");
    terminal.press("q");
    assert_eq!(terminal.end().code(), Some(0));
    let commanded = boards.stop();
    let sent: Vec<u16> = commanded.iter().map(|(_, command)| command[0].get()).collect();
    // 50 kPa are 161.8 counts, 60 kPa 173.7. At 100 kPa/s and 50 cycles a second a step is 2.4
    // counts; several at once where the machine is busy.
    let first = sent.iter().position(|&counts| counts > 102).unwrap();
    let rise: Vec<u16> = sent[first..].iter().copied().take_while(|&counts| counts < 162).collect();
    assert!(rise.len() > 3, "by a ramp: {sent:?}");
    assert!(
        sent.contains(&162) && sent.contains(&174) && sent.iter().all(|&counts| counts <= 174),
        "{sent:?}"
    );
    assert!(commanded.iter().all(|(_, command)| command[1].get() == 102), "the other channels stay");
    assert_vented(commanded.last().unwrap().1);
}

/// A key records, in the working folder.
#[test]
fn a_key_records() {
    let (boards, args) = boards();
    let folder = tempfile::tempdir().unwrap();
    let all: Vec<&str> = args.iter().map(String::as_str).collect();
    let mut terminal = Terminal::run_in(&all, folder.path());
    terminal.wait_for("board 0: present");
    terminal.press("w");
    terminal.wait_for("REC 20");
    std::thread::sleep(Duration::from_millis(300));
    terminal.press("w");
    terminal.wait_for("recorded 20");
    terminal.press("q");
    assert_eq!(terminal.end().code(), Some(0));
    boards.stop();
    let file = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    let text = zstd::decode_all(std::fs::File::open(file).unwrap()).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("t_s,b0_cmd0_kpa") && text.contains(",343.896"), "{text}");
}

/// Nothing is drawn on a terminal that cannot be drawn on.
#[test]
fn a_dumb_terminal_gets_lines() {
    let (boards, args) = boards();
    let all: Vec<&str> = args.iter().map(String::as_str).chain(["--duration", "1.5"]).collect();
    let mut terminal = Terminal::run_as(&all, ".".as_ref(), "dumb");
    terminal.wait_for("pressure/command of its four channels, kPa");
    terminal.wait_for("cycles of 1 board(s)");
    terminal.end();
    boards.stop();
}

/// One that `script` makes where no person sits in front of it, and which it sends NUL at the end
/// of its input: that is no Ctrl-Space, which vents.
#[test]
fn a_terminal_without_a_size_gets_lines_and_gives_no_keys() {
    let (boards, args) = boards();
    let all: Vec<&str> = args.iter().map(String::as_str).chain(["--duration", "1.5"]).collect();
    let mut terminal = Terminal::run_sized(&all, ".".as_ref(), "xterm-256color", [0, 0]);
    terminal.wait_for("pressure/command of its four channels, kPa");
    terminal.press("\0");
    terminal.wait_for("cycles of 1 board(s)");
    let shown = terminal.screen.lock().unwrap().screen().contents();
    assert!(!shown.contains("0 kPa is commanded"), "{shown}");
    assert!(terminal.end().success());
    assert!(boards.stop().contains(&(0, counts(511))));
}
