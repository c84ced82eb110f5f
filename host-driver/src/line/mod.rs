//! Bytes and time: what the bus needs from whatever carries it.

mod backoff;
mod clock;
mod error;
mod low_latency;
mod name;
mod open;
mod ports;
mod serial;
mod spin;
mod wait_strategy;

pub use clock::Clock;
pub use error::{LineError, OpenError};
pub use ports::{PortInfo, ports};
pub use serial::{SerialOptions, SerialPort};
pub use spin::Spin;

use pneudrive_protocol::Baud;

/// A half-duplex byte line with a clock.
///
/// Times are ns on a clock of the line's own that never goes back; deadlines belong to the line, so
/// that the same bus runs on a serial port and, in tests, in virtual time.
pub trait Line {
    /// Now, ns.
    fn now_ns(&self) -> u64;

    /// Hands `bytes` over to be sent back to back. Returns when they are handed over, not when they
    /// are sent.
    ///
    /// # Errors
    /// The line is gone or the device failed.
    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError>;

    /// Waits for bytes: until `wanted` of them are there, or until `deadline_ns`.
    ///
    /// Returns how many were put into `into` (which may be more than `wanted`). Bytes that are
    /// there when the deadline has passed are returned all the same, so nothing that arrived is
    /// reported missing for lack of a look. A deadline in the past means: what is there now.
    ///
    /// # Errors
    /// The line is gone or the device failed.
    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError>;

    /// Sleeps until `at_ns`.
    fn sleep_until(&mut self, at_ns: u64);

    /// From now on, most answers have this many bytes: a line that can wake the host once instead
    /// of once a byte may use it. Only a hint.
    fn expect_bytes(&mut self, count: usize) {
        let _ = count;
    }

    /// The next bytes are due at `at_ns`, not earlier: a line that would rather not be woken for
    /// them may use it. Only a hint.
    fn expect_answer_at(&mut self, at_ns: u64) {
        let _ = at_ns;
    }

    /// From now on the line sends and listens at `baud`, and what came before is discarded. False
    /// if it cannot do that rate, or no other than its own; then it is as it was. Nothing may be on
    /// its way.
    ///
    /// # Errors
    /// The line is gone or the device failed.
    fn change_baud(&mut self, baud: Baud) -> Result<bool, LineError> {
        let _ = baud;
        Ok(false)
    }

    /// Whether [`reopen`](Self::reopen) can ever succeed.
    fn can_reopen(&self) -> bool {
        false
    }

    /// After a failure: lets go of what failed and tries once to open the line again by its name.
    /// Does not wait for it to come back.
    ///
    /// # Errors
    /// It is not there, not usable, or has no name.
    fn reopen(&mut self) -> Result<(), OpenError> {
        Err(OpenError::NoName)
    }

    /// A number for a host's sessions: another one whenever a program is started, so that boards do
    /// not give a session number twice. By default it comes from the line's clock, so that runs in
    /// virtual time are the same every time.
    fn random(&mut self) -> u32 {
        (self.now_ns() / 1_000) as u32
    }

    /// CPU time that the calling thread has used so far, ns; 0 where time is virtual.
    fn cpu_time_ns(&self) -> u64 {
        0
    }
}
