//! The examples, on virtual boards behind ptys.

use pneudrive_host::bus::{Bus, BusOptions, EchoMode};
use pneudrive_host::poller::{Poller, StartError};
use pneudrive_protocol::{Baud, Echo};
use pneudrive_virtual::{VirtualBoards, VirtualOptions};
use std::time::Duration;

#[path = "../examples/controller.rs"]
#[allow(dead_code, reason = "its main")]
mod controller;
#[path = "../examples/poll.rs"]
#[allow(dead_code, reason = "its main")]
mod poll;
#[path = "../examples/set_points.rs"]
#[allow(dead_code, reason = "its main")]
mod set_points;
#[path = "../examples/several_buses.rs"]
#[allow(dead_code, reason = "its main")]
mod several_buses;
#[path = "../examples/trajectory.rs"]
#[allow(dead_code, reason = "its main")]
mod trajectory;

/// Virtual boards, and a bus with patience: the machine that runs the tests may be busy with
/// others.
fn boards(boards: u16) -> (VirtualBoards, Bus) {
    let sim = VirtualBoards::start(&VirtualOptions::new(boards, Baud::ORIGINAL)).unwrap();
    let echo = EchoMode::Known(Echo::Absent);
    let options = BusOptions::default().answer_allowance(Duration::from_secs(1)).echo(echo);
    let bus = Bus::open(sim.path(), options).unwrap();
    (sim, bus)
}

#[test]
fn poll() {
    let (_sim, bus) = boards(2);
    let finished = poll::run(bus, 2, Duration::from_millis(500)).unwrap();
    assert_eq!((finished.error, finished.not_safe), (None, vec![]));
    let statistics = finished.statistics;
    assert!(statistics.exchanges > 10 && statistics.lost == 0, "{statistics:?}");
}

/// What README.md shows.
#[test]
fn set_points() {
    let sim = boards(4).0;
    set_points::run(sim.path().to_str().unwrap()).unwrap();
    let nowhere = set_points::run("/dev/none").unwrap_err();
    assert!(nowhere.to_string().contains("/dev/none"), "{nowhere}");
}

/// It gets there, however few of its steps the machine lets it make.
#[test]
fn controller() {
    let (_sim, bus) = boards(1);
    let difference_kpa = controller::run(bus, Duration::from_secs(6)).unwrap();
    assert!((30.0..50.0).contains(&difference_kpa), "{difference_kpa}");
}

#[test]
fn trajectory() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let (_sim, bus) = boards(1);
    let rows = trajectory::run(bus, &file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let table: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(table.len() as u64, rows + 1);
    let column = table[0].split(',').position(|name| name == "b0_p0_kpa").unwrap();
    let highest = table[1..].iter().filter_map(|row| row.split(',').nth(column)?.parse::<f64>().ok());
    let highest = highest.fold(0.0, f64::max);
    assert!((140.0..170.0).contains(&highest), "{highest} kPa, wanted 150");
    // A file that is there is not replaced.
    assert!(trajectory::run(boards(1).1, &file).is_err());
}

#[test]
fn several_buses() {
    let ((_first, one), (_second, other)) = (boards(1), boards(1));
    let answers = several_buses::run(vec![one, other], Duration::from_millis(500)).unwrap();
    assert!(answers.len() == 2 && answers.iter().all(|answers| *answers > 5), "{answers:?}");
}

#[test]
fn what_cannot_be_polled_is_said() {
    let none = Poller::builder(boards(1).1).start().unwrap_err();
    assert!(matches!(none, StartError::NoBoards), "{none}");
    for rate_hz in [0.0, -1.0, f64::NAN, 20_000.0] {
        let refused = Poller::builder(boards(1).1).boards([0]).rate_hz(rate_hz).start().unwrap_err();
        assert!(matches!(refused, StartError::Rate(_)), "{refused}");
    }
}

#[test]
fn a_bus_is_handed_back_and_goes_on() {
    let (_sim, bus) = boards(1);
    let poller = Poller::builder(bus).boards([0]).start().unwrap();
    while poller.latest().boards.iter().all(|board| board.reading.is_none()) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let (finished, mut bus) = poller.into_bus().unwrap();
    assert_eq!((finished.error, finished.not_safe), (None, vec![]));
    bus.ping(0).unwrap();
    let finished = poll::run(bus, 1, Duration::from_millis(200)).unwrap();
    assert!(finished.statistics.exchanges > 5 && finished.error.is_none(), "{finished:?}");
}
