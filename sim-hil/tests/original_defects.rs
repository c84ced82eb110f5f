//! What the original boards got wrong on the bus, and ours do not. In virtual time, on a strict
//! bus.

use crate::common::{Host, MS, US, counts, drain, packet, rig};
use pneudrive_protocol::{Address, Packet};

/// The original's boards took a data word that ends in 0xFF, followed by board n's 0xFF.., for
/// board 0's address: with two boards and a set point of 511 = 0x01FF, failures rose from 17 to 479
/// of 4088 exchanges.
#[test]
fn a_set_point_of_511_calls_nobody_by_a_false_name() {
    let mut bus = rig(2, &[]);
    let host = Host::default();
    for n in 0..4_088_u32 {
        let board = (n % 2) as u8;
        let answer = host.exchange(&mut bus, packet(board, 511));
        assert_eq!(answer.map(|answer| answer.address), Some(Address::of_board(board)), "exchange {n}");
    }
    assert_eq!((bus.counters().answers, bus.counters().violations()), (4_088, 0));
}

/// Every value word that ends in 0xFF, before every board's address, without any silence between
/// the packets.
#[test]
fn no_data_word_before_any_address_calls_another_board() {
    let mut bus = rig(4, &[]);
    let host = Host::default();
    for value in [0x00FF, 0x01FF, 0x02FF, 0x03FF] {
        for first in 0..4 {
            for second in 0..4 {
                assert!(host.exchange(&mut bus, packet(first, value)).is_some());
                assert!(host.exchange(&mut bus, packet(second, value)).is_some());
            }
        }
    }
    assert_eq!(bus.counters().violations(), 0);
}

/// After one answer that came 3.2 ms late the original lost 3980 of 4000 exchanges. On the bus
/// itself nothing may be left of it: the boards go on answering each request once.
#[test]
fn one_late_answer_leaves_the_boards_in_step() {
    let mut bus = rig(1, &["delay@0.005,on=answers,ms=3.2"]);
    let host = Host::default();
    let mut failed = 0;
    for n in 0..4_000 {
        drain(&mut bus); // As a host must: what comes before a request cannot be its answer.
        failed += u32::from(host.exchange(&mut bus, packet(0, 102 + n % 800)).is_none());
        bus.run_until(bus.now_ns() + 50 * US);
    }
    assert_eq!(bus.counters().fault("delay"), 1);
    // A timeout of 1 ms, four times during the 3.2 ms.
    assert!((1..=5).contains(&failed), "{failed} of 4000");
    assert_eq!((bus.counters().answers, bus.counters().violations()), (4_000, 0));
}

/// One stray leading byte lost the original 100 of 100 answers.
#[test]
fn a_stray_byte_before_a_request_costs_one_exchange_at_most() {
    for stray in [0x00, 0x03, 0x55, 0xFE, 0xFF] {
        let mut bus = rig(2, &[]);
        let host = Host::default();
        bus.send(bus.now_ns(), &[stray]);
        bus.run_until(bus.now_ns() + MS);
        for n in 0..100 {
            let answer = host.exchange(&mut bus, packet(n % 2, 300));
            assert!(answer.is_some(), "exchange {n} after 0x{stray:02X}");
        }
        // Without the silence between: glued to the request.
        let mut glued = vec![stray];
        glued.extend(packet(0, 300).encode());
        host.exchange_bytes(&mut bus, &glued);
        drain(&mut bus);
        assert!(host.exchange(&mut bus, packet(1, 300)).is_some(), "after a glued 0x{stray:02X}");
        assert_eq!(bus.counters().violations(), 0);
    }
}

/// A request that lost a byte must not make the board take the next one apart.
#[test]
fn a_request_that_lost_any_byte_costs_that_exchange_only() {
    for lost in 0..10 {
        let mut bus = rig(2, &[]);
        let host = Host::default();
        let mut short = packet(0, 511).encode().to_vec();
        short.remove(lost);
        assert!(host.exchange_bytes(&mut bus, &short).is_empty());
        assert!(host.exchange(&mut bus, packet(0, 511)).is_some(), "without byte {lost}");
        assert!(host.exchange(&mut bus, packet(1, 511)).is_some(), "without byte {lost}");
        assert_eq!(bus.counters().violations(), 0);
    }
}

/// The original regulated the last set point for ever. Ours hold it for 2 s after half a second of
/// silence, then vent.
#[test]
fn a_host_that_falls_silent_lets_the_chambers_vent() {
    let mut bus = rig(1, &[]);
    let host = Host::default();
    let set = counts(459); // 300 kPa
    let ask = Packet { address: Address::of_board(0), values: [set; 4] };
    let mut last = None;
    while bus.now_ns() < 4_000 * MS {
        last = host.exchange(&mut bus, ask);
        bus.run_until(bus.now_ns() + 10 * MS);
    }
    let reached = last.unwrap().values;
    assert!(reached.iter().all(|p| p.get().abs_diff(459) <= 5), "{reached:?}");

    bus.run_until(bus.now_ns() + 2_000 * MS); // still held
    let held = host.exchange(&mut bus, ask).unwrap().values;
    assert!(held.iter().all(|p| p.get().abs_diff(459) <= 5), "{held:?}");

    bus.run_until(bus.now_ns() + 10_000 * MS);
    let vented = host.exchange(&mut bus, ask).unwrap().values;
    assert!(vented.iter().all(|p| p.get() <= 110), "{vented:?}");
}
