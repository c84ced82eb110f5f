//! The self-test of boards on virtual rigs: healthy ones, and ones with a hidden fault.

#![allow(
    clippy::unwrap_used,
    reason = "what tests are built on: a rig or bus that is not as the test says is a failure"
)]

use crate::virtual_bus::VirtualBus;
use pneudrive_host::Calibration;
use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::check::{BoardPlan, BoardReport, Plan, Report, SelfTest, Verdict};
use pneudrive_host::line::{Line, LineError};
use pneudrive_host::poller::{Pace, PollerOptions, Polling, SourceStatus};
use pneudrive_sim::plant::Effect;
use pneudrive_sim::rig::RigOptions;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::time::Duration;

/// Highest set point of the checks, kPa: the program's default.
pub const LEVEL_KPA: f64 = 150.0;
/// Cycles per second, Hz: the program's default.
pub const RATE_HZ: f64 = 500.0;

/// A rig as a laboratory has it: channels differ and the supply wanders (docs/plant.md,
/// "laboratory").
pub fn laboratory(seed: u64) -> RigOptions {
    let mut rig = RigOptions { seed, ..RigOptions::default() };
    rig.plant.nuisances.spread = 0.05;
    rig.plant.nuisances.supply_wander = 0.01;
    rig
}

/// The same rig with a fault, in the text form of docs/plant.md.
///
/// # Panics
/// The effect does not exist.
pub fn with_fault(mut rig: RigOptions, effect: &str) -> RigOptions {
    rig.effects.push(effect.parse::<Effect>().unwrap());
    rig
}

/// Board 0 of a rig, checked once `at_s` (0.5 or more) after it was switched on: other times have
/// other noise.
///
/// # Panics
/// The rig cannot be built.
pub fn check(rig: &RigOptions, at_s: f64, earlier: Option<&Report>) -> Report {
    check_on_busy(rig, at_s, earlier, Busy::default())
}

/// How often a host's program stands still.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Busy {
    /// Share of the exchanges before which it does.
    pub share: f64,
    /// For how long at the most, s; as often for any shorter time.
    pub longest_s: f64,
}

/// The same on a machine that is busy: the program stands still now and then, between looking at
/// the clock and sending.
///
/// # Panics
/// The rig cannot be built.
pub fn check_on_busy(rig: &RigOptions, at_s: f64, earlier: Option<&Report>, busy: Busy) -> Report {
    let mut built = rig.build().unwrap();
    built.run_until((at_s * 1e9) as u64);
    let line = BusyLine { line: VirtualBus::new(built), busy, random: Pcg64Mcg::seed_from_u64(rig.seed) };
    check_line(Bus::new(line, BusOptions::default()).unwrap(), earlier)
}

fn check_line<L: Line>(bus: Bus<L>, earlier: Option<&Report>) -> Report {
    let plan = Plan::new([LEVEL_KPA; 4], 1.0).unwrap();
    let calibration = Calibration::default();
    let (test, source, watch) = SelfTest::new(vec![BoardPlan { board: 0, index: 0, plan }], &calibration);
    let pace = Pace::every(Duration::from_nanos((1e9 / RATE_HZ) as u64));
    let options = PollerOptions::for_devices(1).pace(pace).reopen(None);
    let mut polling = Polling::new(bus, options, source, vec![watch]);
    loop {
        let due = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due);
        if polling.cycle().unwrap() == SourceStatus::Ended {
            break;
        }
    }
    let boards: Vec<BoardReport> = test.reports(earlier);
    Report {
        started_utc: "2026-11-03T00:00:00Z".to_owned(),
        port: "virtual".to_owned(),
        level_kpa: LEVEL_KPA,
        stretch: 1.0,
        baseline_utc: earlier.map(|earlier| earlier.started_utc.clone()),
        verdict: Report::worst(&boards),
        boards,
    }
}

/// A line whose host stands still now and then before it sends.
struct BusyLine {
    line: VirtualBus,
    busy: Busy,
    random: Pcg64Mcg,
}

impl Line for BusyLine {
    fn now_ns(&self) -> u64 {
        self.line.now_ns()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        if self.busy.share > 0.0 && self.random.random::<f64>() < self.busy.share {
            let for_s = self.busy.longest_s * self.random.random::<f64>();
            self.line.sleep_until(self.line.now_ns() + (for_s * 1e9) as u64);
        }
        self.line.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        self.line.receive(into, wanted, deadline_ns)
    }

    fn sleep_until(&mut self, at_ns: u64) {
        self.line.sleep_until(at_ns);
    }
}

/// Whether a check says that something is to be looked after.
pub fn alarms(report: &Report) -> bool {
    report.verdict >= Verdict::Warn
}
