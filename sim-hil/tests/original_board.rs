//! The board of the original kind behaves as the original's firmware does: one fault a test.

use crate::common::{CHARACTER, Drives, Host, MS, StillAir, US, drain, line, packet};
use pneudrive_protocol::{Address, CheckedPacket, Direction, Packet, Sequence};
use pneudrive_sim::board::OriginalBoard;
use pneudrive_sim::bus::{Bus, BusNode};
use pneudrive_sim::fault::FaultInjector;

/// 12-bit code of a sensor at 500 counts.
const CODE: u16 = 2_000;
/// What its filter makes of it.
const SETTLED: u16 = 495;

/// Boards of the original kind, 0.1 s after their power-up vent; their drives.
fn originals(boards: u8) -> (Bus, Drives) {
    let node = |n| {
        let board = OriginalBoard::new(Address::of_board(n), n, line(), u64::from(n) * 234 * US);
        Box::new(board) as Box<dyn BusNode + Send>
    };
    let injector = FaultInjector::new(&[], line(), usize::from(boards), 1).unwrap();
    let air = StillAir { code: CODE, ..StillAir::default() };
    let drives = air.drives.clone();
    let nodes = (0..boards).map(node).collect();
    let mut bus = Bus::new(line(), nodes, Box::new(air), injector, false);
    bus.run_until(OriginalBoard::POWER_UP_VENT_NS + 100 * MS);
    (bus, drives)
}

/// What board `board` does to its first chamber now: -1 vents, 0 holds, 1 fills.
fn drive(drives: &Drives, board: u8) -> f64 {
    let drives = drives.lock().unwrap();
    drives.iter().rev().find(|(position, ..)| *position == board).unwrap().2[0]
}

/// Sends these bytes and gives the boards three loops; what they said.
fn say(bus: &mut Bus, bytes: &[u8]) -> Vec<u8> {
    bus.send(bus.now_ns(), bytes);
    bus.run_until(bus.now_ns() + 3 * OriginalBoard::LOOP_NS);
    drain(bus)
}

fn answer_of(board: u8) -> [u8; 10] {
    packet(board, SETTLED).encode()
}

#[test]
fn it_obeys_a_request_and_answers_once_a_loop_five_counts_low() {
    let (mut bus, drives) = originals(1);
    let host = Host { timeout_ns: 2 * MS };
    assert_eq!(drive(&drives, 0), -1.0, "102 counts commanded, 500 read");
    let from_ns = bus.now_ns();
    for exchange in 1..=100_u64 {
        assert_eq!(host.exchange(&mut bus, packet(0, 900)), Some(packet(0, SETTLED)));
        let took_ns = bus.now_ns() - from_ns;
        assert!(took_ns.div_ceil(OriginalBoard::LOOP_NS) >= exchange, "two answers in one loop");
    }
    bus.run_until(bus.now_ns() + 2 * MS);
    assert_eq!(drive(&drives, 0), 1.0);
}

#[test]
fn a_byte_0xff_before_its_request_makes_board_0_answer_and_drop_the_command() {
    let (mut bus, drives) = originals(1);
    let request = packet(0, 900).encode();
    let early = [&[0xFF], &request[..]].concat();
    assert_eq!(say(&mut bus, &early), answer_of(0));
    assert_eq!(drive(&drives, 0), -1.0, "it was not obeyed");
    // The same after another board's answer that ends in 0xFF: what an ordinary bus shows it.
    let after = [&packet(1, 511).encode(), &request[..]].concat();
    assert_eq!(say(&mut bus, &after), answer_of(0));
    assert_eq!(drive(&drives, 0), -1.0);
    // One byte between them, and it is read right.
    let guarded = [&packet(1, 511).encode(), &[0][..], &request[..]].concat();
    assert_eq!(say(&mut bus, &guarded), answer_of(0));
    assert_eq!(drive(&drives, 0), 1.0);
}

#[test]
fn a_checked_request_is_answered_unchecked_and_dropped() {
    for board in 0..4 {
        let (mut bus, drives) = originals(4);
        let sequence = Sequence::new(5);
        let request = CheckedPacket { packet: packet(board, 900), sequence }.encode(Direction::Request);
        assert_eq!(say(&mut bus, &request), answer_of(board));
        assert_eq!(drive(&drives, board), -1.0);
    }
}

#[test]
fn board_0_answers_on_top_of_an_answer_that_follows_0xff() {
    let (mut bus, _) = originals(2);
    bus.run_until(bus.now_ns() + 100 * US);
    let heard = say(&mut bus, &packet(1, 511).encode());
    assert_ne!(heard, answer_of(1));
    let counters = bus.counters();
    assert_eq!((counters.answers, counters.unasked), (2, 1), "{counters:?}");
    let (mut bus, _) = originals(2);
    assert_eq!(say(&mut bus, &packet(1, 510).encode()), answer_of(1));
    assert_eq!((bus.counters().answers, bus.counters().violations()), (1, 0));
}

#[test]
fn one_value_above_1023_drops_all_four() {
    let (mut bus, drives) = originals(1);
    let mut request = packet(0, 900).encode();
    request[8..].copy_from_slice(&1024_u16.to_be_bytes());
    assert_eq!(say(&mut bus, &request), answer_of(0));
    assert_eq!(drive(&drives, 0), -1.0);
}

#[test]
fn it_has_no_command_timeout() {
    let (mut bus, drives) = originals(1);
    say(&mut bus, &packet(0, 900).encode());
    bus.run_until(bus.now_ns() + 600_000 * MS);
    assert_eq!(drive(&drives, 0), 1.0, "ten minutes later");
}

#[test]
fn after_power_up_it_vents_for_two_seconds_and_says_nothing() {
    let (mut bus, drives) = originals(1);
    say(&mut bus, &packet(0, 900).encode());
    let board = OriginalBoard::new(Address::of_board(0), 0, line(), 0);
    let injector = FaultInjector::new(&[], line(), 1, 1).unwrap();
    let air = StillAir { code: CODE, drives: drives.clone() };
    let mut bus = Bus::new(line(), vec![Box::new(board)], Box::new(air), injector, false);
    bus.run_until(MS);
    assert_eq!(drive(&drives, 0), -1.0);
    assert!(say(&mut bus, &packet(0, 900).encode()).is_empty());
    bus.run_until(OriginalBoard::POWER_UP_VENT_NS - 1);
    assert!(drain(&mut bus).is_empty());
    // It has kept what came, and its filter starts at 0: 46 of 256 parts of 500.
    bus.run_until(OriginalBoard::POWER_UP_VENT_NS + MS);
    assert_eq!(drain(&mut bus), packet(0, 89).encode());
}

/// Eight bytes that do not come are given up after 1 ms, and what came of them is gone.
#[test]
fn a_request_that_ends_early_is_given_up() {
    let (mut bus, drives) = originals(1);
    let request = packet(0, 900).encode();
    assert!(say(&mut bus, &request[..9]).is_empty());
    assert_eq!(say(&mut bus, &[&[0], &request[..]].concat()), answer_of(0));
    assert_eq!(drive(&drives, 0), 1.0);
}

#[test]
fn a_rig_has_them_where_it_is_told_to() {
    let options = |original: &[u8]| pneudrive_sim::rig::RigOptions {
        boards: 3,
        original: original.iter().copied().collect(),
        ..Default::default()
    };
    let mut bus = options(&[1]).build().unwrap();
    bus.run_until(2_100 * MS);
    let host = Host { timeout_ns: 2 * MS };
    let mut checked = |board| {
        let ask = CheckedPacket { packet: packet(board, 102), sequence: Sequence::new(1) };
        let heard = host.exchange_bytes(&mut bus, &ask.encode(Direction::Request));
        bus.run_until(bus.now_ns() + 5 * CHARACTER);
        Packet::decode(&heard.try_into().unwrap()).is_err()
    };
    assert_eq!([0, 1, 2].map(&mut checked), [true, false, true], "who answers in checked packets");
    let error = options(&[1, 3]).build().err().unwrap();
    assert!(error.to_string().contains("position 3"), "{error}");
}
