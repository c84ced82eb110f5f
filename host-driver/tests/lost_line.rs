//! The line goes and comes back, and the host stands still, in virtual time: what the rows say
//! meanwhile.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, ExchangeError, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{
    BoardState, Event, Observer, PollerOptions, Polling, PressureFilter, Row, SetPoints, VENTED,
};
use pneudrive_protocol::{Echo, Packet, SensorScale};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const SECOND: u64 = 1_000_000_000;

/// Boards that answer at once, with pressure 300.
fn boards(_: usize, request: &[u8]) -> Reply {
    let packet = Packet::decode(request.try_into().unwrap()).unwrap();
    match packet.address.board() {
        board @ 0..=3 => vec![(AT_ONCE, answer(board, 300))],
        _ => Vec::new(),
    }
}

fn options() -> BusOptions {
    BusOptions::default().formats(FormatPolicy::Unchecked).echo(EchoMode::Known(Echo::Absent))
}

/// What observers were told, in words.
#[derive(Clone, Default)]
struct Told {
    lines: Arc<Mutex<Vec<String>>>,
    /// Fresh pressures of board 0, channel 0, kPa.
    pressures: Arc<Mutex<Vec<f64>>>,
}

impl Observer for Told {
    fn row(&mut self, row: &Row<'_>) {
        self.pressures.lock().unwrap().extend(row.boards[0].fresh().map(|reading| reading.kpa[0]));
        let fresh = row.boards.iter().filter(|board| board.fresh().is_some()).count();
        self.lines.lock().unwrap().push(format!("{fresh} fresh"));
    }

    fn event(&mut self, event: &Event<'_>) {
        let text = match event {
            Event::Board { board, state, host_late: Some(late), .. } => {
                format!("board {board} {state:?}, host late by {} ms", late.as_millis())
            }
            Event::Board { board, state, .. } => format!("board {board} {state:?}"),
            Event::LineLost { error, .. } => format!("lost: {error}"),
            Event::LineNotBack { error } => format!("not back: {error}"),
            Event::LineBack { gone } => format!("back after {} ms", gone.as_millis()),
            Event::Stalled { by } => format!("stalled for {} ms", by.as_millis()),
            other => format!("{other:?}"),
        };
        self.lines.lock().unwrap().push(text);
    }
}

impl Told {
    fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.lines.lock().unwrap())
    }

    /// Everything but rows.
    fn events(&self) -> Vec<String> {
        self.take().into_iter().filter(|line| !line.ends_with("fresh")).collect()
    }
}

fn polling(line: VirtualLine, devices: u16) -> (Polling<VirtualLine>, Told) {
    let told = Told::default();
    let filter = Some(PressureFilter::ORIGINAL);
    let options_of_poller = PollerOptions::for_devices(devices).filter(filter);
    let bus = Bus::new(line, options()).unwrap();
    let points = SetPoints::new(usize::from(devices));
    let polling = Polling::new(bus, options_of_poller, Box::new(points), vec![Box::new(told.clone())]);
    (polling, told)
}

/// Cycles until the line's clock shows `until_ns`.
fn run(polling: &mut Polling<VirtualLine>, until_ns: u64) {
    loop {
        let due_ns = polling.next_cycle_ns();
        if due_ns >= until_ns {
            return polling.bus_mut().line_mut().sleep_until(until_ns);
        }
        polling.bus_mut().line_mut().sleep_until(due_ns);
        polling.cycle().unwrap();
    }
}

#[test]
fn a_line_that_is_lost_is_waited_for_and_nothing_is_fresh_meanwhile() {
    let (mut polling, told) = polling(VirtualLine::new(boards), 2);
    run(&mut polling, SECOND);
    assert_eq!(told.events(), ["board 0 Present", "board 1 Present"]);

    polling.bus_mut().line_mut().gone = true;
    run(&mut polling, 2 * SECOND);
    let meanwhile = told.take();
    let lost = "lost: virtual: the port is gone (adapter unplugged, or the other end closed)";
    assert_eq!(meanwhile[0], lost);
    let not_back: Vec<_> = meanwhile.iter().filter(|line| line.starts_with("not back")).collect();
    assert_eq!(not_back.len(), 1, "the same reason is told once: {meanwhile:?}");
    let rows = meanwhile.iter().filter(|line| *line == "0 fresh").count();
    assert_eq!(rows, 4, "one when it was lost, one for each try, and no fresh one: {meanwhile:?}");
    let statistics = polling.statistics();
    assert!(statistics.boards.iter().all(|board| board.state == BoardState::Missing), "{statistics:?}");
    assert_eq!(statistics.boards[0].age_us.map(|us| us / 100_000), Some(10), "a second old");

    polling.bus_mut().line_mut().back = true;
    run(&mut polling, 3 * SECOND);
    let after = told.take();
    assert!(after[0].starts_with("back after 1") && after[0].ends_with(" ms"), "{after:?}");
    assert_eq!(after[1..5], ["Vented", "board 0 Present", "board 1 Present", "2 fresh"]);
    let statistics = polling.finish();
    assert!(statistics.boards.iter().all(|board| board.state == BoardState::Present), "{statistics:?}");
    assert!(statistics.boards[0].answered > 4_000, "what was counted before counts still: {statistics:?}");
    assert_eq!(statistics.boards[0].lost, 1, "the exchange in which it was lost");
}

/// A line that is back brings boards that are not: they are given up, and that is said.
#[test]
fn boards_that_stay_away_are_reported_although_the_line_is_back() {
    let present = Arc::new(Mutex::new(true));
    let theirs = Arc::clone(&present);
    let script =
        move |n: usize, request: &[u8]| if *theirs.lock().unwrap() { boards(n, request) } else { Vec::new() };
    let (mut polling, told) = polling(VirtualLine::new(script), 1);
    run(&mut polling, SECOND / 10);
    polling.bus_mut().line_mut().gone = true;
    run(&mut polling, SECOND);
    *present.lock().unwrap() = false;
    polling.bus_mut().line_mut().back = true;
    told.take();
    run(&mut polling, 2 * SECOND);
    let events = told.events();
    assert!(events[0].starts_with("back after"), "{events:?}");
    assert_eq!(events[1..], ["Vented", "board 0 Missing"]);
}

/// The low-pass starts anew: what was measured before the gap is no history.
#[test]
fn the_filter_does_not_reach_across_the_gap() {
    let pressure = Arc::new(Mutex::new(300));
    let theirs = Arc::clone(&pressure);
    let script = move |_: usize, _: &[u8]| -> Reply { vec![(AT_ONCE, answer(0, *theirs.lock().unwrap()))] };
    let (mut polling, told) = polling(VirtualLine::new(script), 1);
    run(&mut polling, SECOND / 10);
    polling.bus_mut().line_mut().gone = true;
    run(&mut polling, SECOND / 2);
    *pressure.lock().unwrap() = 700;
    polling.bus_mut().line_mut().back = true;
    told.pressures.lock().unwrap().clear();
    run(&mut polling, SECOND);
    let first = told.pressures.lock().unwrap()[0];
    let expected = SensorScale::ORIGINAL.kpa(counts(700)[0]);
    assert!((first - expected).abs() < 1e-9, "{first} kPa, not {expected}");
}

#[test]
fn a_line_without_a_name_ends_the_poller() {
    let (mut polling, told) = polling(VirtualLine::new(boards), 1);
    run(&mut polling, SECOND / 100);
    polling.bus_mut().line_mut().named = false;
    polling.bus_mut().line_mut().gone = true;
    let error = polling.cycle().unwrap_err();
    assert!(error.to_string().contains("the port is gone"), "{error}");
    assert!(told.events().iter().all(|event| !event.starts_with("lost")));
}

/// The answer was on time, but the process was stopped before it read it: its pressures are two
/// seconds old.
#[test]
fn an_answer_read_much_too_late_is_not_fresh() {
    let mut bus = Bus::new(VirtualLine::new(boards), options()).unwrap();
    bus.exchange(0, counts(300)).unwrap();
    // The next look at the line is for the answer: right after an exchange there is none before the
    // request.
    bus.line_mut().stops_for_ns = 2 * SECOND;
    let refused = bus.exchange(0, counts(300)).unwrap_err();
    let ExchangeError::TooOld { waited, .. } = refused else { panic!("{refused}") };
    assert_eq!(waited.as_millis(), 2_000);
    assert_eq!(bus.counters(0).stale, 1);
    bus.exchange(0, counts(300)).unwrap();
}

/// The program that sets the commands gets stuck, the bus thread does not.
#[test]
fn commands_that_nobody_renews_become_0_kpa_and_that_is_said() {
    let told = Told::default();
    let points = SetPoints::new(1).vent_after(Duration::from_millis(200));
    let bus = Bus::new(VirtualLine::new(boards), options()).unwrap();
    let source = Box::new(points.clone());
    let mut polling = Polling::new(bus, PollerOptions::for_devices(1), source, vec![Box::new(told.clone())]);
    let last_command = |polling: &mut Polling<VirtualLine>| {
        let (_, request) = polling.bus_mut().line_mut().requests.last().cloned().unwrap();
        Packet::decode(request.as_slice().try_into().unwrap()).unwrap().values
    };
    points.set(0, counts(300)).unwrap();
    run(&mut polling, SECOND / 10);
    assert_eq!(last_command(&mut polling), counts(300));
    told.take();
    run(&mut polling, SECOND);
    assert_eq!((told.events(), last_command(&mut polling)), (vec!["CommandsStale".to_owned()], VENTED));
    // They return by a ramp: 198 counts are 166.6 kPa, which take 1.67 s at 100 kPa/s.
    let renewing = |polling: &mut Polling<VirtualLine>, until_ns: u64| {
        for at_ns in (SECOND..=until_ns).step_by((SECOND / 10) as usize) {
            points.renew();
            run(polling, at_ns);
        }
        last_command(polling)[0].get()
    };
    assert_eq!(renewing(&mut polling, 2 * SECOND), 221);
    assert_eq!(told.events(), ["CommandsBack"]);
    assert_eq!(renewing(&mut polling, 3 * SECOND), 300);
}

#[test]
fn standing_still_is_said() {
    let (mut polling, told) = polling(VirtualLine::new(boards), 1);
    run(&mut polling, SECOND / 10);
    told.take();
    // Asleep between two cycles.
    let due_ns = polling.next_cycle_ns();
    polling.bus_mut().line_mut().sleep_until(due_ns + 3 * SECOND);
    polling.cycle().unwrap();
    assert_eq!(told.events(), ["stalled for 3000 ms"]);
    // In the middle of an exchange.
    polling.bus_mut().line_mut().stops_for_ns = 5 * SECOND;
    run(&mut polling, 9 * SECOND);
    let events = told.take();
    let stalls: Vec<_> = events.iter().filter(|event| event.starts_with("stalled for 4")).collect();
    assert_eq!(stalls.len(), 1, "{:?}", &events[..8]);
    assert_eq!(polling.statistics().boards[0].state, BoardState::Present);
}

/// From the pause on at which boards are taken for vented, and their set points return by a ramp:
/// nobody would know why otherwise.
#[test]
fn standing_still_is_told_from_where_set_points_return_by_a_ramp() {
    let after = |pause_ms: u64| {
        let (mut polling, told) = polling(VirtualLine::new(boards), 1);
        run(&mut polling, SECOND / 10);
        told.take();
        let due_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due_ns + pause_ms * SECOND / 1000);
        polling.cycle().unwrap();
        told.events()
    };
    assert_eq!(after(399), Vec::<String>::new());
    assert_eq!(after(400), ["stalled for 400 ms"]);
}

/// Two pauses that are short, one after the other: neither is worth a line, but 0 kPa is sent.
#[test]
fn zero_kpa_that_was_sent_for_want_of_answers_is_told() {
    let told = Told::default();
    let points = SetPoints::new(2);
    points.set(0, counts(300)).unwrap();
    let bus = Bus::new(VirtualLine::new(boards), options()).unwrap();
    let source = Box::new(points);
    let mut polling = Polling::new(bus, PollerOptions::for_devices(2), source, vec![Box::new(told.clone())]);
    run(&mut polling, SECOND / 10);
    told.take();
    // The answer is read too late to be believed.
    polling.bus_mut().line_mut().stops_for_ns = SECOND / 4;
    let until_ns = polling.bus_mut().line().now_ns() + SECOND / 4;
    run(&mut polling, until_ns);
    let due_ns = polling.next_cycle_ns();
    polling.bus_mut().line_mut().sleep_until(due_ns + SECOND / 5);
    let sent = polling.bus_mut().line().requests.len();
    polling.cycle().unwrap();
    let request = polling.bus_mut().line().requests[sent].1.clone();
    assert_eq!(Packet::decode(request.as_slice().try_into().unwrap()).unwrap().values, VENTED);
    let events = told.events();
    // Board 1 is at 0 kPa all the time.
    let paused: Vec<_> = events.iter().filter(|event| event.starts_with("Paused { boards: [0], ")).collect();
    assert_eq!(paused.len(), 1, "{events:?}");
    let now_ns = polling.bus_mut().line().now_ns();
    run(&mut polling, now_ns + SECOND);
    assert!(!told.events().iter().any(|event| event.contains("Paused")));
}

/// A board that goes missing just after the host stood still is told with that, and a second later
/// no more.
#[test]
fn a_board_that_is_missed_by_a_late_host_is_told_so() {
    for (pause_ns, expected) in [(0, "board 0 Missing, host late by 300 ms"), (2 * SECOND, "board 0 Missing")]
    {
        let present = Arc::new(Mutex::new(true));
        let theirs = Arc::clone(&present);
        let script = move |n: usize, request: &[u8]| {
            if *theirs.lock().unwrap() { boards(n, request) } else { Vec::new() }
        };
        let (mut polling, told) = polling(VirtualLine::new(script), 1);
        run(&mut polling, SECOND / 10);
        let due_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due_ns + 3 * SECOND / 10);
        polling.cycle().unwrap();
        run(&mut polling, SECOND / 2 + pause_ns);
        *present.lock().unwrap() = false;
        told.take();
        run(&mut polling, SECOND + pause_ns);
        let events = told.events();
        assert_eq!(events.last().map(String::as_str), Some(expected), "{events:?}");
    }
}

/// Board 0 has answered when the line goes while board 1 is asked.
#[test]
fn a_cycle_that_loses_the_line_shows_no_board_as_fresh() {
    let (mut polling, told) = polling(VirtualLine::new(boards), 2);
    polling.bus_mut().line_mut().goes_after = Some(3);
    polling.cycle().unwrap();
    polling.cycle().unwrap();
    let told = told.take();
    assert_eq!(told[2], "2 fresh");
    assert!(told[3].starts_with("lost"), "{told:?}");
    assert_eq!(told[4..], ["0 fresh"]);
}
