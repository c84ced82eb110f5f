//! Checked packets: negotiation, and what they catch that unchecked ones cannot. In virtual time.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{BoardFormat, Bus, BusOptions, EchoMode, ExchangeError};
use pneudrive_host::line::Line;
use pneudrive_protocol::{Address, CheckedPacket, Counts, Direction, Echo, RequestDecoder};
use std::time::Duration;

fn bus(script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static) -> Bus<VirtualLine> {
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent)).sessions(false);
    Bus::new(VirtualLine::new(script), options).unwrap()
}

/// A board that understands checked packets and answers `pressure(number of the request)`.
fn board(mut pressure: impl FnMut(usize) -> u16) -> impl FnMut(usize, &[u8]) -> Vec<u8> {
    let address = Address::of_board(0);
    let mut ear = RequestDecoder::new(address);
    move |number, request| {
        let heard = request.iter().filter_map(|&byte| ear.push(byte)?.pressures()).last();
        heard.map_or_else(Vec::new, |heard| heard.answer(address, counts(pressure(number))).to_vec())
    }
}

/// A board of the original kind: it answers whatever is asked, and only then drops commands
/// above 1023.
fn original(request: &[u8]) -> Vec<u8> {
    answer(0xFF - request[1], 7)
}

#[test]
fn boards_that_check_and_original_ones_are_told_apart_by_a_ping() {
    let mut checks = board(|_| 7);
    let mut modern = bus(move |number, request| vec![(AT_ONCE, checks(number, request))]);
    assert_eq!(modern.format(0), BoardFormat::Unknown);
    assert_eq!(modern.ping(0).unwrap().pressures, counts(7));
    assert_eq!((modern.format(0), modern.counters(0).lost()), (BoardFormat::Checked, 0));

    let mut old = bus(|_, request| vec![(AT_ONCE, original(request))]);
    assert_eq!(old.ping(0).unwrap().pressures, counts(7));
    assert_eq!(
        (old.format(0), old.counters(0).lost()),
        (BoardFormat::Unchecked, 1),
        "its first answer tells"
    );
    assert!((0..100).all(|_| old.exchange(0, counts(300)).is_ok()));
}

/// An answer of a board that checks, damaged so that it looks like the original's: the board is
/// found again as what it is, and nothing that it did not say is believed.
#[test]
fn a_damaged_answer_makes_no_board_an_original_one_for_long() {
    let mut checks = board(|_| 7);
    let mut bus = bus(move |number, request| {
        let mut bytes = checks(number, request);
        if number == 0 {
            bytes = answer(0, 900);
        }
        vec![(AT_ONCE, bytes)]
    });
    let believed: Vec<_> = (0..10).filter_map(|_| bus.ping(0).ok()).collect();
    assert!(
        believed.len() > 5 && believed.iter().all(|answer| answer.pressures == counts(7)),
        "{believed:?}"
    );
    assert_eq!(bus.format(0), BoardFormat::Checked);
}

/// One ping lost to noise does not make a board count as original.
#[test]
fn one_lost_packet_does_not_decide_the_format() {
    let mut checks = board(|_| 7);
    let mut bus = bus(move |number, request| {
        let answer = checks(number, request);
        if number == 0 { Vec::new() } else { vec![(AT_ONCE, answer)] }
    });
    bus.ping(0).unwrap();
    assert_eq!(bus.format(0), BoardFormat::Checked);
}

/// Original: 40 of 80 single-bit flips in an answer were accepted.
#[test]
fn no_flipped_bit_of_an_answer_is_accepted() {
    for bit in 0..80 {
        let mut checks = board(|_| 511);
        let mut bus = bus(move |number, request| {
            let mut answer = checks(number, request);
            if number == 1 {
                answer[bit / 8] ^= 0x80 >> (bit % 8);
            }
            vec![(AT_ONCE, answer)]
        });
        bus.ping(0).unwrap();
        let error = bus.exchange(0, counts(300)).unwrap_err();
        assert!(
            matches!(error, ExchangeError::Garbled { .. } | ExchangeError::OtherBoard { .. }),
            "bit {bit}: {error}"
        );
        assert_eq!(bus.exchange(0, counts(300)).unwrap().pressures, counts(511), "bit {bit}");
    }
}

/// Without a pause for the board: the number tells. It repeats after 16 requests, so the board
/// would have to answer 16 later ones first, which neither boards nor adapters do: they keep the
/// order. Here only up to 15 are in between.
#[test]
fn a_late_answer_is_known_by_its_number() {
    for late_us in (2_100..4_900).step_by(37) {
        let mut checks = board(|number| number as u16);
        let mut bus = bus(move |number, request| {
            let late_ns = if number == 5 { late_us * 1000 } else { 0 };
            vec![(AT_ONCE + late_ns, checks(number, request))]
        });
        bus.ping(0).unwrap();
        let mut lost = 0;
        for _ in 0..200 {
            match bus.exchange(0, counts(300)) {
                Ok(answer) => {
                    let number = bus.line().requests.len() as u16 - 1;
                    assert_eq!(answer.pressures, counts(number), "late by {late_us} us");
                }
                Err(_) => lost += 1,
            }
        }
        // It can collide with the answer to a later request.
        assert!(lost <= 2, "{lost} lost when one is {late_us} us late");
        assert!(lost == 2 || bus.counters(0).late == 1, "{late_us} us");
    }
}

/// An answer to an earlier request, and nothing else.
#[test]
fn a_repeated_answer_is_refused() {
    let mut first = Vec::new();
    let mut checks = board(|_| 7);
    let mut bus = bus(move |number, request| {
        let answer = checks(number, request);
        if number == 0 {
            first = answer;
        }
        vec![(AT_ONCE, first.clone())]
    });
    bus.ping(0).unwrap();
    let error = bus.exchange(0, counts(300)).unwrap_err();
    assert!(matches!(error, ExchangeError::Stale { .. }), "{error}");
    assert_eq!(error.waited(), Duration::from_micros(2_200));
}

/// What the adapter echoes is no answer, even if nobody knew that it echoes.
#[test]
fn an_unexpected_echo_is_no_answer() {
    let mut bus = bus(|_, request| vec![(0, request.to_vec())]);
    let error = bus.exchange(0, [Counts::ATMOSPHERE; 4]).unwrap_err();
    assert!(!matches!(error, ExchangeError::Line(_)), "{error}");
    assert_eq!(bus.format(0), BoardFormat::Unknown);
}

/// Unchecked answers of a board that checks are not believed: they can only be damaged.
#[test]
fn formats_are_never_mixed() {
    let mut checks = board(|_| 7);
    let mut bus = bus(move |number, request| {
        if number == 0 {
            return vec![(AT_ONCE, checks(number, request))];
        }
        let checked = CheckedPacket::decode(request.try_into().unwrap(), Direction::Request).unwrap();
        vec![(AT_ONCE, checked.packet.encode().to_vec())]
    });
    bus.ping(0).unwrap();
    for _ in 0..20 {
        assert!(bus.exchange(0, counts(300)).is_err());
    }
    assert!(bus.line().now_ns() < 100_000_000);
}
