//! Host and boards over a real tty: virtual boards behind a pty, or real ones.
//!
//! Required hardware: none; or, with `cargo test -p system-tests --features hardware --test host
//! boards:: -- --test-threads 1`, one to four boards on the port that PNEUDRIVE_PORT names (their
//! number in PNEUDRIVE_DEVICES), valves connected or not, nothing that a pressure of 30 kPa could
//! damage.

use crate::target::Target;
use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::poller::{Poller, PollerOptions, SetPoints};
use pneudrive_protocol::SensorScale;
use std::time::{Duration, Instant};

/// Boards take up to this long from power-up to their first answer. The limit is for a test that
/// hangs.
const PATIENCE: Duration = Duration::from_secs(30);

#[test]
fn every_board_answers_a_ping() {
    let target = Target::start(4);
    let mut bus = target.bus();
    for board in 0..target.devices as u8 {
        let started = Instant::now();
        while let Err(error) = bus.ping(board) {
            assert!(started.elapsed() < PATIENCE, "{error}");
        }
        let pressures = bus.ping(board).unwrap().pressures;
        for counts in pressures {
            let kpa = SensorScale::ORIGINAL.kpa(counts);
            assert!((-35.0..=690.0).contains(&kpa), "board {board} reports {kpa} kPa, which no sensor can");
        }
    }
}

#[test]
fn a_board_that_is_not_there_does_not_answer() {
    let target = Target::start(1);
    let mut bus = Bus::open(target.path(), BusOptions::default()).unwrap();
    let error = bus.ping(9).unwrap_err();
    assert!(error.to_string().contains("board 9 (0xFFF6): no answer"), "{error}");
}

#[test]
fn the_poller_gets_fresh_rows_of_all_boards_and_leaves_them_at_zero() {
    let target = Target::start(3);
    let devices = usize::from(target.devices);
    let points = SetPoints::new(devices);
    let options = PollerOptions::for_devices(target.devices);
    let poller = Poller::start(target.bus(), options, Box::new(points.clone()), Vec::new()).unwrap();
    for board in 0..devices {
        points.set(board, [SensorScale::ORIGINAL.counts(30.0).unwrap(); 4]).unwrap();
    }
    let started = Instant::now();
    loop {
        assert!(started.elapsed() < PATIENCE, "{:?}", poller.latest());
        let row = poller.latest();
        let all_fresh = row.boards.len() == devices && row.boards.iter().all(|board| board.fresh().is_some());
        if row.cycle.unwrap_or(0) > 500 && all_fresh {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let finished = poller.stop().unwrap();
    assert_eq!((finished.error, finished.not_safe), (None, Vec::new()));
    assert!(finished.statistics.boards.iter().all(|board| board.answered > 400), "{:?}", finished.statistics);
}

/// Chambers reach 30 kPa and are empty again after the run. Needs air, so only for virtual boards.
#[cfg(not(feature = "hardware"))]
#[test]
fn commanded_pressures_arrive_in_the_chambers() {
    let target = Target::start(1);
    let points = SetPoints::new(1);
    points.set(0, [SensorScale::ORIGINAL.counts(30.0).unwrap(); 4]).unwrap();
    let options = PollerOptions::for_devices(1);
    let poller = Poller::start(target.bus(), options, Box::new(points), Vec::new()).unwrap();
    let started = Instant::now();
    let arrived = |kpa: f64| (kpa - 30.0).abs() < 5.0;
    while !poller
        .latest()
        .boards
        .iter()
        .any(|board| board.fresh().is_some_and(|r| r.kpa.iter().all(|&p| arrived(p))))
    {
        assert!(started.elapsed() < PATIENCE, "{:?}", poller.latest());
        std::thread::sleep(Duration::from_millis(5));
    }
}
