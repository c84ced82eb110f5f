//! The simulator's bus as a line of the host, in virtual time: same boards, plant and faults as
//! behind the pty, but no wall clock, so that results do not depend on the machine.

#![allow(
    clippy::unwrap_used,
    reason = "what tests are built on: a rig or bus that is not as the test says is a failure"
)]

use std::sync::{Arc, Mutex};

use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::line::{Line, LineError};
use pneudrive_host::poller::{PollerOptions, Polling, SetPoints};
use pneudrive_protocol::{Baud, Counts};
use pneudrive_sim::bus::BusCounters;
use pneudrive_sim::rig::RigOptions;

/// What of one exchange is lost on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lost {
    /// The request, all of it.
    Request,
    /// The answer, which the board has sent.
    Answer,
}

/// Loses something of exchanges to come, from wherever the bus is lent out.
#[derive(Debug, Clone, Default)]
pub struct LossPlan(Arc<Mutex<Option<Loss>>>);

#[derive(Debug, Clone, Copy)]
struct Loss {
    others: u32,
    count: u32,
    what: Lost,
}

impl LossPlan {
    /// Of the `count` exchanges that come after so many others.
    ///
    /// # Panics
    /// A thread has panicked with it.
    pub fn lose_after(&self, others: u32, count: u32, what: Lost) {
        *self.0.lock().unwrap() = Some(Loss { others, count, what });
    }

    /// Whether it has lost all that it was told to.
    ///
    /// # Panics
    /// A thread has panicked with it.
    pub fn is_done(&self) -> bool {
        self.0.lock().unwrap().is_none()
    }

    /// The next exchange begins.
    fn next_loss(&self) -> Option<Lost> {
        let mut waiting = self.0.lock().unwrap();
        let Loss { others, count, what } = waiting.take()?;
        if others > 0 {
            *waiting = Some(Loss { others: others - 1, count, what });
            return None;
        }
        if count > 1 {
            *waiting = Some(Loss { others, count: count - 1, what });
        }
        Some(what)
    }
}

/// Adapter, wire and boards, seen from the host.
pub struct VirtualBus {
    rig: pneudrive_sim::bus::Bus,
    /// Bytes that have come and were not asked for yet.
    received: Vec<u8>,
    /// Bytes that somebody else puts on the wire before everything that the host sends.
    before_each: Vec<u8>,
    losses_to_come: LossPlan,
    /// What comes until the host sends again does not reach it.
    discard_received: bool,
}

impl VirtualBus {
    /// The host's end of `rig`, as it stands.
    pub fn new(rig: pneudrive_sim::bus::Bus) -> Self {
        Self {
            rig,
            received: Vec::new(),
            before_each: Vec::new(),
            losses_to_come: LossPlan::default(),
            discard_received: false,
        }
    }

    /// From now on somebody else puts `bytes` on the wire before everything that the host sends.
    pub fn before_each_request(&mut self, bytes: &[u8]) {
        self.before_each = bytes.to_vec();
    }

    /// Loses an exchange to come.
    pub fn losses_to_come(&self) -> LossPlan {
        self.losses_to_come.clone()
    }

    /// What has happened on the wire.
    pub fn counters(&self) -> &BusCounters {
        self.rig.counters()
    }

    /// Nothing happens on the host's side until `at_s`.
    pub fn sleep_until_s(&mut self, at_s: f64) {
        self.sleep_until((at_s * 1e9) as u64);
    }

    /// Virtual time, ns.
    pub fn rig_now_ns(&self) -> u64 {
        self.rig.now_ns()
    }

    fn take(&mut self) {
        while let Some(byte) = self.rig.receive() {
            if !self.discard_received {
                self.received.push(byte.byte);
            }
        }
    }
}

impl std::fmt::Debug for VirtualBus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "VirtualBus at {} ns", self.rig.now_ns())
    }
}

impl Line for VirtualBus {
    fn now_ns(&self) -> u64 {
        self.rig.now_ns()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        // What came before was received.
        self.take();
        let lost = self.losses_to_come.next_loss();
        self.discard_received = lost == Some(Lost::Answer);
        if lost == Some(Lost::Request) {
            return Ok(());
        }
        self.rig.send(self.rig.now_ns(), &self.before_each);
        self.rig.send(self.rig.now_ns(), bytes);
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        self.take();
        while self.received.len() < wanted.min(into.len()) && self.rig.now_ns() < deadline_ns {
            // Events may cost no time; a character time is the coarsest step that misses none.
            let step = self.rig.now_ns() + self.rig.line().character_ns();
            self.rig.run_until(self.rig.next_event_ns().clamp(self.rig.now_ns() + 1, step).min(deadline_ns));
            self.take();
        }
        let count = self.received.len().min(into.len());
        into[..count].copy_from_slice(&self.received[..count]);
        self.received.drain(..count);
        Ok(count)
    }

    fn sleep_until(&mut self, at_ns: u64) {
        if at_ns > self.rig.now_ns() {
            self.rig.run_until(at_ns);
        }
    }

    fn change_baud(&mut self, baud: Baud) -> Result<bool, LineError> {
        self.rig.set_host_baud(Some(baud));
        self.received.clear();
        Ok(true)
    }
}

/// Host and boards, run for half a second: the boards have booted, and vent for the rest of their
/// first two seconds.
///
/// # Panics
/// The rig cannot be built, or the host does not find the bus quiet.
pub fn bus(rig: &RigOptions, options: BusOptions) -> Bus<VirtualBus> {
    let mut rig = rig.build().unwrap();
    rig.run_until(500_000_000);
    Bus::new(VirtualBus::new(rig), options).unwrap()
}

/// Polls for `seconds` of virtual time, commanding `counts` on all channels.
///
/// # Panics
/// `counts` is above 1023, or the line failed, which a virtual one does not.
pub fn poll(bus: Bus<VirtualBus>, boards: u16, counts: u16, seconds: f64) -> Polling<VirtualBus> {
    let points = SetPoints::new(usize::from(boards));
    for board in 0..usize::from(boards) {
        points.set(board, [Counts::new(counts).unwrap(); 4]).unwrap();
    }
    let mut polling = Polling::new(bus, PollerOptions::for_devices(boards), Box::new(points), Vec::new());
    let end = polling.bus_mut().line().now_ns() + (seconds * 1e9) as u64;
    while polling.bus_mut().line().now_ns() < end {
        let due = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due);
        polling.cycle().unwrap();
    }
    polling
}
