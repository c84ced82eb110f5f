//! A serial port whose long waits can be ended by Ctrl-C.

use super::ending::{LOOK_EVERY, Signals};
use parking_lot::Mutex;
use pneudrive_host::line::{Line, LineError, OpenError, SerialPort};
use pneudrive_protocol::Baud;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const SLICE_NS: u64 = LOOK_EVERY.as_millis() as u64 * 1_000_000;

/// What a signal's handler raised while the line waited, and whether waiting is over for all.
/// Clones are the same place.
#[derive(Debug, Clone, Default)]
pub struct Interrupt {
    raised: Arc<Mutex<Option<PyErr>>>,
    closing: Arc<AtomicBool>,
}

impl Interrupt {
    /// Ends all waiting by hand, in whichever thread.
    pub fn close(&self) {
        self.closing.store(true, Ordering::Relaxed);
    }

    /// Whether it was ended.
    pub fn is_closing(&self) -> bool {
        self.closing.load(Ordering::Relaxed)
    }

    /// What was raised, once.
    pub fn take(&self) -> Option<PyErr> {
        self.raised.lock().take()
    }
}

/// Waits in slices, between which signals are looked for. An exchange that is ended so fails as if
/// the line had failed; what was raised is then in the [`Interrupt`].
#[derive(Debug)]
pub struct Interruptible {
    port: SerialPort,
    interrupt: Interrupt,
    signals: Signals,
}

impl Interruptible {
    /// Looks for signals until told otherwise.
    pub fn new(port: SerialPort, interrupt: Interrupt) -> Self {
        Self { port, interrupt, signals: Signals::Handled }
    }

    /// From now on waits without looking: for a thread that must not wait for the interpreter, and
    /// for venting, which is not to be interrupted.
    pub fn leave_signals(&mut self) {
        self.signals = Signals::Left;
    }

    fn look(&self) -> Result<(), LineError> {
        let interrupted = || {
            let port = self.port.path().to_owned();
            LineError::System { port, what: "waiting", reason: "interrupted".to_owned() }
        };
        if self.signals == Signals::Handled && self.interrupt.is_closing() {
            return Err(interrupted());
        }
        self.signals.look().map_err(|raised| {
            *self.interrupt.raised.lock() = Some(raised);
            interrupted()
        })
    }
}

impl Line for Interruptible {
    fn now_ns(&self) -> u64 {
        self.port.now_ns()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.port.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        let wanted = wanted.min(into.len());
        let mut have = 0;
        loop {
            let slice_ns = deadline_ns.min(self.port.now_ns().saturating_add(SLICE_NS));
            have += self.port.receive(&mut into[have..], wanted.saturating_sub(have), slice_ns)?;
            if have >= wanted || slice_ns == deadline_ns {
                return Ok(have);
            }
            self.look()?;
        }
    }

    fn sleep_until(&mut self, at_ns: u64) {
        self.port.sleep_until(at_ns);
    }

    fn expect_bytes(&mut self, count: usize) {
        self.port.expect_bytes(count);
    }

    fn expect_answer_at(&mut self, at_ns: u64) {
        self.port.expect_answer_at(at_ns);
    }

    fn change_baud(&mut self, baud: Baud) -> Result<bool, LineError> {
        self.port.change_baud(baud)
    }

    fn can_reopen(&self) -> bool {
        self.port.can_reopen()
    }

    fn reopen(&mut self) -> Result<(), OpenError> {
        self.port.reopen()
    }

    fn random(&mut self) -> u32 {
        self.port.random()
    }

    fn cpu_time_ns(&self) -> u64 {
        self.port.cpu_time_ns()
    }
}
