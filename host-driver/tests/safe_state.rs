//! How a run leaves boards of the original kind, whose answers confirm nothing, and boards that
//! check. In virtual time.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_protocol::{Address, CheckedPacket, Counts, Direction, Echo, RequestDecoder};
use std::sync::{Arc, Mutex};

const MS: u64 = 1_000_000;

fn bus(frames: FormatPolicy, script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static) -> Bus<VirtualLine> {
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent)).formats(frames).sessions(false);
    Bus::new(VirtualLine::new(script), options).unwrap()
}

/// A bus of boards of the original kind that read what `pressure` says for (board, the how manieth
/// request).
fn originals(mut pressure: impl FnMut(u8, usize) -> u16 + Send + 'static) -> Bus<VirtualLine> {
    bus(FormatPolicy::Unchecked, move |number, request| {
        let board = 0xFF - request[1];
        vec![(AT_ONCE, answer(board, pressure(board, number)))]
    })
}

/// Ends after a set point of 300 counts was commanded; the boards that did not confirm 0 kPa, and
/// how long it took, ms.
fn end(bus: &mut Bus<VirtualLine>, boards: u8) -> (Vec<u8>, u64) {
    for board in 0..boards {
        bus.exchange(board, counts(300)).unwrap();
    }
    let from_ns = bus.line().now_ns();
    let not_safe = bus.make_safe(0..boards).unwrap();
    (not_safe, (bus.line().now_ns() - from_ns) / MS)
}

/// It answers every request and obeys none: an answer must not count as a confirmation.
#[test]
fn a_board_that_answers_and_keeps_its_pressure_is_named() {
    let mut bus = originals(|board, _| if board == 1 { 300 } else { 102 });
    let (not_safe, took_ms) = end(&mut bus, 3);
    assert_eq!(not_safe, [1]);
    assert!((1_000..1_050).contains(&took_ms), "{took_ms} ms");
    let last = bus.line().requests.last().unwrap();
    assert_eq!(last.1[2..], Counts::ATMOSPHERE.get().to_be_bytes().repeat(4));
}

#[test]
fn a_board_is_commanded_until_it_reads_that_it_is_vented() {
    // One count lower at each request: 188 requests, 5 ms apart.
    let mut bus = originals(|_, number| 301_u16.saturating_sub(number as u16).max(99));
    let (not_safe, took_ms) = end(&mut bus, 1);
    assert!(not_safe.is_empty(), "{not_safe:?}");
    assert!((1_100..1_250).contains(&took_ms), "{took_ms} ms");
}

#[test]
fn a_board_that_falls_too_slowly_is_given_up_after_ten_seconds() {
    let mut bus = originals(|_, number| 900 - (number / 100) as u16);
    let (not_safe, took_ms) = end(&mut bus, 1);
    assert_eq!(not_safe, [0]);
    assert!((10_000..10_050).contains(&took_ms), "{took_ms} ms");
}

/// Its set point has just been given, and its chamber has only begun to fill.
#[test]
fn a_board_that_still_fills_is_not_taken_for_a_vented_one() {
    let mut bus = originals(|_, number| (102 + number as u16 / 2).min(300));
    assert_eq!(end(&mut bus, 1).0, [0]);
}

#[test]
fn a_board_that_reads_atmosphere_is_confirmed_in_a_fifth_of_a_second() {
    let mut bus = originals(|_, number| 98 + number as u16 % 3);
    let (not_safe, took_ms) = end(&mut bus, 4);
    assert!(not_safe.is_empty(), "{not_safe:?}");
    assert!((200..250).contains(&took_ms), "{took_ms} ms");
}

/// `ping` and `bench` command nothing but 0 kPa: there is nothing of theirs to vent, whatever the
/// boards read.
#[test]
fn boards_that_were_never_pressurised_are_confirmed_at_once() {
    let mut bus = originals(|_, _| 300);
    for board in 0..4 {
        bus.ping(board).unwrap();
    }
    let from_ns = bus.line().now_ns();
    assert_eq!(bus.make_safe(0..4), Ok(Vec::new()));
    assert!(bus.line().now_ns() - from_ns < 5 * MS);
}

#[test]
fn a_board_that_falls_silent_is_named() {
    let silent = Arc::new(Mutex::new(false));
    let theirs = Arc::clone(&silent);
    let mut bus = bus(FormatPolicy::Negotiate, move |_, request| {
        let checked = CheckedPacket::decode(request.try_into().unwrap(), Direction::Request).is_ok();
        let answers = !checked && !*theirs.lock().unwrap();
        if answers { vec![(AT_ONCE, answer(0xFF - request[1], 300))] } else { Vec::new() }
    });
    bus.ping(0).unwrap();
    bus.exchange(0, counts(300)).unwrap();
    *silent.lock().unwrap() = true;
    assert_eq!(bus.make_safe(0..1), Ok(vec![0]));
    assert!(bus.line().now_ns() < 1_500 * MS);
}

/// Boards that check confirm by their answer, at whatever pressure, and are told that the host
/// leaves.
#[test]
fn boards_that_check_confirm_at_once_and_are_left() {
    let mut ears: Vec<_> = (0..2).map(|board| RequestDecoder::new(Address::of_board(board))).collect();
    let mut bus = bus(FormatPolicy::Negotiate, move |number, request| {
        let board = 0xFF - request[1];
        let ear = &mut ears[usize::from(board)];
        let heard = request.iter().filter_map(|&byte| ear.push(byte)?.pressures()).last();
        // The first request that says that the host leaves is lost.
        match heard {
            Some(heard) if number != 10 => {
                vec![(AT_ONCE, heard.answer(Address::of_board(board), counts(300)).to_vec())]
            }
            _ => Vec::new(),
        }
    });
    for board in [0, 1] {
        bus.ping(board).unwrap();
    }
    let (not_safe, took_ms) = end(&mut bus, 2);
    assert_eq!((not_safe, took_ms < 10), (Vec::new(), true));
    let sent: Vec<_> = bus.line().requests[4..]
        .iter()
        .map(|(_, bytes)| CheckedPacket::decode(&bytes[..].try_into().unwrap(), Direction::Request).unwrap())
        .map(|request| (request.packet.address.board(), request.is_leave()))
        .collect();
    let vents = [(0, false), (1, false)].repeat(3);
    assert_eq!(sent, [&vents[..], &[(0, true), (0, true), (1, true)]].concat());
}

/// No set point says that the host leaves.
#[test]
fn commands_of_zero_counts_are_no_farewell() {
    let ear = Mutex::new(RequestDecoder::new(Address::of_board(0)));
    let mut bus = bus(FormatPolicy::Checked, move |_, request| {
        let heard =
            request.iter().filter_map(|&byte| ear.lock().unwrap().push(byte)?.pressures()).last().unwrap();
        vec![(AT_ONCE, heard.answer(Address::of_board(0), counts(102)).to_vec())]
    });
    bus.exchange(0, counts(0)).unwrap();
    let bytes: [u8; 10] = bus.line().requests[0].1[..].try_into().unwrap();
    let sent = CheckedPacket::decode(&bytes, Direction::Request).unwrap();
    assert_eq!(sent.packet.values.map(Counts::get), [1, 0, 0, 0]);
}
