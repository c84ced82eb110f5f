//! No address on the wire that is not meant: what a board 0 of the original kind would hear of the
//! host and the other boards. In virtual time.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{BoardFormat, Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{BoardCommand, Event, Observer, PollerOptions, Polling, Row, SetPoints};
use pneudrive_protocol::{Address, Counts, Echo, RequestDecoder};
use std::sync::{Arc, Mutex};

fn options(frames: FormatPolicy) -> BusOptions {
    BusOptions::default().echo(EchoMode::Known(Echo::Absent)).formats(frames).sessions(false)
}

fn bus(frames: FormatPolicy, script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static) -> Bus<VirtualLine> {
    Bus::new(VirtualLine::new(script), options(frames)).unwrap()
}

/// Answers of pressures that all end in 0xFF.
fn ends_in_0xff(_: usize, request: &[u8]) -> Reply {
    vec![(AT_ONCE, answer(0xFF - request[1], 511))]
}

/// Boards that check, from `first` on; the others are of the original kind, and drop checked
/// requests.
fn boards(first: u8, pressure: u16) -> impl FnMut(usize, &[u8]) -> Reply {
    let mut ears: Vec<_> = (0..4).map(|board| RequestDecoder::new(Address::of_board(board))).collect();
    move |_, request| {
        let board = 0xFF - request[1];
        if board < first {
            return vec![(AT_ONCE, answer(board, pressure))];
        }
        let heard =
            request.iter().filter_map(|&byte| ears[usize::from(board)].push(byte)?.pressures()).last();
        let heard = heard.map(|heard| heard.answer(Address::of_board(board), counts(pressure)));
        heard.map_or_else(Vec::new, |bytes| vec![(AT_ONCE, bytes.to_vec())])
    }
}

#[test]
fn a_request_after_an_answer_that_ends_in_0xff_comes_behind_a_guard_byte() {
    let mut bus = bus(FormatPolicy::Unchecked, ends_in_0xff);
    for turn in 0..20 {
        bus.exchange(turn % 4, counts(300)).unwrap();
    }
    let line = bus.line();
    let before: Vec<usize> = line.guards.iter().map(|&(_, requests)| requests).collect();
    assert_eq!(before, (0..20).collect::<Vec<_>>(), "one before each, the first included");
    // The longest pulse of a 555 that the guard triggers ends before the request begins.
    for (&(guard_ns, n), &(request_ns, _)) in line.guards.iter().zip(&line.requests) {
        assert!(request_ns - guard_ns >= 113_600, "request {n}: {} ns", request_ns - guard_ns);
    }
}

#[test]
fn a_request_after_anything_else_needs_none() {
    let mut bus = bus(FormatPolicy::Unchecked, |_, request| vec![(AT_ONCE, answer(0xFF - request[1], 510))]);
    for turn in 0..20 {
        bus.exchange(turn % 4, counts(511)).unwrap();
    }
    assert_eq!(bus.line().guards.len(), 1, "before the first request, when nothing is known of the line");
}

/// What failed, and what came unasked, may have been heard otherwise by a board.
#[test]
fn a_request_after_a_disturbance_comes_behind_a_guard_byte() {
    let mut bus = bus(FormatPolicy::Unchecked, |number, request| match number {
        1 => vec![(AT_ONCE, vec![0x12; 7])],
        4 => Vec::new(),
        _ => vec![(AT_ONCE, answer(0xFF - request[1], 500))],
    });
    bus.exchange(0, counts(300)).unwrap();
    bus.exchange(1, counts(300)).unwrap_err();
    bus.exchange(0, counts(300)).unwrap();
    let now_ns = bus.line().now_ns();
    bus.line_mut().inject(now_ns, &[0xFF]);
    bus.line_mut().sleep_until(now_ns + 1_000_000);
    bus.exchange(0, counts(300)).unwrap();
    bus.exchange(1, counts(300)).unwrap_err();
    bus.exchange(0, counts(300)).unwrap();
    let before: Vec<usize> = bus.line().guards.iter().map(|&(_, requests)| requests).collect();
    assert_eq!(before, [0, 2, 3, 5]);
}

#[test]
fn set_points_that_end_in_0xff_are_sent_one_count_lower_as_long_as_board_0_may_be_of_the_original_kind() {
    // Board 0 is of the original kind.
    let mut mixed = bus(FormatPolicy::Negotiate, boards(1, 500));
    (0..4).for_each(|board| drop(mixed.ping(board)));
    assert_eq!(mixed.format(3), BoardFormat::Checked);
    for (wanted, sent) in [(255, 254), (511, 510), (767, 766), (1023, 1022), (510, 510), (512, 512)] {
        let all = counts(wanted);
        let lower = [all[0], all[1], all[2], Counts::new(sent).unwrap()];
        assert_eq!(mixed.commands_on_the_wire(all), lower);
        for board in 0..4 {
            mixed.exchange(board, all).unwrap();
            let (_, bytes) = mixed.line().requests.last().unwrap();
            assert_eq!(bytes[9], sent.to_be_bytes()[1], "on the wire, to board {board}");
        }
    }
    // All check.
    let mut checked = bus(FormatPolicy::Negotiate, boards(0, 511));
    for board in 0..4 {
        checked.ping(board).unwrap();
    }
    let guards = checked.line().guards.len();
    for board in 0..4 {
        checked.exchange(board, counts(511)).unwrap();
        assert_eq!(checked.line().requests.last().unwrap().1[9], 0xFF);
    }
    assert_eq!((guards, checked.line().guards.len()), (1, 1), "only while nothing was known of board 0");
    assert_eq!(bus(FormatPolicy::Checked, boards(0, 511)).commands_on_the_wire(counts(511)), counts(511));
}

/// What an observer is told.
#[derive(Clone, Default)]
struct Told(Arc<Mutex<Heard>>);

/// Commands of board 1 in the rows, and the boards whose commands were lowered.
type Heard = (Vec<BoardCommand>, Vec<(u8, BoardCommand)>);

impl Observer for Told {
    fn row(&mut self, row: &Row<'_>) {
        self.0.lock().unwrap().0.push(row.boards[1].command);
    }

    fn event(&mut self, event: &Event<'_>) {
        if let Event::CommandLowered { board, sent, .. } = event {
            self.0.lock().unwrap().1.push((*board, *sent));
        }
    }
}

#[test]
fn the_row_has_what_was_sent_and_it_is_told_once() {
    let bus = bus(FormatPolicy::Unchecked, ends_in_0xff);
    let points = SetPoints::new(2);
    points.set(1, counts(511)).unwrap();
    let told = Told::default();
    let observers: Vec<Box<dyn Observer>> = vec![Box::new(told.clone())];
    let mut polling = Polling::new(bus, PollerOptions::for_devices(2), Box::new(points), observers);
    for _ in 0..10 {
        let at_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(at_ns);
        polling.cycle().unwrap();
    }
    let sent = [511, 511, 511, 510].map(|value| Counts::new(value).unwrap());
    assert_eq!(*told.0.lock().unwrap(), (vec![sent; 10], vec![(1, sent)]));
}
