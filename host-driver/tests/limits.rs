//! What reaches the boards, in virtual time: limits, ramps, and venting that holds.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{
    BoardCommand, ChannelLimit, CommandSource, Limits, Override, PollerOptions, Polling, SetPoints,
    SourceStatus, VENTED,
};
use pneudrive_protocol::{Echo, Packet};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const SECOND: u64 = 1_000_000_000;

/// Boards that follow what they are commanded at once; a damaged request would panic.
fn followers() -> impl FnMut(usize, &[u8]) -> Reply + Send {
    |_, request| {
        let packet = Packet::decode(request[request.len() - 10..].try_into().unwrap()).unwrap();
        let board = packet.address.board();
        if board > 3 { Vec::new() } else { vec![(AT_ONCE, answer(board, packet.values[0].get()))] }
    }
}

fn polling(options: PollerOptions, source: Box<dyn CommandSource>) -> Polling<VirtualLine> {
    let bus_options =
        BusOptions::default().formats(FormatPolicy::Unchecked).echo(EchoMode::Known(Echo::Absent));
    let bus = Bus::new(VirtualLine::new(followers()), bus_options).unwrap();
    Polling::new(bus, options, source, Vec::new())
}

/// Cycles until the line's clock shows `until_ns`; what was sent to channel 0 of board 0 last.
fn run(polling: &mut Polling<VirtualLine>, until_ns: u64) -> u16 {
    loop {
        let due_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due_ns.min(until_ns));
        if due_ns >= until_ns {
            break;
        }
        polling.cycle().unwrap();
    }
    sent(polling).last().unwrap()[0].get()
}

/// All commands that board 0 was sent.
fn sent(polling: &mut Polling<VirtualLine>) -> Vec<BoardCommand> {
    let requests = polling.bus_mut().line_mut().requests.iter();
    let packets =
        requests.map(|(_, bytes)| Packet::decode(bytes[bytes.len() - 10..].try_into().unwrap()).unwrap());
    packets.filter(|packet| packet.address.board() == 0).map(|packet| packet.values).collect()
}

fn set_points(command: BoardCommand) -> SetPoints {
    let points = SetPoints::new(1);
    points.set(0, command).unwrap();
    points
}

fn everywhere(max_kpa: f64, max_rate_kpa_s: f64) -> Limits {
    Limits::everywhere(ChannelLimit { max_kpa, max_rate_kpa_s }).unwrap()
}

#[test]
fn no_source_gets_past_the_maximum() {
    /// Wants more and more.
    struct Rising(u16);
    impl CommandSource for Rising {
        fn fill(&mut self, _: u64, commands: &mut [BoardCommand]) -> SourceStatus {
            self.0 = (self.0 + 1) % 1024;
            commands.fill(counts(self.0));
            SourceStatus::Continues
        }
    }
    let mut limits = everywhere(300.0, f64::INFINITY);
    limits.set(0, 3, ChannelLimit { max_kpa: 100.0, max_rate_kpa_s: f64::INFINITY }).unwrap();
    let options = PollerOptions::for_devices(1).limits(limits);
    let mut polling = polling(options, Box::new(Rising(0)));
    run(&mut polling, SECOND);
    let sent = sent(&mut polling);
    let highest = |channel: usize| sent.iter().map(|command| command[channel].get()).max().unwrap();
    // 300 kPa are 458.8 counts, 100 kPa 221.2.
    assert_eq!([0, 1, 2, 3].map(highest), [458, 458, 458, 221]);
}

#[test]
fn a_rate_limit_holds_and_a_vent_does_not_wait_for_it() {
    let handle = Override::manual(&[counts(511)]);
    let options =
        PollerOptions::for_devices(1).vent(handle.latch()).limits(everywhere(f64::INFINITY, 84.1645));
    let mut polling = polling(options, handle.over(Box::new(set_points(counts(511)))));
    assert_eq!(run(&mut polling, SECOND), 202, "100 counts in the first second");
    let values: Vec<_> = sent(&mut polling).iter().map(|command| command[2].get()).collect();
    assert!(values.windows(2).all(|pair| pair[1] - pair[0] <= 1), "{values:?}");
    handle.vent();
    polling.cycle().unwrap();
    assert_eq!(sent(&mut polling).last(), Some(&VENTED));
}

/// Unplugs the adapter at 1 s and plugs it in again at 3 s.
fn unplug(polling: &mut Polling<VirtualLine>) {
    run(polling, SECOND);
    polling.bus_mut().line_mut().gone = true;
    run(polling, 3 * SECOND);
    polling.bus_mut().line_mut().back = true;
    polling.bus_mut().line_mut().requests.clear();
}

#[test]
fn after_a_port_comes_back_boards_vent_until_they_are_released() {
    let options = PollerOptions::for_devices(1);
    let latch = options.vent.clone();
    let mut polling = polling(options, Box::new(set_points(counts(340))));
    unplug(&mut polling);
    run(&mut polling, 10 * SECOND);
    assert!(latch.is_vented());
    let sent_since = sent(&mut polling);
    assert!(sent_since.len() > 1_000 && sent_since.iter().all(|command| *command == VENTED));
    latch.release();
    // 100 kPa/s are 118.8 counts a second.
    assert_eq!(run(&mut polling, 11 * SECOND), 221);
    assert_eq!(run(&mut polling, 13 * SECOND), 340);
}

/// A trajectory goes on where the release finds it, unless somebody has vented it by hand.
#[test]
fn the_release_after_an_outage_returns_to_the_source_and_that_of_a_vent_by_hand_does_not() {
    for (by_hand, expected) in [(false, 340), (true, VENTED[0].get())] {
        let handle = Override::following(1);
        let options = PollerOptions::for_devices(1).vent(handle.latch());
        let mut polling = polling(options, handle.over(Box::new(set_points(counts(340)))));
        unplug(&mut polling);
        assert_eq!(run(&mut polling, 4 * SECOND), VENTED[0].get());
        assert!(handle.returns());
        if by_hand {
            handle.vent();
        }
        handle.release();
        let first = run(&mut polling, 4 * SECOND + SECOND / 10);
        assert!(first <= 102 + 12, "{first}");
        assert_eq!(run(&mut polling, 7 * SECOND), expected, "vented by hand: {by_hand}");
    }
}

#[test]
fn with_resume_set_points_return_by_a_ramp() {
    let options = PollerOptions::for_devices(1).resume(true);
    let latch = options.vent.clone();
    // The board has vented meanwhile: it reports 0 kPa until it is commanded otherwise.
    let mut polling = polling(options, Box::new(set_points(counts(340))));
    unplug(&mut polling);
    run(&mut polling, 3 * SECOND + SECOND / 2);
    assert!(!latch.is_vented());
    let sent_since = sent(&mut polling);
    assert_eq!(sent_since[0], VENTED, "until it answers");
    let values: Vec<_> = sent_since.iter().map(|command| command[0].get()).collect();
    assert!(values.windows(2).all(|pair| pair[1].abs_diff(pair[0]) <= 1), "{values:?}");
    assert_eq!(run(&mut polling, 7 * SECOND), 340);
}

/// A board that is unplugged by itself returns by a ramp from where it is, not by a step.
#[test]
fn a_board_that_was_away_returns_by_a_ramp() {
    let present = Arc::new(Mutex::new(true));
    let theirs = Arc::clone(&present);
    let mut follow = followers();
    let script = move |n: usize, request: &[u8]| match *theirs.lock().unwrap() {
        true => follow(n, request),
        false => Vec::new(),
    };
    let bus_options =
        BusOptions::default().formats(FormatPolicy::Unchecked).echo(EchoMode::Known(Echo::Absent));
    let bus = Bus::new(VirtualLine::new(script), bus_options).unwrap();
    let source = Box::new(set_points(counts(340)));
    let mut polling = Polling::new(bus, PollerOptions::for_devices(1), source, Vec::new());
    run(&mut polling, SECOND);
    *present.lock().unwrap() = false;
    run(&mut polling, 2 * SECOND);
    *present.lock().unwrap() = true;
    polling.bus_mut().line_mut().requests.clear();
    run(&mut polling, 2 * SECOND + SECOND / 2);
    let values: Vec<_> = sent(&mut polling).iter().map(|command| command[0].get()).collect();
    assert!(values.windows(2).all(|pair| pair[1].abs_diff(pair[0]) <= 1), "{values:?}");
    assert!(values.last().unwrap() < &200, "{values:?}");
    assert_eq!(run(&mut polling, 5 * SECOND), 340);
}

/// Every cycle waits 0.5 s for a board that is not there: that is no pause of the board that is.
#[test]
fn a_missing_board_does_not_keep_the_others_from_their_set_points() {
    let script = |n: usize, request: &[u8]| -> Reply {
        let packet = Packet::decode(request[request.len() - 10..].try_into().unwrap()).unwrap();
        if packet.address.board() == 0 { followers()(n, request) } else { Vec::new() }
    };
    let bus_options = BusOptions::default()
        .formats(FormatPolicy::Unchecked)
        .echo(EchoMode::Known(Echo::Absent))
        .answer_allowance(Duration::from_nanos(SECOND / 2));
    let bus = Bus::new(VirtualLine::new(script), bus_options).unwrap();
    let points = SetPoints::new(2);
    points.set(0, counts(340)).unwrap();
    let mut polling = Polling::new(bus, PollerOptions::for_devices(2), Box::new(points), Vec::new());
    run(&mut polling, 20 * SECOND);
    assert!(sent(&mut polling).iter().all(|command| *command == counts(340)));
}
