//! What one disturbed exchange does to the next ones, in virtual time.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, ExchangeError, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{BoardState, PollerOptions, Polling, SetPoints};
use pneudrive_protocol::false_address::guard_pause_ns;
use pneudrive_protocol::{Baud, Counts, Echo};
use std::time::Duration;

const TIMEOUT_NS: u64 = 2_200_000;

fn options() -> BusOptions {
    BusOptions::default().echo(EchoMode::Known(Echo::Absent)).formats(FormatPolicy::Unchecked)
}

fn bus(script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static) -> Bus<VirtualLine> {
    Bus::new(VirtualLine::new(script), options()).unwrap()
}

/// The board that a request is for.
fn asked(request: &[u8]) -> u8 {
    0xFF - request[1]
}

/// A pressure that tells which request it answers.
fn numbered(number: usize) -> u16 {
    number as u16 % 1024
}

fn prompt(number: usize, request: &[u8]) -> Reply {
    vec![(AT_ONCE, answer(asked(request), numbered(number)))]
}

/// Exchanges with `boards` boards in turn; every accepted answer must belong to its own request.
/// Returns the errors.
fn poll(bus: &mut Bus<VirtualLine>, boards: u8, exchanges: usize) -> Vec<ExchangeError> {
    let mut errors = Vec::new();
    for turn in 0..exchanges {
        let board = (turn % usize::from(boards)) as u8;
        match bus.exchange(board, counts(102)) {
            Ok(answer) => {
                let number = bus.line().requests.len() - 1;
                assert_eq!(
                    answer.pressures,
                    counts(numbered(number)),
                    "another request's answer was accepted"
                );
            }
            Err(error) => errors.push(error),
        }
    }
    errors
}

/// Original: one answer 3.2 ms late, and 3980 of 4000 later exchanges failed.
#[test]
fn one_late_answer_costs_one_exchange() {
    for boards in [1, 2, 4] {
        let mut bus = bus(|number, request| {
            let late = if number == 20 { 3_200_000 } else { 0 };
            vec![(AT_ONCE + late, answer(asked(request), numbered(number)))]
        });
        let errors = poll(&mut bus, boards, 4_000);
        // The late answer may come while another board is asked: then it is heard, and that board's
        // answer still counts.
        assert!(matches!(errors[..], [ExchangeError::NoAnswer { .. }]), "{boards} boards: {errors:?}");
        assert_eq!(bus.counters(20 % boards).late, 1, "the late answer was noticed");
    }
}

/// However late: up to the limit for a board that was never late before.
#[test]
fn no_delay_up_to_the_limit_makes_an_answer_pass_for_another() {
    for delay_us in (2_000..12_000).step_by(130) {
        let mut bus = bus(move |number, request| {
            let late = if number == 3 { delay_us * 1000 } else { 0 };
            vec![(AT_ONCE + late, answer(asked(request), numbered(number)))]
        });
        assert!(poll(&mut bus, 1, 20).len() <= 1, "{delay_us} us");
    }
}

/// A board that is always later than its timeout is never believed, and never mistaken.
#[test]
fn a_board_that_is_always_late_is_lost_but_not_misread() {
    let mut bus = bus(|number, request| vec![(5_000_000, answer(asked(request), numbered(number)))]);
    assert_eq!(poll(&mut bus, 1, 50).len(), 50);
    assert_eq!(bus.counters(0).late, 49, "all but the last one's were heard");
}

/// Original: one stray leading byte lost 100 of 100 answers.
#[test]
fn a_stray_byte_costs_nothing() {
    for stray in [0x00, 0x55, 0xFF] {
        let mut bus = bus(move |number, request| {
            let mut bytes = vec![stray];
            bytes.extend(answer(asked(request), numbered(number)));
            vec![(AT_ONCE, bytes)]
        });
        assert_eq!(poll(&mut bus, 1, 100), [], "stray 0x{stray:02X}");
    }
}

/// A whole valid packet of the very board, between two exchanges: somebody's late answer to a host
/// that has died.
#[test]
fn a_packet_that_nobody_asked_for_is_discarded() {
    let mut bus = bus(prompt);
    assert_eq!(poll(&mut bus, 1, 3), []);
    let now = bus.line().now_ns();
    bus.line_mut().inject(now, &answer(0, 999));
    bus.line_mut().sleep_until(now + 1_000_000);
    assert_eq!(poll(&mut bus, 1, 3), []);
    assert_eq!((bus.unsolicited_bytes(), bus.counters(0).late), (10, 1));
}

/// A byte after the answer is somebody's noise; the next exchange is not disturbed by it.
#[test]
fn a_trailing_byte_costs_nothing() {
    let mut bus = bus(|number, request| {
        let mut bytes = answer(asked(request), numbered(number));
        bytes.push(0xFF);
        vec![(AT_ONCE, bytes)]
    });
    assert_eq!(poll(&mut bus, 2, 100), []);
}

/// Original: a garbled answer that ends in the address blocked the host for 10 s.
#[test]
fn a_garbled_answer_that_ends_in_the_address_costs_its_timeout() {
    let mut bus = bus(|number, request| {
        if number != 5 {
            return prompt(number, request);
        }
        vec![(AT_ONCE, vec![0x12, 0xFF, 0x34, 0xFF, 0x56, 0xFF, 0x78, 0xFF, 0xFF, 0xFF])]
    });
    let before = bus.line().now_ns();
    let errors = poll(&mut bus, 1, 100);
    let took = bus.line().now_ns() - before;
    assert!(matches!(errors[..], [ExchangeError::Garbled { .. }]), "{errors:?}");
    assert!(took < 99 * 200_000 + TIMEOUT_NS + 1_000_000, "{took} ns");
}

/// An answer cut short at any byte, or with any byte flipped into another form.
#[test]
fn a_damaged_answer_costs_one_exchange() {
    for length in 0..10 {
        let mut bus = bus(move |number, request| {
            let mut bytes = answer(asked(request), numbered(number));
            if number == 5 {
                bytes.truncate(length);
            }
            vec![(AT_ONCE, bytes)]
        });
        assert_eq!(poll(&mut bus, 1, 100).len(), 1, "cut after {length} bytes");
    }
}

/// Original: a missing board cost 3 ms a cycle; three of four boards ran at 264 Hz instead of 1667
/// Hz.
#[test]
fn three_of_four_boards_run_nearly_as_fast_as_three() {
    let script = |number: usize, request: &[u8]| {
        if asked(request) == 2 { Vec::new() } else { prompt(number, request) }
    };
    let bus = bus(script);
    let mut polling =
        Polling::new(bus, PollerOptions::for_devices(4), Box::new(SetPoints::new(4)), Vec::new());
    while polling.bus_mut().line().now_ns() < 2_000_000_000 {
        let at = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(at);
        polling.cycle().unwrap();
    }
    let statistics = polling.finish();
    // Ten probes a second of 2.2 ms each leave 97.8 % of the time for three boards: 1630 Hz.
    assert!(statistics.loop_hz.mean > 1_600.0, "{statistics:?}");
    assert_eq!(statistics.boards[2].state, BoardState::Missing);
    assert_eq!(statistics.lost, statistics.boards[2].lost);
}

/// Every cycle is counted once, the first and the last included, and none is made up.
#[test]
fn cycles_of_equal_length_have_no_spread() {
    let mut bus = bus(prompt);
    // Before the first request the line is unknown, and a guard byte goes first.
    bus.ping(0).unwrap();
    let mut polling =
        Polling::new(bus, PollerOptions::for_devices(1), Box::new(SetPoints::new(1)), Vec::new());
    for _ in 0..50 {
        polling.next_cycle_ns();
        polling.cycle().unwrap();
    }
    let statistics = polling.finish();
    assert_eq!((statistics.cycles, statistics.exchanges), (50, 50));
    assert!((statistics.loop_hz.mean - 5_000.0).abs() < 1e-6, "{statistics:?}");
    assert!(statistics.loop_hz.std < 1e-6, "{statistics:?}");
}

/// The worst cycle with a missing board is longer by its timeout and the guard byte that follows a
/// failure, and no more.
#[test]
fn a_missing_board_costs_the_others_its_own_timeout() {
    // Pressures that do not end in 0xFF: a guard byte would be needed after those.
    let mut bus = bus(|_, request| match asked(request) {
        1 => Vec::new(),
        board => vec![(AT_ONCE, answer(board, 500))],
    });
    bus.ping(0).unwrap();
    let mut polling =
        Polling::new(bus, PollerOptions::for_devices(3), Box::new(SetPoints::new(3)), Vec::new());
    for _ in 0..5_000 {
        let at = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(at);
        polling.cycle().unwrap();
    }
    let worst_us = polling.finish().cycle_us.max;
    let guard_us = guard_pause_ns(Baud::ORIGINAL) as f64 * 1e-3;
    assert!(worst_us <= (2.0 * 200.0) + 2_200.0 + guard_us + 1.0, "{worst_us} us");
}

#[test]
fn a_board_that_comes_back_is_polled_in_every_cycle_again() {
    let script = |number: usize, request: &[u8]| {
        if (100..200).contains(&number) { Vec::new() } else { prompt(number, request) }
    };
    let bus = bus(script);
    let mut polling =
        Polling::new(bus, PollerOptions::for_devices(1), Box::new(SetPoints::new(1)), Vec::new());
    let mut states = Vec::new();
    for _ in 0..1_000 {
        let at = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(at);
        polling.cycle().unwrap();
        let state = polling.statistics().boards[0].state;
        if states.last() != Some(&state) {
            states.push(state);
        }
    }
    assert_eq!(states, [BoardState::Present, BoardState::Doubtful, BoardState::Missing, BoardState::Present]);
    assert_eq!(polling.finish().lost, 100);
}

/// A board that never stops: an error after a bounded time, not a hang.
#[test]
fn a_babbling_board_is_reported() {
    let mut bus = bus(|_, _| Vec::new());
    bus.line_mut().inject(0, &[0xA5; 100_000]);
    let error = bus.exchange(0, counts(102)).unwrap_err();
    assert!(matches!(error, ExchangeError::Garbled { .. } | ExchangeError::LineBusy { .. }), "{error}");
    let error = bus.exchange(0, counts(102)).unwrap_err();
    assert!(matches!(error, ExchangeError::LineBusy { .. }), "{error}");
    assert!(bus.line().now_ns() < 100_000_000, "{} ns", bus.line().now_ns());
}

#[test]
fn another_boards_answer_is_named() {
    let mut bus = bus(|_, _| vec![(AT_ONCE, answer(3, 7))]);
    let error = bus.exchange(1, counts(102)).unwrap_err();
    let ExchangeError::OtherBoard { asked, answered, waited } = error else { panic!("{error}") };
    assert_eq!((asked.board(), answered.board(), waited), (1, 3, Duration::from_micros(2_200)));
}

#[test]
fn the_final_state_is_zero_kpa() {
    let mut bus = bus(|number, request| if number == 1 { Vec::new() } else { prompt(number, request) });
    assert_eq!(bus.make_safe([0, 1].into_iter()), Ok(Vec::new()), "one lost packet does not matter");
    let requests = &bus.line().requests;
    assert_eq!(requests.len(), 6);
    assert!(requests.iter().all(|(_, bytes)| bytes[2..] == Counts::ATMOSPHERE.get().to_be_bytes().repeat(4)));
}
