//! Adapters that return what the host sends, in virtual time.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{Bus, BusOptions, ExchangeError, FormatPolicy, OpenBusError};
use pneudrive_protocol::Echo;
use std::time::Duration;

/// An echo and, from board 0, an answer of the very same bytes: what content cannot tell apart.
fn echoing(request: &[u8]) -> Reply {
    let mut reply = vec![(0, request.to_vec())];
    if request[1] == 0xFF {
        reply.push((AT_ONCE, request.to_vec()));
    }
    reply
}

fn open(
    script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static,
) -> Result<Bus<VirtualLine>, OpenBusError> {
    Bus::new(VirtualLine::new(script), BusOptions::default().formats(FormatPolicy::Unchecked))
}

#[test]
fn an_echo_is_found_at_the_start_and_skipped() {
    let mut bus = open(|_, request| echoing(request)).unwrap();
    assert_eq!(bus.echo(), Echo::Present);
    assert_eq!(bus.exchange(0, counts(510)).unwrap().pressures, counts(510));
    // A missing board is not answered by the echo.
    let error = bus.exchange(1, counts(510)).unwrap_err();
    assert!(matches!(error, ExchangeError::NoAnswer { .. }), "{error}");
}

#[test]
fn no_echo_is_found_too() {
    let mut bus =
        open(|_, request| if request[1] == 0xFF { vec![(AT_ONCE, answer(0, 7))] } else { Vec::new() })
            .unwrap();
    assert_eq!(bus.echo(), Echo::Absent);
    assert_eq!(bus.exchange(0, counts(511)).unwrap().pressures, counts(7));
}

#[test]
fn noise_on_one_try_does_not_matter_and_on_all_is_an_error() {
    let noisy_once =
        open(|number, request| if number == 0 { vec![(0, vec![0x5A])] } else { echoing(request) });
    assert_eq!(noisy_once.unwrap().echo(), Echo::Present);
    let OpenBusError::Echo(error) = open(|_, _| vec![(0, vec![0x5A; 3])]).unwrap_err() else { panic!() };
    assert_eq!(error.heard.first(), [0x5A; 3]);
}

/// The board may have heard something else than was sent: its answer is not believed.
#[test]
fn a_damaged_echo_is_an_error_and_the_next_exchange_is_right() {
    let mut bus = open(|number, request| {
        let mut reply = echoing(request);
        if number == 1 {
            reply[0].1[4] ^= 0x01;
        }
        reply
    })
    .unwrap();
    let error = bus.exchange(0, counts(511)).unwrap_err();
    let ExchangeError::EchoDamaged { heard, .. } = error else { panic!("{error}") };
    assert_eq!(heard.count(), 20);
    assert_eq!(bus.exchange(0, counts(300)).unwrap().pressures, counts(300));
}

#[test]
fn an_echo_that_stops_is_named() {
    let mut bus =
        open(|number, request| if number == 0 { echoing(request) } else { vec![(0, request[..4].to_vec())] })
            .unwrap();
    let error = bus.exchange(0, counts(511)).unwrap_err();
    assert!(matches!(error, ExchangeError::EchoMissing { missing: 6, .. }), "{error}");
}

/// Guard bytes come back, too: at once, or so late that they come with the request's echo.
#[test]
fn the_echo_of_a_guard_byte_is_no_part_of_the_requests_echo() {
    for late_ns in [0, 5_000_000] {
        let mut line = VirtualLine::new(move |_, request| {
            let mut reply = vec![(late_ns, request.to_vec())];
            if request[1] != 0 {
                // An answer that ends in 0xFF, so that a guard goes before the next request.
                reply.push((late_ns + AT_ONCE, answer(0xFF - request[1], 511)));
            }
            reply
        });
        line.guards_echo_after_ns = Some(late_ns);
        let options = BusOptions::default()
            .formats(FormatPolicy::Unchecked)
            .answer_allowance(Duration::from_millis(10));
        let mut bus = Bus::new(line, options).unwrap();
        assert_eq!(bus.echo(), Echo::Present);
        for turn in 0..10 {
            let answer = bus.exchange(turn % 2, counts(300));
            assert_eq!(answer.unwrap().pressures, counts(511), "exchange {turn}, late by {late_ns} ns");
        }
        assert_eq!(bus.line().guards.len(), 11, "the one before the search for an echo included");
        assert_eq!(bus.unsolicited_bytes(), 0);
    }
}
