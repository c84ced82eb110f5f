//! The host on buses with boards of the original kind, alone and beside boards that check, in
//! virtual time.

use pneudrive_host::bus::{BoardFormat, Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{PollerOptions, Polling, SetPoints};
use pneudrive_protocol::{Counts, Echo};
use pneudrive_sim::rig::RigOptions;
use system_tests::virtual_bus::{VirtualBus, bus};

/// Which boards of four are of the original kind.
const BUSES: [&[u8]; 5] = [&[0], &[0, 2], &[1, 3], &[1, 2, 3], &[0, 1, 2, 3]];

fn rig(original: &[u8], faults: &[&str]) -> RigOptions {
    RigOptions {
        boards: 4,
        original: original.iter().copied().collect(),
        faults: faults.iter().map(|text| text.parse().unwrap()).collect(),
        ..RigOptions::default()
    }
}

/// Four boards of which these are of the original kind, past their power-up vent, asked until their
/// kind is known; commands are all at 0 kPa.
fn polling(original: &[u8], faults: &[&str], options: BusOptions) -> (Polling<VirtualBus>, SetPoints) {
    let mut bus = bus(&rig(original, faults), options);
    bus.line_mut().sleep_until(2_200_000_000);
    for board in 0..4 {
        while bus.format(board) == BoardFormat::Unknown {
            let _ = bus.ping(board);
        }
    }
    let points = SetPoints::new(4);
    let polling = Polling::new(bus, PollerOptions::for_devices(4), Box::new(points.clone()), Vec::new());
    (polling, points)
}

fn run(polling: &mut Polling<VirtualBus>, seconds: f64) {
    let end_ns = polling.bus_mut().line().now_ns() + (seconds * 1e9) as u64;
    while polling.bus_mut().line().now_ns() < end_ns {
        let due_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due_ns);
        polling.cycle().unwrap();
    }
}

fn command_all(points: &SetPoints, counts: u16) {
    (0..4).for_each(|board| points.set(board, [Counts::new(counts).unwrap(); 4]).unwrap());
}

/// Set points and pressures that end in 0xFF: nobody is called by a false name, so nothing is lost,
/// nobody speaks unasked, and every chamber comes to its set point.
#[test]
fn set_points_that_end_in_0xff_are_followed_on_every_mixed_bus() {
    for original in BUSES {
        for value in [255, 511] {
            let (mut polling, points) = polling(original, &[], BusOptions::default());
            let before = polling.bus_mut().line().counters().clone();
            command_all(&points, value);
            run(&mut polling, 3.0);
            let statistics = polling.finish();
            assert_eq!(
                (statistics.lost, statistics.rejected),
                (0, 0),
                "{original:?}, {value}: {statistics:?}"
            );
            let after = polling.bus_mut().line().counters().clone();
            assert_eq!(after.violations(), before.violations(), "{original:?}, {value}: {after:?}");
            for board in 0..4 {
                let kind =
                    if original.contains(&board) { BoardFormat::Unchecked } else { BoardFormat::Checked };
                let reading = polling.bus_mut().exchange(board, [Counts::ATMOSPHERE; 4]).unwrap();
                for pressure in reading.pressures {
                    let off = i32::from(pressure.get()) - i32::from(value);
                    assert!(
                        (-7..=3).contains(&off),
                        "{original:?}, {value}: board {board} reads {pressure:?}"
                    );
                }
                assert_eq!(polling.bus_mut().format(board), kind);
            }
        }
    }
}

/// The same where the host is told that all boards are of the original kind.
#[test]
fn unchecked_packets_alone_call_nobody_by_a_false_name() {
    for original in BUSES {
        let options = BusOptions::default().formats(FormatPolicy::Unchecked);
        let (mut polling, points) = polling(original, &[], options);
        let before = polling.bus_mut().line().counters().violations();
        command_all(&points, 511);
        run(&mut polling, 2.0);
        let statistics = polling.finish();
        assert_eq!((statistics.lost, statistics.rejected), (0, 0), "{original:?}: {statistics:?}");
        assert_eq!(polling.bus_mut().line().counters().violations(), before, "{original:?}");
    }
}

/// Pressures of a board, as it reports them.
fn pressures(polling: &mut Polling<VirtualBus>, board: u8) -> [u16; 4] {
    polling.bus_mut().exchange(board, [Counts::ATMOSPHERE; 4]).unwrap().pressures.map(Counts::get)
}

/// Every mixed bus, from 344 kPa on channels that end in 0xFF: what says that it is at 0 kPa is.
#[test]
fn a_run_ends_with_every_board_vented() {
    for original in BUSES {
        let (mut polling, points) = polling(original, &[], BusOptions::default());
        command_all(&points, 511);
        run(&mut polling, 2.0);
        assert_eq!(polling.make_safe(), Ok(Vec::new()), "{original:?}");
        for &board in original {
            let pressures = pressures(&mut polling, board);
            assert!(pressures.iter().all(|&p| p <= 114), "{original:?}: board {board} reads {pressures:?}");
        }
    }
}

/// What made the original's board 0 drop every command of 0 kPa and answer it: a host without guard
/// bytes whose last neighbour reads 511 counts. The answers alone would have confirmed it.
#[test]
fn a_board_that_drops_its_last_commands_is_named() {
    let (mut polling, points) = polling(&[0], &[], BusOptions::default());
    command_all(&points, 511);
    run(&mut polling, 2.0);
    let mut line = polling.into_bus().into_line();
    // Another host's bus, which does not guard: all that it sends is preceded by 0xFF.
    line.before_each_request(&[0xFF]);
    let echo = EchoMode::Known(Echo::Absent);
    let options = BusOptions::default().formats(FormatPolicy::Unchecked).echo(echo);
    let mut bus = Bus::new(line, options).unwrap();
    bus.exchange(0, [Counts::saturating(500); 4]).unwrap();
    let from_ns = bus.line().now_ns();
    assert_eq!(bus.make_safe(0..1), Ok(vec![0]));
    assert!((bus.line().now_ns() - from_ns) < 1_100_000_000);
    let answer = bus.ping(0).unwrap();
    assert!(answer.pressures.iter().all(|p| p.get() > 480), "it answers, and is under pressure: {answer:?}");
}

/// The original's client starts as soon as our host has ended: boards that check obey it at once.
#[test]
fn an_unchecked_client_is_obeyed_as_soon_as_the_host_has_ended() {
    let (mut polling, points) = polling(&[], &[], BusOptions::default());
    command_all(&points, 300);
    run(&mut polling, 1.0);
    assert_eq!(polling.make_safe(), Ok(Vec::new()));
    let line = polling.into_bus().into_line();
    let options = BusOptions::default().formats(FormatPolicy::Unchecked);
    let mut client = Bus::new(line, options).unwrap();
    for board in 0..4 {
        client.exchange(board, [Counts::saturating(300); 4]).unwrap();
    }
    assert!((0..4).all(|board| client.counters(board).lost() == 0));
}

/// Bytes are lost, and with them one exchange in twenty or so: each costs its own row, and boards
/// are asked on.
#[test]
fn a_lost_exchange_with_an_original_board_costs_little_more_than_its_row() {
    for original in [&[0][..], &[0, 1, 2, 3]] {
        let faults = ["drop=0.0025"];
        let (mut polling, points) = polling(original, &faults, BusOptions::default());
        command_all(&points, 300);
        run(&mut polling, 10.0);
        let statistics = polling.finish();
        for &board in original {
            let board = statistics.boards[usize::from(board)];
            assert!(board.lost > 100, "{statistics:?}");
            assert!(board.rows_without_reading < 2 * board.lost, "{original:?}: {statistics:?}");
        }
    }
}
