//! A whole bus of emulated chips at 1, 2 and 3 Mbaud, polled by the host's own code, in virtual
//! time.
//!
//! `cargo test -p system-tests --test firmware fast_bus:: -- --nocapture` prints the table of
//! docs/scaling.md.

use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{LineRatePolicy, Pace, PollerOptions, Polling, SetPoints};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::pages::{Counter, LineRate};
use pneudrive_protocol::{Baud, Counts};
use pneudrive_sim::rig::{Firmware, RigOptions};
use std::time::Duration;
use system_tests::firmware;
use system_tests::virtual_bus::{VirtualBus, bus};

fn chips(boards: usize) -> RigOptions {
    RigOptions {
        boards,
        firmware: Some(Firmware::new(firmware::elf())),
        strict: true,
        ..RigOptions::default()
    }
}

/// Chips polled for so long at up to `fastest`; the statistics of the time after the first half
/// second, in which rates are agreed on.
fn poll(boards: u16, fastest: LineRate, pace: Pace, seconds: f64) -> (Statistics, Polling<VirtualBus>) {
    let points = SetPoints::new(usize::from(boards));
    let line_rate = LineRatePolicy::default().fastest(fastest);
    let line_rate = (fastest != LineRate::Compiled).then_some(line_rate);
    let options = PollerOptions::for_devices(boards).pace(pace).line_rate(line_rate);
    let mut bus = bus(&chips(usize::from(boards)), BusOptions::default());
    // So that what is measured begins at the rate.
    for board in 0..boards as u8 {
        bus.ping(board).unwrap();
    }
    let run = |bus: Bus<VirtualBus>, options: PollerOptions, points: &SetPoints, seconds: f64| {
        let mut polling = Polling::new(bus, options, Box::new(points.clone()), Vec::new());
        let end_ns = polling.bus_mut().line().now_ns() + (seconds * 1e9) as u64;
        while polling.bus_mut().line().now_ns() < end_ns {
            let due_ns = polling.next_cycle_ns();
            polling.bus_mut().line_mut().sleep_until(due_ns);
            polling.cycle().unwrap();
        }
        polling
    };
    let polling = run(bus, options.clone(), &points, 0.2);
    for board in 0..usize::from(boards) {
        points.set(board, [Counts::saturating(250); 4]).unwrap();
    }
    let mut polling = run(polling.into_bus(), options, &points, seconds);
    (polling.finish(), polling)
}

/// Four emulated chips at 3 Mbaud, 2 kHz, checked packets in sessions, nothing lost.
#[test]
fn four_chips_at_3_mbaud_are_polled_at_2_khz_without_a_loss() {
    let pace = Pace::every(Duration::from_micros(500));
    let (statistics, mut polling) = poll(4, LineRate::ThreeMbaud, pace, 4.0);
    assert_eq!(statistics.baud, Some(3_000_000));
    assert!((statistics.loop_hz.mean - 2_000.0).abs() < 1.0, "{statistics:?}");
    assert_eq!((statistics.lost, statistics.rejected, statistics.missed_ticks), (0, 0, 0), "{statistics:?}");
    assert!(statistics.exchanges >= 31_990, "{statistics:?}");
    for board in 0..4 {
        assert!(polling.bus_mut().in_session(board));
        assert_eq!(polling.bus_mut().counter(board, Counter::LateSteps), Ok(0));
        assert_eq!(polling.bus_mut().counter(board, Counter::DamagedRequests), Ok(0));
    }
    assert_eq!(polling.bus_mut().line().counters().violations(), 0);
}

/// The table of docs/scaling.md: as fast as possible, in virtual time, so that the boards'
/// turnaround is all that is added to the wire.
#[test]
fn a_table_of_rates() {
    println!("| boards | 1 Mbaud: wire's limit, measured | 2 Mbaud | 3 Mbaud |\n| --- | --- | --- | --- |");
    for boards in 1..=4 {
        let cells = LineRate::ALL.map(|rate| {
            let baud = rate.baud(Baud::ORIGINAL);
            let (statistics, _) = poll(boards, rate, Pace::AsFastAsPossible, 1.0);
            assert_eq!(statistics.baud, Some(baud.get()));
            assert_eq!((statistics.lost, statistics.rejected), (0, 0), "{statistics:?}");
            let limit = baud.cycle_limit_hz(boards.into());
            // At most 20 us of turnaround, and 0.2 % by which a chip's divisors miss 3 Mbaud.
            let slowest = 1e9 / (f64::from(boards) * (baud.exchange_ns() as f64 * 1.002 + 20_000.0));
            let mean = statistics.loop_hz.mean;
            assert!(mean < limit && mean > slowest, "{mean} Hz, wire {limit} Hz, slowest {slowest} Hz");
            format!("{limit:.0}, {mean:.0}")
        });
        println!("| {boards} | {} |", cells.join(" | "));
    }
}
