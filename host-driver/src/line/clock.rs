use rustix::thread::ClockId;
use rustix::time::{Timespec, clock_gettime};

/// The clock of a [`SerialPort`](super::SerialPort), CLOCK_MONOTONIC, for other threads to tell a
/// reading's age by. Setting the system's time does not touch it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Clock;

impl Clock {
    /// Now, ns.
    pub fn now_ns(self) -> u64 {
        nanoseconds(clock_gettime(ClockId::Monotonic))
    }

    /// CPU time that the calling thread has used so far, ns.
    pub(super) fn cpu_time_ns(self) -> u64 {
        nanoseconds(clock_gettime(ClockId::ThreadCPUTime))
    }
}

pub(super) fn timespec(ns: u64) -> Timespec {
    // Both quotients fit: u64 ns are 584 years.
    Timespec { tv_sec: (ns / 1_000_000_000) as i64, tv_nsec: (ns % 1_000_000_000) as i64 }
}

fn nanoseconds(time: Timespec) -> u64 {
    // These clocks start at 0 and are never negative.
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
