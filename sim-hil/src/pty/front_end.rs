use super::clock::{PacedClock, saturating_ns};
use super::output_fifo::OutputFifo;
use super::port::{VirtualPort, Wake};
use super::step_cost::StepCost;
use super::{PaceReport, RequestBackdating, SimError, SimReport, measure_round_trip_ns};
use crate::bus::Bus;
use crate::rig::{RigOptions, Timing};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// How a rig stands behind a pty.
#[derive(Debug, Clone, PartialEq)]
pub struct PtyOptions {
    /// A symbolic link to make to the port, removed at the end.
    pub link: Option<PathBuf>,
    /// What requests are dated back by, at most 80 % of a packet's time; `None` measures it at
    /// start.
    pub pty_latency: Option<Duration>,
    /// Whether requests are dated back at all: `false` puts each on the wire when it is seen, as a
    /// plain responder would. Then a client pays for the pty's detour and for the simulator's own
    /// delay. Default true.
    pub dates_back: bool,
    /// For so long it is waited in a loop instead of asleep before an answer is due, and after it
    /// for the next request: 0 to 1 ms. Default 20 us.
    pub spin: Duration,
    /// Bytes that are handed over together at most: 1 to 4096. Default 16, so a packet comes in one
    /// piece.
    pub fifo: usize,
    /// The boards have been on for as long as they vent after power-up: who opens the port finds
    /// them as on a rig that was switched on before. Emulated chips take as long for it as they
    /// take otherwise. Default false: power-up is when the rig is built.
    pub past_power_up: bool,
}

impl Default for PtyOptions {
    fn default() -> Self {
        Self {
            link: None,
            pty_latency: None,
            dates_back: true,
            spin: Duration::from_micros(20),
            fifo: 16,
            past_power_up: false,
        }
    }
}

/// A rig behind a pty: the bus of [`RigOptions`], paced to the wall clock.
pub struct FrontEnd {
    bus: Bus,
    port: VirtualPort,
    timing: Timing,
    stretch_ns: u64,
    dating: RequestBackdating,
    spin_ns: u64,
    output: OutputFifo,
    clock: PacedClock,
    quiet_since_ns: u64,
    step_cost: StepCost,
    client_present: bool,
    report: PaceReport,
}

/// Emulated chips take nearly as long as they simulate: while something is on the wire they are run
/// in stretches of this, ns, so that little is left to do when an answer is due. Native boards are
/// simulated in no time.
const CHIP_STRETCH_NS: u64 = 20_000;
/// Longest sleep: how long a request to stop may go unnoticed, ns.
const NAP_NS: u64 = 5_000_000;
/// Without a client there is nothing to wait for but the next client, ns.
const NO_CLIENT_NAP: Duration = Duration::from_millis(2);
/// Further behind than this, virtual time slips, ns.
const BEHIND_MAX_NS: u64 = 20_000_000;
/// The plant works ahead while a run of characters is under way, and on a bus that has been quiet
/// for this long, ns: between two exchanges of a busy bus a client's next request comes first.
const WORK_AFTER_QUIET_NS: u64 = 300_000;
/// Longer than this nothing is waited for in a loop.
const LONGEST_SPIN: Duration = Duration::from_millis(1);
/// How far ahead of the wall clock an exchange that takes no time may be simulated, ns.
const INSTANT_AHEAD_NS: u64 = 1_000;

impl FrontEnd {
    /// Builds the rig and opens its port; the clock starts with [`FrontEnd::run`].
    ///
    /// # Errors
    /// The rig cannot be built, or the system gives no port.
    pub fn new(rig: &RigOptions, options: &PtyOptions) -> Result<Self, SimError> {
        let mut bus = rig.build()?;
        if options.past_power_up {
            bus.run_until(rig.follow_after_ns());
        }
        let dates_back = options.dates_back && rig.timing == Timing::Wire;
        let round_trip_ns = match options.pty_latency {
            _ if !dates_back => 0,
            Some(latency) => saturating_ns(latency),
            None => measure_round_trip_ns(!options.spin.is_zero())?,
        };
        // An answer must still be under way when the request before it has been dated back.
        let limit_ns = if dates_back { bus.line().characters_ns(8) } else { 0 };
        let dating = RequestBackdating { round_trip_ns: round_trip_ns.min(limit_ns), limit_ns };
        Ok(Self {
            bus,
            port: VirtualPort::open(options.link.as_deref())?,
            timing: rig.timing,
            stretch_ns: if rig.firmware.is_some() { CHIP_STRETCH_NS } else { u64::MAX },
            dating,
            spin_ns: saturating_ns(options.spin.min(LONGEST_SPIN)),
            output: OutputFifo::new(options.fifo.clamp(1, 4096)),
            clock: PacedClock::start_at(0),
            quiet_since_ns: 0,
            step_cost: StepCost::default(),
            client_present: false,
            report: PaceReport::default(),
        })
    }

    /// What requests are dated back by.
    pub(super) fn round_trip(&self) -> Duration {
        Duration::from_nanos(self.dating.round_trip_ns)
    }

    /// The path that clients open.
    pub fn path(&self) -> &Path {
        self.port.path()
    }

    /// Lets time run until `stop` is set, or for `duration` of virtual time. Between two calls time
    /// stands still.
    ///
    /// # Errors
    /// The pty failed.
    pub fn run(&mut self, stop: &AtomicBool, duration: Option<Duration>) -> Result<(), SimError> {
        // The default slack of 50 us is more than half a packet.
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        let start_ns = self.bus.now_ns();
        self.clock = PacedClock::start_at(start_ns);
        let end_ns = duration.map_or(u64::MAX, |length| start_ns.saturating_add(saturating_ns(length)));
        while !stop.load(Ordering::Relaxed) && self.bus.now_ns() < end_ns {
            self.catch_up();
            let clock = &self.clock;
            self.output.step(&mut self.bus, &self.port, &mut self.report, || clock.now_ns())?;
            self.wait()?;
        }
        Ok(())
    }

    /// What happened up to now.
    pub fn report(&self) -> SimReport {
        let mut pace = self.report.clone();
        pace.virtual_s = self.bus.now_ns() as f64 / 1e9;
        pace.pty_round_trip_us = self.dating.round_trip_ns as f64 / 1e3;
        SimReport { bus: self.bus.counters().clone(), pace }
    }

    /// Brings virtual time up to the wall clock, or as far as a request under way allows.
    fn catch_up(&mut self) {
        let now_ns = self.clock.now_ns();
        let behind_ns = now_ns.saturating_sub(self.bus.now_ns());
        if behind_ns > BEHIND_MAX_NS {
            self.clock.slip(behind_ns - BEHIND_MAX_NS);
            self.report.slipped_ms += (behind_ns - BEHIND_MAX_NS) as f64 / 1e6;
        }
        let now_ns = self.clock.now_ns();
        self.bus.run_until(self.horizon_ns(now_ns));
        if !self.bus.is_quiet() {
            // What was dated back, or has begun in the meantime, is history up to now.
            self.bus.run_until(self.horizon_ns(now_ns));
            self.quiet_since_ns = now_ns;
        }
    }

    fn horizon_ns(&self, now_ns: u64) -> u64 {
        match (self.bus.is_quiet(), self.timing) {
            (true, _) => self.dating.quiet_horizon_ns(now_ns, self.output.last()),
            (false, Timing::Wire) => now_ns,
            (false, Timing::Instant) => now_ns + INSTANT_AHEAD_NS,
        }
    }

    /// The virtual time at which there is something to do, and whether it must be met closely.
    fn next_deadline_ns(&self) -> (u64, bool) {
        let held_back_ns = self.bus.held_back_until_ns().unwrap_or(u64::MAX);
        match self.bus.run_ends_at_ns() {
            Some(ends_ns) => {
                let stretch_ns = self.bus.now_ns().saturating_add(self.stretch_ns);
                (ends_ns.min(held_back_ns).min(stretch_ns), true)
            }
            None => {
                let next_ns = self.bus.next_event_ns().saturating_add(self.dating.round_trip_ns);
                (next_ns.min(held_back_ns), held_back_ns < next_ns)
            }
        }
    }

    fn wait(&mut self) -> Result<(), SimError> {
        if !self.client_present {
            thread::sleep(NO_CLIENT_NAP);
        }
        if self.bus.is_quiet() && self.output.last().at_ns > 0 {
            let until_ns = self.output.last().at_ns + self.spin_ns;
            while self.clock.now_ns() < until_ns {
                if self.look(0)? {
                    return Ok(());
                }
            }
        }
        let (deadline_ns, close) = self.next_deadline_ns();
        let spin_ns = if close { self.spin_ns } else { 0 };
        loop {
            let now_ns = self.clock.now_ns();
            let left_ns = deadline_ns.saturating_sub(now_ns);
            let may_work = close || now_ns.saturating_sub(self.quiet_since_ns) > WORK_AFTER_QUIET_NS;
            let worked = may_work && self.step_cost.fits(left_ns) && self.work_ahead(now_ns);
            let sleep_ns = if worked { 0 } else { left_ns.saturating_sub(spin_ns).min(NAP_NS) };
            if self.look(sleep_ns)? {
                return Ok(());
            }
            if worked {
                continue;
            }
            if left_ns <= spin_ns {
                while self.clock.now_ns() < deadline_ns {
                    std::hint::spin_loop();
                }
            }
            return Ok(());
        }
    }

    /// A part of the plant's work; says whether any is left.
    fn work_ahead(&mut self, now_ns: u64) -> bool {
        let more = self.bus.work_ahead();
        self.step_cost.took(self.clock.now_ns().saturating_sub(now_ns));
        more
    }

    /// Waits for the client's bytes for `timeout_ns`; says whether there is something new.
    fn look(&mut self, timeout_ns: u64) -> Result<bool, SimError> {
        match self.port.wait(timeout_ns).map_err(SimError::pty("wait for"))? {
            Wake::Bytes => self.take_bytes()?,
            Wake::NoClient => self.client_gone()?,
            Wake::Timeout => {
                self.client_present = true;
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn take_bytes(&mut self) -> Result<(), SimError> {
        let seen_ns = self.clock.now_ns();
        let mut buffer = [0; 4096];
        match self.port.read(&mut buffer).map_err(SimError::pty("read from"))? {
            Some(count) => {
                self.client_present = true;
                self.bus.set_host_baud(self.port.raised_baud().map_err(SimError::pty("look at"))?);
                let start_ns = self.dating.start_ns(seen_ns, self.output.last(), self.bus.now_ns());
                self.bus.send(start_ns, &buffer[..count]);
                Ok(())
            }
            None => self.client_gone(),
        }
    }

    fn client_gone(&mut self) -> Result<(), SimError> {
        if self.client_present {
            self.client_present = false;
            self.report.clients_gone += 1;
            self.port.forget_unread().map_err(SimError::pty("reset"))?;
        }
        self.output.forget();
        Ok(())
    }
}
