//! Every violation is counted, delivered as garbage where a wire would, and a panic in strict mode.

use crate::common::{CHARACTER, Host, MS, ScriptedBoard, US, drain, packet, rig, scripted_bus};
use pneudrive_protocol::{Baud, Packet};
use pneudrive_sim::board::Turnaround;
use pneudrive_sim::bus::{Bus, BusCounters};
use pneudrive_sim::rig::RigOptions;

/// Ends of a request that the host sends at 1 ms.
const REQUEST: u64 = MS;
const REQUEST_END: u64 = REQUEST + 10 * CHARACTER;

/// The host asks board 0 at 1 ms; this board answers as told.
fn asked(board: ScriptedBoard) -> Bus {
    asked_all(vec![board])
}

fn asked_all(boards: Vec<ScriptedBoard>) -> Bus {
    let mut bus = scripted_bus(boards, false);
    bus.send(REQUEST, &packet(0, 300).encode());
    bus.run_until(2 * MS);
    bus
}

fn answer() -> [u8; 10] {
    packet(0, 110).encode()
}

fn violations_of(counters: &BusCounters) -> [u64; 6] {
    let c = counters;
    [c.collisions, c.early, c.overlong, c.gaps, c.truncated, c.unasked]
}

#[test]
fn a_proper_exchange_is_counted_and_breaks_no_rule() {
    let mut bus = asked(ScriptedBoard::new(0, REQUEST_END + 15 * US, CHARACTER, &answer()));
    assert_eq!(drain(&mut bus), answer());
    let counters = bus.counters();
    assert_eq!((counters.requests, counters.answers, counters.violations()), (1, 1, 0));
    assert_eq!((counters.host_characters, counters.board_characters), (10, 10));
}

#[test]
fn a_request_arrives_character_by_character_at_its_stop_bits() {
    let board = ScriptedBoard::new(0, u64::MAX / 2, CHARACTER, &[]);
    let heard = board.heard();
    asked(board);
    let times: Vec<u64> = heard.lock().unwrap().iter().map(|(at, _)| *at).collect();
    assert_eq!(times, (1..=10).map(|n| REQUEST + n * CHARACTER).collect::<Vec<_>>());
}

#[test]
fn two_boards_at_once_are_a_collision_and_both_are_damaged() {
    let late = ScriptedBoard::new(0, REQUEST_END + 23 * US, CHARACTER, &answer());
    let mut bus = asked_all(vec![ScriptedBoard::new(0, REQUEST_END + 20 * US, CHARACTER, &answer()), late]);
    assert_eq!(bus.counters().collisions, 1);
    let heard: Vec<_> = std::iter::from_fn(|| bus.receive()).collect();
    assert_eq!(heard.len(), 20);
    assert!(heard.iter().all(|byte| byte.damaged));
}

#[test]
fn an_answer_that_overlaps_the_request_is_early_and_a_collision() {
    let bus = asked(ScriptedBoard::new(0, REQUEST_END - 3 * US, CHARACTER, &answer()));
    assert_eq!(bus.counters().early, 1);
    assert_eq!(bus.counters().collisions, 1);
}

#[test]
fn an_answer_within_the_least_turnaround_is_early_and_nothing_else() {
    for (delay, early) in [(999, 1), (1_000, 0)] {
        let bus = asked(ScriptedBoard::new(0, REQUEST_END + delay, CHARACTER, &answer()));
        assert_eq!(violations_of(bus.counters()), [0, early, 0, 0, 0, 0], "{delay} ns");
    }
}

#[test]
fn an_eleventh_character_is_overlong_and_cut_off_by_the_555() {
    let eleven: Vec<u8> = answer().into_iter().chain([0x55]).collect();
    let mut bus = asked(ScriptedBoard::new(0, REQUEST_END + 15 * US, CHARACTER, &eleven));
    assert_eq!(violations_of(bus.counters()), [0, 0, 1, 0, 0, 0]);
    let damaged: Vec<bool> = std::iter::from_fn(|| bus.receive()).map(|byte| byte.damaged).collect();
    assert_eq!(damaged, (0..11).map(|n| n == 10).collect::<Vec<_>>());
}

#[test]
fn a_slow_answer_outlasts_the_555_though_it_has_ten_characters() {
    // Half a bit of pause after each character is no gap, but adds up to 104.5 us where 100.97 us
    // are certain.
    let bus = asked(ScriptedBoard::new(0, REQUEST_END + 15 * US, CHARACTER + 500, &answer()));
    assert_eq!(violations_of(bus.counters()), [0, 0, 1, 0, 0, 0]);
}

#[test]
fn a_pause_inside_an_answer_is_a_gap() {
    for (pause, gaps) in [(900, 0), (1_100, 1)] {
        let board = ScriptedBoard::new(0, REQUEST_END + 15 * US, CHARACTER, &answer()).with_pause(4, pause);
        assert_eq!(asked(board).counters().gaps, gaps, "{pause} ns");
    }
}

#[test]
fn an_answer_that_stops_half_way_is_truncated_when_the_host_goes_on() {
    let mut bus = asked(ScriptedBoard::new(0, REQUEST_END + 15 * US, CHARACTER, &answer()[..6]));
    assert_eq!((bus.counters().truncated, bus.counters().answers), (0, 0));
    bus.send(3 * MS, &packet(1, 300).encode());
    bus.run_until(4 * MS);
    assert_eq!(violations_of(bus.counters()), [0, 0, 0, 0, 1, 0]);
}

#[test]
fn who_is_not_asked_must_not_speak() {
    let twice: Vec<u8> = answer().into_iter().chain(answer()).collect();
    let again = ScriptedBoard::new(0, REQUEST_END + 15 * US, CHARACTER, &twice).with_pause(10, 50 * US);
    assert_eq!(violations_of(asked(again).counters()), [0, 0, 0, 0, 0, 1]);

    let other = ScriptedBoard::new(1, REQUEST_END + 15 * US, CHARACTER, &packet(1, 110).encode());
    assert_eq!(violations_of(asked(other).counters()), [0, 0, 0, 0, 0, 1]);
}

#[test]
fn ten_bytes_that_are_no_packet_are_no_request() {
    let mut bus = scripted_bus(vec![ScriptedBoard::new(0, u64::MAX / 2, CHARACTER, &[])], false);
    bus.send(MS, &[0; 10]);
    bus.send(2 * MS, &packet(0, 5).encode()[..9]);
    // A stray byte right before a request hides it from nobody.
    let mut shifted = vec![0x17];
    shifted.extend(packet(0, 5).encode());
    bus.send(3 * MS, &shifted);
    bus.run_until(4 * MS);
    assert_eq!((bus.counters().requests, bus.counters().host_characters), (1, 30));
}

#[test]
#[should_panic(expected = "board at position 0 answered 600 ns early")]
fn strict_mode_panics_on_an_early_answer() {
    let board = ScriptedBoard::new(0, REQUEST_END + 400, CHARACTER, &answer());
    let mut bus = scripted_bus(vec![board], true);
    bus.send(REQUEST, &packet(0, 300).encode());
    bus.run_until(2 * MS);
}

#[test]
#[should_panic(expected = "board at position 1 began while board at position 0 spoke")]
fn strict_mode_panics_on_a_collision() {
    let boards = vec![
        ScriptedBoard::new(0, REQUEST_END + 20 * US, CHARACTER, &answer()),
        ScriptedBoard::new(1, REQUEST_END + 23 * US, CHARACTER, &answer()),
    ];
    let mut bus = scripted_bus(boards, true);
    bus.send(REQUEST, &packet(0, 300).encode());
    bus.run_until(2 * MS);
}

#[test]
fn native_boards_keep_every_rule_for_thousands_of_exchanges() {
    let mut bus = rig(4, &[]);
    let host = Host::default();
    for n in 0..4_000_u16 {
        let request = packet((n % 4) as u8, 102 + n % 820);
        let answer: Option<Packet> = host.exchange(&mut bus, request);
        assert_eq!(answer.map(|packet| packet.address), Some(request.address), "exchange {n}");
    }
    let counters = bus.counters();
    assert_eq!((counters.requests, counters.answers, counters.violations()), (4_000, 4_000, 0));
}

/// A host that asks again with the answer's last stop bit, whatever the boards' turnaround.
#[test]
fn requests_right_behind_the_answer_are_answered_at_any_turnaround_and_baud_rate() {
    for delay_us in [1, 2, 5, 15, 20, 100, 1_000] {
        for rate in [9_600, 115_200, 1_000_000, 3_000_000] {
            let options = RigOptions {
                boards: 2,
                baud: Baud::new(rate).unwrap(),
                turnaround: Turnaround::Fixed { delay_ns: delay_us * US },
                strict: true,
                ..RigOptions::default()
            };
            let mut bus = options.build().unwrap();
            bus.run_until(2 * MS);
            let host = Host { timeout_ns: 100 * MS };
            for n in 0..40 {
                let answer = host.exchange(&mut bus, packet(n / 2 % 2, 300));
                assert!(answer.is_some(), "exchange {n}, {delay_us} us, {rate} baud");
            }
        }
    }
}
