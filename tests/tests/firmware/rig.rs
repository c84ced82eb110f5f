//! The firmware's ELF on emulated chips, on the strict virtual bus, with the plant behind their
//! pins and the host's own code as the bus master. In virtual time, but for the last test.

use pneudrive_host::bus::{BoardFormat, Bus, BusOptions, FormatPolicy};
use pneudrive_host::poller::{BoardState, Pace, PollerOptions, Polling, SetPoints};
use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use pneudrive_sim::pty::{EmbeddedSim, PtyOptions};
use pneudrive_sim::rig::{Firmware, RigOptions};
use std::time::Duration;
use system_tests::firmware;
use system_tests::virtual_bus::{VirtualBus, bus};

const SCALE: SensorScale = SensorScale::ORIGINAL;
const MS: u64 = 1_000_000;

fn chips(boards: u16, faults: &[&str]) -> RigOptions {
    RigOptions {
        boards: usize::from(boards),
        firmware: Some(Firmware::new(firmware::elf())),
        faults: faults.iter().map(|text| text.parse().unwrap()).collect(),
        strict: faults.is_empty(),
        ..RigOptions::default()
    }
}

/// A host on a bus of chips that have booted, asking every board every `period_ms`.
struct Run {
    points: SetPoints,
    boards: u16,
    polling: Polling<VirtualBus>,
}

impl Run {
    fn start(boards: u16, faults: &[&str], options: BusOptions, period_ms: u64) -> Self {
        let points = SetPoints::new(usize::from(boards));
        let pace = Pace::every(Duration::from_millis(period_ms));
        let polled = PollerOptions::for_devices(boards).pace(pace);
        let polling =
            Polling::new(bus(&chips(boards, faults), options), polled, Box::new(points.clone()), Vec::new());
        Self { points, boards, polling }
    }

    fn command(&self, kpa: f64) {
        for board in 0..usize::from(self.boards) {
            self.points.set(board, [SCALE.counts(kpa).unwrap(); CHANNELS]).unwrap();
        }
    }

    /// Polls for so long; gives the pressures of all chambers at the end, kPa.
    fn poll(&mut self, seconds: f64) -> Vec<f64> {
        let end = self.polling.bus_mut().line().rig_now_ns() + (seconds * 1e9) as u64;
        while self.polling.bus_mut().line().rig_now_ns() < end {
            let due = self.polling.next_cycle_ns();
            self.sleep_until(due);
            self.polling.cycle().unwrap();
        }
        self.measured()
    }

    /// One cycle at once; gives the pressures of all chambers, kPa.
    fn measured(&mut self) -> Vec<f64> {
        let boards = 0..self.boards as u8;
        let zero = [Counts::ATMOSPHERE; CHANNELS];
        boards
            .flat_map(|board| {
                let command = self.points.get(usize::from(board)).unwrap_or(zero);
                self.polling
                    .bus_mut()
                    .exchange(board, command)
                    .unwrap()
                    .pressures
                    .map(|counts| SCALE.kpa(counts))
            })
            .collect()
    }

    fn sleep_until(&mut self, at_ns: u64) {
        use pneudrive_host::line::Line;
        self.polling.bus_mut().line_mut().sleep_until(at_ns);
    }

    fn silence(&mut self, ms: u64) {
        let now = self.polling.bus_mut().line().rig_now_ns();
        self.sleep_until(now + ms * MS);
    }
}

fn all_near(pressures: &[f64], kpa: f64) -> bool {
    pressures.iter().all(|pressure| (pressure - kpa).abs() < 4.2)
}

#[test]
fn four_boards_bring_sixteen_chambers_to_300_kpa_and_back() {
    let mut run = Run::start(4, &[], BusOptions::default(), 5);
    run.command(300.0);
    let vented = run.poll(1.4);
    assert!(all_near(&vented, 0.0), "power-up vent: {vented:?}");
    let filled = run.poll(2.4);
    assert_eq!(filled.len(), 16);
    assert!(all_near(&filled, 300.0), "{filled:?}");
    run.command(0.0);
    // The last kPa leave slowly: there is little pressure left to drive them.
    let empty = run.poll(4.0);
    assert!(all_near(&empty, 0.0), "{empty:?}");
    let statistics = run.polling.finish();
    assert_eq!((statistics.lost, statistics.rejected), (0, 0), "{statistics:?}");
    assert!(statistics.boards.iter().all(|board| board.frames == BoardFormat::Checked));
    assert_eq!(run.polling.bus_mut().line().counters().violations(), 0);
}

/// Half a second of patience, two seconds of holding, then all channels vent, although nobody says
/// so.
#[test]
fn a_host_that_dies_leaves_vented_chambers() {
    let mut run = Run::start(1, &[], BusOptions::default(), 5);
    run.command(300.0);
    let filled = run.poll(4.0);
    assert!(all_near(&filled, 300.0), "{filled:?}");
    run.silence(2_400);
    let held = run.measured();
    assert!(all_near(&held, 300.0), "held for two seconds: {held:?}");
    run.silence(4_000);
    let vented = run.measured();
    assert!(all_near(&vented, 0.0), "{vented:?}");
}

/// Original: 2 boards, set point 511 (0x01FF before the other's address 0xFFFE): failures 17 -> 479
/// of 4088.
#[test]
fn another_boards_words_that_end_in_ff_disturb_no_chip() {
    let options = BusOptions::default().formats(FormatPolicy::Unchecked);
    let mut run = Run::start(2, &[], options, 1);
    for board in 0..2 {
        run.points.set(board, [Counts::new(511).unwrap(); CHANNELS]).unwrap();
    }
    run.poll(2.044);
    let statistics = run.polling.finish();
    assert!(statistics.exchanges >= 4_088, "{statistics:?}");
    assert_eq!((statistics.lost, statistics.rejected), (0, 0), "{statistics:?}");
}

/// A lost byte or garbage costs the exchange it falls into, and the next ones are as good as
/// before.
#[test]
fn lost_bytes_and_garbage_cost_their_exchange_only() {
    for fault in ["drop=0.002,on=requests", "noise=20,ms=0.3"] {
        let mut run = Run::start(2, &[fault], BusOptions::default(), 2);
        run.poll(3.0);
        let struck = {
            let name = fault.split('=').next().unwrap();
            run.polling.bus_mut().line().counters().fault(name)
        };
        let statistics = run.polling.finish();
        assert!(struck >= 10, "{fault} struck {struck} times only");
        assert!(statistics.lost <= 2 * struck, "{fault} struck {struck} times: {statistics:?}");
        assert!(statistics.boards.iter().all(|board| board.state != BoardState::Missing), "{statistics:?}");
        assert!(statistics.boards.iter().all(|board| board.answered > 1_000), "{statistics:?}");
    }
}

#[test]
fn a_chip_that_lost_its_supply_boots_again() {
    let mut run = Run::start(2, &["power_cycle@1,board=1,ms=50"], BusOptions::default(), 5);
    run.poll(3.0);
    let statistics = run.polling.finish();
    assert_eq!(statistics.boards[0].lost, 0, "{statistics:?}");
    assert!(statistics.boards[1].lost > 0, "{statistics:?}");
    assert!(statistics.boards.iter().all(|board| board.state == BoardState::Present), "{statistics:?}");
}

/// For two minutes, or for as long as a [soak](crate::soak) is to last.
#[test]
fn minutes_with_every_exchange_answered() {
    let hours = std::env::var("PNEUDRIVE_SOAK_HOURS").map(|text| text.parse::<f64>().unwrap());
    let seconds = hours.map_or(120.0, |hours| 3_600.0 * hours);
    let mut run = Run::start(1, &[], BusOptions::default(), 20);
    run.command(150.0);
    let pressures = run.poll(seconds);
    assert!(all_near(&pressures, 150.0), "{pressures:?}");
    let statistics = run.polling.finish();
    assert!(statistics.exchanges as f64 >= 50.0 * seconds - 10.0, "{statistics:?}");
    assert_eq!((statistics.lost, statistics.rejected), (0, 0), "{statistics:?}");
}

/// Over a real pty, paced to the wall clock. The machine may be busy: the host is patient, and
/// nothing is timed.
#[test]
fn the_host_talks_to_chips_through_a_pty() {
    let sim =
        EmbeddedSim::start(&RigOptions { strict: false, ..chips(2, &[]) }, &PtyOptions::default()).unwrap();
    let options = BusOptions::default().answer_allowance(Duration::from_millis(10_000));
    let mut bus = Bus::open(sim.path(), options).unwrap();
    for board in [0, 1] {
        let mut tries = 0;
        while let Err(error) = bus.ping(board) {
            tries += 1;
            assert!(tries < 5, "{error}");
        }
        for _ in 0..50 {
            let answer = bus.exchange(board, [Counts::ATMOSPHERE; CHANNELS]).unwrap();
            assert!(all_near(&answer.pressures.map(|counts| SCALE.kpa(counts)), 0.0));
        }
    }
}
