//! The port itself: opening it, and exchanges over a real pty.

use crate::support::pty::PtyBoards;
use crate::support::virtual_line::{AT_ONCE, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy, OpenBusError};
use pneudrive_host::line::{Line, OpenError, SerialOptions, SerialPort};
use pneudrive_host::poller::{
    BoardState, Outcome, Poller, PollerOptions, PollerPanicked, SetPoints, StartError,
};
use pneudrive_host::real_time::{RealTime, RealTimeError};
use pneudrive_protocol::{Counts, Echo};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Waits for something that another thread does. The limit is for a hanging test, not for a slow
/// machine.
fn until(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < Duration::from_secs(30), "waiting for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn commands_and_pressures_cross_a_pty() {
    let boards = PtyBoards::start(2);
    // The machine that runs the tests may be busy with others.
    let patient = BusOptions::default().answer_allowance(Duration::from_secs(1));
    let mut bus = Bus::open(boards.path(), patient).unwrap();
    for value in [1, 102, 0xFF, 511, 1023] {
        for board in [0, 1] {
            assert_eq!(bus.exchange(board, counts(value)).unwrap().pressures, counts(value));
        }
    }
    assert_eq!(bus.counters(1).answered, 5);
}

/// Bytes that are there are not reported missing for lack of a look, however late the host comes.
#[test]
fn a_deadline_in_the_past_still_looks() {
    let boards = PtyBoards::start(1);
    let mut port = SerialPort::open(boards.path(), SerialOptions::default()).unwrap();
    let mut bytes = [0; 64];
    assert_eq!(port.receive(&mut bytes, 0, 0), Ok(0));
    port.send(&answer(0, 300)).unwrap();
    let mut have = 0;
    until("the answer", || {
        have += port.receive(&mut bytes[have..], 10, 0).unwrap();
        have == 10
    });
    assert_eq!(bytes[..10], answer(0, 300));
}

#[test]
fn a_second_host_is_refused() {
    let boards = PtyBoards::start(1);
    let first = Bus::open(boards.path(), BusOptions::default()).unwrap();
    let second = Bus::open(boards.path(), BusOptions::default()).unwrap_err();
    let OpenBusError::Port(OpenError::InUse { port }) = second else { panic!("{second}") };
    assert_eq!(port, boards.path());
    drop(first);
    Bus::open(boards.path(), BusOptions::default()).unwrap();
}

#[test]
fn what_is_no_port_is_named() {
    let open = |path: &str| SerialPort::open(path.as_ref(), SerialOptions::default()).unwrap_err();
    assert!(matches!(open("/dev/no-such-port"), OpenError::NotFound { .. }));
    assert!(matches!(open("/dev/null"), OpenError::NotATerminal { .. }));
    assert!(matches!(open("/"), OpenError::System { .. } | OpenError::NotATerminal { .. }));
}

#[test]
fn the_poller_loses_a_board_and_finds_it_again() {
    let boards = PtyBoards::start(2);
    let bus = Bus::open(boards.path(), BusOptions::default()).unwrap();
    let points = SetPoints::new(2);
    points.set(0, counts(300)).unwrap();
    let poller =
        Poller::start(bus, PollerOptions::for_devices(2), Box::new(points.clone()), Vec::new()).unwrap();
    let state = |board: usize| poller.latest().boards.get(board).map(|row| row.state);
    until("both boards", || (0..2).all(|board| state(board) == Some(BoardState::Present)));

    boards.last_unplugged.store(true, Ordering::Relaxed);
    until("the loss", || state(1) == Some(BoardState::Missing));
    let snapshot = poller.latest();
    assert_eq!(snapshot.boards[1].fresh(), None);
    assert_ne!(snapshot.boards[1].outcome, Outcome::Fresh);

    boards.last_unplugged.store(false, Ordering::Relaxed);
    until("the return", || state(1) == Some(BoardState::Present));
    until("figures", || poller.statistics().is_some());
    let finished = poller.stop().unwrap();
    assert_eq!((finished.error, finished.not_safe), (None, Vec::new()));
    assert!(finished.statistics.boards[1].lost >= 3);

    let commands = boards.stop();
    assert!(commands.contains(&(0, counts(300))));
    // The last thing that each board hears is 0 kPa.
    for board in [0, 1] {
        let last = commands.iter().rfind(|(of, _)| *of == board);
        assert_eq!(last, Some(&(board, [Counts::ATMOSPHERE; 4])));
    }
}

#[test]
fn a_poller_that_cannot_have_what_it_asks_for_does_not_start() {
    let boards = PtyBoards::start(1);
    let bus = Bus::open(boards.path(), BusOptions::default()).unwrap();
    let real_time = RealTime::default().core(100_000);
    let options = PollerOptions::for_devices(1).real_time(real_time);
    let points = SetPoints::new(1);
    points.set(0, counts(300)).unwrap();
    let error = Poller::start(bus, options, Box::new(points), Vec::new()).unwrap_err();
    assert!(
        matches!(error, StartError::RealTime(RealTimeError::NoSuchCore { core: 100_000, .. })),
        "{error}"
    );
    let said = error.to_string();
    assert!(said.starts_with("core 100000: this process may use the cores"), "{said}");
    assert!(boards.stop().iter().all(|(_, command)| *command == [Counts::ATMOSPHERE; 4]));
}

#[test]
fn a_panic_on_the_bus_thread_is_an_error_and_leaves_boards_at_0_kpa() {
    let boards = PtyBoards::start(1);
    let bus = Bus::open(boards.path(), BusOptions::default()).unwrap();
    let points = SetPoints::new(1);
    points.set(0, counts(300)).unwrap();
    let mut rows = 0;
    let poller = Poller::builder(bus).boards([0]).set_points(points).observe(move |_| {
        rows += 1;
        assert!(rows < 10, "an observer's fault, on purpose");
    });
    let poller = poller.start().unwrap();
    until("the panic", || poller.is_finished());
    assert_eq!(poller.stop(), Err(PollerPanicked));
    let commands = boards.stop();
    assert!(commands.contains(&(0, counts(300))));
    assert_eq!(commands.last(), Some(&(0, [Counts::ATMOSPHERE; 4])));
}

/// A control loop asks for readings that are not older than it can use, whatever the row says of
/// its cycle.
#[test]
fn a_snapshot_gives_no_reading_that_is_too_old() {
    let boards = PtyBoards::start(1);
    let bus = Bus::open(boards.path(), BusOptions::default()).unwrap();
    let clock = bus.line().clock();
    let poller =
        Poller::start(bus, PollerOptions::for_devices(1), Box::new(SetPoints::new(1)), Vec::new()).unwrap();
    until("the board", || poller.latest().boards.first().is_some_and(|row| row.fresh().is_some()));
    let snapshot = poller.latest();
    let asked_ns = snapshot.boards[0].reading.unwrap().asked_ns;
    let oldest = Duration::from_micros(1);
    assert!(snapshot.reading(0, asked_ns + 1_000, oldest).is_some());
    assert!(snapshot.reading(0, asked_ns + 1_001, oldest).is_none());
    assert_eq!(snapshot.reading(1, asked_ns, Duration::MAX), None);
    assert!(snapshot.age(clock.now_ns()).is_some_and(|age| !age.is_zero()));
}

/// With fewer boards than are polled, what comes late or damaged from others falls into the time of
/// one that does not exist.
#[test]
fn bytes_that_are_refused_do_not_make_a_board_one_that_is_there() {
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent)).formats(FormatPolicy::Unchecked);
    let finished = |points: SetPoints| {
        let line = VirtualLine::new(|_, request| match 0xFF - request[1] {
            0 => vec![(AT_ONCE, answer(0, 102))],
            _ => vec![(AT_ONCE, vec![0x11, 0x22, 0x33, 0x44, 0x55])],
        });
        let bus = Bus::new(line, options).unwrap();
        let poller = Poller::start(bus, PollerOptions::for_devices(2), Box::new(points), Vec::new()).unwrap();
        until("figures", || poller.statistics().is_some_and(|figures| figures.boards[1].rejected > 3));
        poller.stop().unwrap()
    };
    let vented = finished(SetPoints::new(2));
    assert_eq!((&vented.not_safe[..], &vented.never_heard[..]), (&[1][..], &[1][..]));
    let said = vented.conclusion();
    let remark = "board(s) 1 never answered; are there fewer boards than --devices says?";
    assert_eq!((said.failures.len(), said.remark.as_deref()), (0, Some(remark)));
    // It may be there and hear: what was sent to it counts.
    let points = SetPoints::new(2);
    points.set(1, counts(300)).unwrap();
    let said = finished(points).conclusion();
    assert!(said.failures[0].contains("set points were sent to board(s) 1 all the same"), "{said:?}");
}

#[test]
fn a_closed_pty_ends_the_poller_with_its_reason() {
    let boards = PtyBoards::start(1);
    let bus = Bus::open(boards.path(), BusOptions::default()).unwrap();
    let poller =
        Poller::start(bus, PollerOptions::for_devices(1), Box::new(SetPoints::new(1)), Vec::new()).unwrap();
    until("the board", || poller.latest().boards.first().is_some_and(|row| row.fresh().is_some()));
    drop(boards);
    until("the end", || poller.is_finished());
    let finished = poller.stop().unwrap();
    assert!(finished.error.is_some_and(|error| error.to_string().contains("gone")));
    assert_eq!(finished.not_safe, [0]);
}
