//! What keeps a bus at the rate that its boards were compiled for, and what is said of it. In
//! virtual time; tests/tests/host/line_rate.rs has the rest with the simulator's boards.

use crate::support::counts;
use crate::support::virtual_line::{AT_ONCE, VirtualLine};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, LineRateError};
use pneudrive_protocol::pages::{Entry, LineRate, LineRateAnswer, LineRateState, PageEntry, SessionOffer};
use pneudrive_protocol::{Address, Asked, Echo, RequestDecoder};
use std::sync::{Arc, Mutex};

const OLD: &str = "board 0 (0xFFFF): its firmware is of before line rates; flash a newer one";

/// What a board says to requests for a rate; it gives sessions.
#[derive(Clone, Copy)]
struct Firmware {
    /// Whether it answers page requests at all.
    pages: bool,
    /// Page 9, entry 0.
    state: Option<Entry>,
    /// Page 9, another entry.
    answer: Option<Entry>,
}

const NEWEST: Firmware = Firmware { pages: true, state: None, answer: None };

/// Rates that boards were asked for.
type AskedFor = Arc<Mutex<Vec<LineRate>>>;

fn host(firmware: Firmware) -> (Bus<VirtualLine>, AskedFor) {
    let asked_for = AskedFor::default();
    let noted = Arc::clone(&asked_for);
    let mut ear = RequestDecoder::new(Address::of_board(0));
    let line = VirtualLine::new(move |_, request: &[u8]| {
        let heard = request.iter().filter_map(|&byte| ear.push(byte)).last();
        ear.line_idle();
        let bytes = match heard {
            Some(Asked::Pressures(request)) => request.answer(ear.address(), counts(7)).to_vec(),
            Some(Asked::Page(request)) if firmware.pages => {
                let entry = request.entry().and_then(|entry| match entry {
                    PageEntry::Session(_) => ear.offer(77).then(|| SessionOffer::Number(77).to_entry()),
                    PageEntry::LineRate => firmware.state,
                    PageEntry::SetLineRate(rate) => {
                        noted.lock().unwrap().push(rate);
                        firmware.answer
                    }
                    _ => None,
                });
                request.answer(entry).encode().to_vec()
            }
            _ => Vec::new(),
        };
        vec![(AT_ONCE, bytes)]
    });
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent));
    let mut bus = Bus::new(line, options).unwrap();
    bus.ping(0).unwrap();
    // A session begins with its first command.
    bus.exchange(0, counts(300)).unwrap();
    (bus, asked_for)
}

fn state(fastest: LineRate) -> Option<Entry> {
    let state = LineRateState { now: LineRate::Compiled, fastest, returns: 0, last_return: None };
    Some(state.to_entry())
}

#[test]
fn firmware_of_before_line_rates_is_said_to_be() {
    let nonsense = Some([4, 4, 4, 4].map(|word| counts(word)[0]));
    for firmware in [
        // Of before pages, of before line rates, and one whose page 9 is another thing.
        Firmware { pages: false, ..NEWEST },
        NEWEST,
        Firmware { state: nonsense, ..NEWEST },
    ] {
        let (mut bus, asked_for) = host(firmware);
        let error = bus.fastest_line_rate(&[0]).unwrap_err();
        assert!(matches!(error, LineRateError::OldFirmware { .. }), "{error:?}");
        assert_eq!(error.to_string(), OLD);
        assert_eq!(*asked_for.lock().unwrap(), []);
        assert!(bus.exchange(0, counts(300)).is_ok(), "it goes on");
    }
}

/// Whoever raises the rate without asking how fast it may be is told the same.
#[test]
fn a_board_that_does_not_know_the_request_for_a_rate_keeps_it() {
    for answer in [None, Some([9, 0, 0, 0].map(|word| counts(word)[0]))] {
        let (mut bus, asked_for) = host(Firmware { state: state(LineRate::ThreeMbaud), answer, ..NEWEST });
        bus.line_mut().adapter_does_all = true;
        let error = bus.raise_line_rate(&[0], LineRate::ThreeMbaud).unwrap_err();
        assert_eq!(error.to_string(), OLD);
        assert_eq!(*asked_for.lock().unwrap(), [LineRate::ThreeMbaud]);
        assert_eq!(bus.line_rate(), LineRate::Compiled);
        assert!(bus.exchange(0, counts(300)).is_ok());
    }
}

#[test]
fn a_board_that_finds_the_rate_too_fast_keeps_it() {
    let answer = Some(LineRateAnswer::TooFast.to_entry());
    let (mut bus, _) = host(Firmware { state: state(LineRate::ThreeMbaud), answer, ..NEWEST });
    bus.line_mut().adapter_does_all = true;
    let error = bus.raise_line_rate(&[0], LineRate::ThreeMbaud).unwrap_err();
    assert!(matches!(error, LineRateError::NotAllowed { .. }), "{error:?}");
    assert_eq!(bus.line_rate(), LineRate::Compiled);
}

/// The adapter is asked first: no board goes to a rate at which nobody speaks.
#[test]
fn an_adapter_that_does_not_do_the_rate_costs_the_boards_nothing() {
    let answer = Some(LineRateAnswer::Taken.to_entry());
    let (mut bus, asked_for) = host(Firmware { state: state(LineRate::ThreeMbaud), answer, ..NEWEST });
    assert_eq!(bus.fastest_line_rate(&[0]), Ok(LineRate::ThreeMbaud));
    let requests = bus.line().requests.len();
    let error = bus.raise_line_rate(&[0], LineRate::ThreeMbaud).unwrap_err();
    assert_eq!(error.to_string(), "the adapter does not do 3000000 baud");
    assert_eq!((bus.line().requests.len(), bus.baud().get()), (requests, 1_000_000));
    assert_eq!(*asked_for.lock().unwrap(), []);
    assert!(bus.exchange(0, counts(300)).is_ok());
}
