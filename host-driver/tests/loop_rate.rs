//! The figures of the loop rate with a given rate, in virtual time: a run ends in the middle of a
//! period.

use crate::support::answer;
use crate::support::virtual_line::{AT_ONCE, VirtualLine};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{Pace, PollerOptions, Polling, SetPoints};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::{CHANNELS, Counts, Echo};
use std::time::Duration;

/// `cycles` cycles of one board, and the run ends as soon as the last one's exchange is over.
fn run(pace: Pace, cycles: u64, answers: bool) -> Statistics {
    let line =
        VirtualLine::new(move |_, _| if answers { vec![(AT_ONCE, answer(0, 300))] } else { Vec::new() });
    let options = BusOptions::default().formats(FormatPolicy::Unchecked).echo(EchoMode::Known(Echo::Absent));
    let polled = PollerOptions::for_devices(1).pace(pace);
    let mut bus = Bus::new(line, options).unwrap();
    // Before a bus's first request goes a guard byte, which takes its time once.
    let _ = bus.exchange(0, [Counts::ATMOSPHERE; CHANNELS]);
    let mut polling = Polling::new(bus, polled, Box::new(SetPoints::new(1)), Vec::new());
    for _ in 0..cycles {
        let due_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due_ns);
        polling.cycle().unwrap();
    }
    polling.finish()
}

#[test]
fn the_last_cycle_of_a_run_with_a_rate_has_no_period() {
    let pace = Pace::every(Duration::from_millis(50));
    let statistics = run(pace, 21, true);
    let rate = statistics.loop_hz;
    assert!((rate.mean - 20.0).abs() < 1e-9 && rate.std < 1e-6, "{rate:?}");
    assert!((rate.min - 20.0).abs() < 1e-9, "{rate:?}");
    assert!((statistics.cycle_us.p50 - 50_000.0).abs() < 50.0, "{:?}", statistics.cycle_us);
    // It counts all the same: 1 s, and one exchange.
    assert_eq!(statistics.cycles, 21);
    assert!((statistics.seconds - 1.0002).abs() < 1e-6, "{} s", statistics.seconds);
}

#[test]
fn one_cycle_after_the_other_all_have_a_period() {
    let statistics = run(Pace::AsFastAsPossible, 100, true);
    let rate = statistics.loop_hz;
    assert!((rate.mean - 5_000.0).abs() < 1e-6 && rate.std < 1e-3, "{rate:?}");
    assert!((statistics.seconds - 0.02).abs() < 1e-9, "{} s", statistics.seconds);
}

/// Without a rate the next cycle waits until a board can be asked.
#[test]
fn a_board_that_is_left_alone_makes_the_last_cycle_no_shorter() {
    let statistics = run(Pace::AsFastAsPossible, 3, false);
    let (rate, cycle_us) = (statistics.loop_hz, statistics.cycle_us);
    assert!(rate.std < 0.2 * rate.mean, "{rate:?}, {cycle_us:?}");
    assert_eq!(statistics.cycles, 3);
}
