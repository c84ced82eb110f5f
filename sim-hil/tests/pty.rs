//! A real client on the pty, in this process. Time runs only while the front end runs, so nothing
//! depends on how fast the machine is.

use crate::common::packet;
use pneudrive_protocol::{Address, Packet};
use pneudrive_sim::pty::{EmbeddedSim, FrontEnd, PtyOptions, SimError};
use pneudrive_sim::rig::{RigOptions, Timing};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::termios::{OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcsetattr};
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

static NEVER: AtomicBool = AtomicBool::new(false);

fn front_end(boards: usize, timing: Timing, options: &PtyOptions) -> FrontEnd {
    let rig = RigOptions { boards, timing, ..RigOptions::default() };
    let mut front_end = FrontEnd::new(&rig, options).unwrap();
    // The boards measure before they answer.
    run(&mut front_end, 5);
    front_end
}

fn run(front_end: &mut FrontEnd, ms: u64) {
    front_end.run(&NEVER, Some(Duration::from_millis(ms))).unwrap();
}

fn open(path: &Path) -> File {
    OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags(OFlags::NOCTTY.bits().cast_signed())
        .open(path)
        .unwrap()
}

fn readable(client: &File, wait_ms: u16) -> bool {
    let timeout = Timespec::try_from(Duration::from_millis(wait_ms.into())).unwrap();
    poll(&mut [PollFd::new(client, PollFlags::IN)], Some(&timeout)).unwrap() > 0
}

/// Lets time run until ten bytes have come.
fn read_packet(front_end: &mut FrontEnd, client: &mut File) -> Packet {
    let mut bytes = [0; 10];
    let mut filled = 0;
    for _ in 0..2_000 {
        run(front_end, 1);
        if readable(client, 0) {
            filled += client.read(&mut bytes[filled..]).unwrap();
        }
        if filled == bytes.len() {
            return Packet::decode(&bytes).unwrap();
        }
    }
    panic!("{filled} bytes in 2 s of virtual time");
}

fn exchange(front_end: &mut FrontEnd, client: &mut File, board: u8) {
    client.write_all(&packet(board, 102).encode()).unwrap();
    assert_eq!(read_packet(front_end, client).address, Address::of_board(board));
}

#[test]
fn a_client_opens_asks_closes_and_opens_again() {
    for timing in [Timing::Wire, Timing::Instant] {
        let mut front_end = front_end(3, timing, &PtyOptions::default());
        for _ in 0..3 {
            let mut client = open(front_end.path());
            for board in 0..3 {
                exchange(&mut front_end, &mut client, board);
            }
            drop(client);
            run(&mut front_end, 10);
        }
        let report = front_end.report();
        assert_eq!((report.bus.requests, report.bus.answers, report.bus.violations()), (9, 9, 0));
        assert_eq!((report.pace.clients_gone, report.pace.handed_over), (3, 9));
    }
}

#[test]
fn what_one_client_left_unread_does_not_greet_the_next() {
    let mut front_end = front_end(2, Timing::Wire, &PtyOptions::default());
    let mut client = open(front_end.path());
    client.write_all(&packet(0, 102).encode()).unwrap();
    while !readable(&client, 0) {
        run(&mut front_end, 1);
    }
    drop(client);
    run(&mut front_end, 10);
    let mut client = open(front_end.path());
    assert!(!readable(&client, 0));
    exchange(&mut front_end, &mut client, 1);
}

/// The next client opens while the simulator still tidies up after the one before.
#[test]
fn a_clients_settings_last_however_soon_it_opens() {
    let ended = Arc::new(AtomicBool::new(false));
    let options = PtyOptions::default();
    let mut front_end = front_end(1, Timing::Wire, &options);
    let path = front_end.path().to_owned();
    let simulator = std::thread::spawn({
        let ended = Arc::clone(&ended);
        move || front_end.run(&ended, None).unwrap()
    });
    for round in 0..500_usize {
        let mut client = open(&path);
        let mut settings = tcgetattr(&client).unwrap();
        settings.make_raw();
        settings.special_codes[SpecialCodeIndex::VMIN] = 1 + u8::try_from(round % 10).unwrap();
        settings.set_speed(1_000_000).unwrap();
        tcsetattr(&client, OptionalActions::Now, &settings).unwrap();
        // The simulator sees a client only by its bytes.
        client.write_all(&packet(0, 102).encode()).unwrap();
        assert!(readable(&client, 10_000));
        assert_eq!(kept(&tcgetattr(&client).unwrap()), kept(&settings), "client {round}");
    }
    ended.store(true, Ordering::Relaxed);
    simulator.join().unwrap();
}

/// What a port keeps of what it is told: modes, line rate, and how many bytes end a read.
fn kept(of: &Termios) -> ([u32; 4], u32, u8) {
    let modes =
        [of.input_modes.bits(), of.output_modes.bits(), of.control_modes.bits(), of.local_modes.bits()];
    (modes, of.output_speed(), of.special_codes[SpecialCodeIndex::VMIN])
}

/// A stopped client fills the pty; what no longer fits is lost and counted, and it finds its boards
/// again.
#[test]
fn a_client_that_does_not_read_loses_bytes_and_nothing_else() {
    // A pty holds some 70,000 bytes: 0.7 s of a board that talks without end.
    let faults = vec!["babble@0.01,board=0,ms=900".parse().unwrap()];
    let rig = RigOptions { faults, ..RigOptions::default() };
    let mut front_end = FrontEnd::new(&rig, &PtyOptions::default()).unwrap();
    let mut client = open(front_end.path());
    run(&mut front_end, 1_000);
    let lost = front_end.report().pace.overrun_bytes;
    assert!(lost > 0 && lost < 90_000, "{lost} of 90,000 bytes lost");

    let (mut unread, mut read) = ([0; 4096], 0);
    while readable(&client, 50) {
        read += client.read(&mut unread).unwrap() as u64;
    }
    assert_eq!(read + lost, 90_000);
    exchange(&mut front_end, &mut client, 0);
}

#[test]
fn a_fifo_of_one_hands_over_each_byte() {
    let options = PtyOptions { fifo: 1, ..PtyOptions::default() };
    let mut front_end = front_end(1, Timing::Wire, &options);
    let mut client = open(front_end.path());
    exchange(&mut front_end, &mut client, 0);
    assert_eq!(front_end.report().pace.handed_over, 10);
}

#[test]
fn a_client_that_talks_into_the_answer_collides_with_it() {
    let mut front_end = front_end(2, Timing::Wire, &PtyOptions::default());
    let mut client = open(front_end.path());
    let two: Vec<u8> = [packet(0, 102).encode(), packet(1, 102).encode()].concat();
    client.write_all(&two).unwrap();
    while front_end.report().bus.host_characters < 20 {
        run(&mut front_end, 1);
    }
    assert_eq!(front_end.report().bus.collisions, 1);
}

#[test]
fn the_link_points_to_the_port_and_goes_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("port");
    let options = PtyOptions { link: Some(link.clone()), ..PtyOptions::default() };
    // A link that a killed simulator left behind.
    std::os::unix::fs::symlink("/nonexistent", &link).unwrap();
    let rig = RigOptions { timing: Timing::Instant, ..RigOptions::default() };
    let front_end = FrontEnd::new(&rig, &options).unwrap();
    assert_eq!(std::fs::read_link(&link).unwrap(), front_end.path());
    drop(front_end);
    assert!(std::fs::symlink_metadata(&link).is_err());

    // What another simulator's clients use.
    let first = FrontEnd::new(&rig, &options).unwrap();
    let error = FrontEnd::new(&rig, &options).err().unwrap().to_string();
    assert!(error.contains(first.path().to_str().unwrap()) && error.contains("another simulator"), "{error}");
    assert_eq!(std::fs::read_link(&link).unwrap(), first.path());
    drop(first);
    assert!(std::fs::symlink_metadata(&link).is_err());

    std::fs::write(&link, "precious").unwrap();
    let error = FrontEnd::new(&rig, &options).err().unwrap();
    assert!(matches!(error, SimError::Link { .. }), "{error}");
    assert_eq!(std::fs::read_to_string(&link).unwrap(), "precious");
}

#[test]
fn an_embedded_simulator_answers_and_stops_with_a_report() {
    let rig = RigOptions { boards: 3, ..RigOptions::default() };
    let sim = EmbeddedSim::start(&rig, &PtyOptions::default()).unwrap();
    let mut client = open(sim.path());
    let mut answered = 0;
    // The first requests may come before the boards have measured.
    while answered < 20 {
        client.write_all(&packet(answered % 3, 102).encode()).unwrap();
        let mut bytes = [0; 10];
        let mut filled = 0;
        while filled < 10 && readable(&client, 1_000) {
            filled += client.read(&mut bytes[filled..]).unwrap();
        }
        answered += u8::from(Packet::decode(&bytes).is_ok());
    }
    drop(client);
    let report = sim.stop().unwrap();
    assert!(report.bus.answers >= 20);
    assert_eq!(report.bus.violations(), 0);
}

/// What a plain responder does: a client pays for the pty's detour itself.
#[test]
fn undated_requests_begin_when_they_are_seen() {
    for (dates_back, latest_us) in [(false, 0.0), (true, f64::INFINITY)] {
        let options = PtyOptions { dates_back, ..PtyOptions::default() };
        let mut front_end = front_end(1, Timing::Wire, &options);
        let taken_off_us = front_end.report().pace.pty_round_trip_us;
        assert!(taken_off_us <= latest_us && (taken_off_us > 0.0) == dates_back, "{taken_off_us} us");
        let mut client = open(front_end.path());
        exchange(&mut front_end, &mut client, 0);
    }
}
