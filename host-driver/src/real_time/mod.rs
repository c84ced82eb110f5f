//! What a thread can ask of Linux so that others disturb it less: SCHED_FIFO, locked memory, a
//! core.
//!
//! Each of them is refused rather than left out where it cannot be had: who asks for real time
//! wants to know. What each is good for:
//!
//! - **SCHED_FIFO**: the thread runs before everything without a real-time priority. The kernel
//!   keeps 5 % of each core for the others (sched(7), `sched_rt_runtime_us`), so that a thread that
//!   spins does not freeze the machine.
//! - **Locked memory**: no page of the process is read from disk in the middle of a cycle. It is of
//!   the whole process.
//! - **A core**: the thread is not moved. It does not keep others off that core; `isolcpus` on the
//!   kernel's command line does.

mod error;

pub use error::RealTimeError;

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// What is asked for. The default is nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct RealTime {
    /// Priority under SCHED_FIFO, 1 to 99. Interrupt threads of a PREEMPT_RT kernel have 50.
    pub priority: Option<u8>,
    /// Whether the memory of the process is locked, what it has and what it will get.
    pub lock_memory: bool,
    /// The core to stay on, counted from 0.
    pub core: Option<usize>,
}

impl RealTime {
    /// Priority if none is named: below the interrupt threads of a PREEMPT_RT kernel, which the
    /// serial port needs.
    pub const PRIORITY: u8 = 40;

    /// Priority under SCHED_FIFO, 1 to 99.
    #[must_use]
    pub fn priority(self, priority: impl Into<Option<u8>>) -> Self {
        Self { priority: priority.into(), ..self }
    }

    /// Whether the memory of the process is locked.
    #[must_use]
    pub fn lock_memory(self, lock_memory: bool) -> Self {
        Self { lock_memory, ..self }
    }

    /// The core to stay on, counted from 0.
    #[must_use]
    pub fn core(self, core: impl Into<Option<usize>>) -> Self {
        Self { core: core.into(), ..self }
    }

    /// Gives it to the calling thread (memory: to the process).
    ///
    /// # Errors
    /// The first thing that cannot be had; see [`RealTimeError`].
    pub fn apply(self) -> Result<(), RealTimeError> {
        if self.lock_memory {
            mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).map_err(RealTimeError::memory)?;
        }
        if let Some(core) = self.core {
            pin(core)?;
        }
        if let Some(priority) = self.priority {
            schedule(priority)?;
        }
        Ok(())
    }

    /// Finds out on a thread of its own whether it can be had, so that it is known before anything
    /// moves. Memory stays locked.
    ///
    /// # Errors
    /// As for [`apply`](Self::apply).
    pub fn check(self) -> Result<(), RealTimeError> {
        if self == Self::default() {
            return Ok(());
        }
        let tried = std::thread::Builder::new().spawn(move || self.apply());
        let tried =
            tried.map_err(|error| RealTimeError::System { what: "a thread", reason: error.to_string() })?;
        tried.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

fn pin(core: usize) -> Result<(), RealTimeError> {
    let allowed = sched_getaffinity(None).map_err(|errno| RealTimeError::system("the cores", errno))?;
    let cores: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&core| allowed.is_set(core)).collect();
    if !cores.contains(&core) {
        return Err(RealTimeError::NoSuchCore { core, cores });
    }
    let mut only = CpuSet::new();
    only.set(core);
    sched_setaffinity(None, &only).map_err(|errno| RealTimeError::system("the core", errno))
}

fn schedule(priority: u8) -> Result<(), RealTimeError> {
    let refused = |source| RealTimeError::priority(priority, &source);
    let value =
        ThreadPriorityValue::try_from(priority).map_err(|_| RealTimeError::NoSuchPriority { priority })?;
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(value), fifo)
        .map_err(refused)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_asked_for_is_nothing_done() {
        RealTime::default().apply().unwrap();
        RealTime::default().check().unwrap();
    }

    #[test]
    fn a_core_is_kept() {
        let allowed = sched_getaffinity(None).unwrap();
        let core = (0..CpuSet::MAX_CPU).find(|&core| allowed.is_set(core)).unwrap();
        let pinned = std::thread::spawn(move || {
            RealTime::default().core(core).apply().unwrap();
            sched_getaffinity(None).unwrap()
        });
        let pinned = pinned.join().unwrap();
        assert_eq!((pinned.count(), pinned.is_set(core)), (1, true));
        assert_eq!(sched_getaffinity(None).unwrap().count(), allowed.count(), "other threads are not pinned");
    }

    #[test]
    fn what_does_not_exist_is_refused_by_name() {
        let refused = RealTime::default().core(CpuSet::MAX_CPU + 1).check().unwrap_err();
        assert!(matches!(refused, RealTimeError::NoSuchCore { .. }), "{refused}");
        for priority in [0, 100] {
            let asked = RealTime::default().priority(priority);
            assert_eq!(asked.check(), Err(RealTimeError::NoSuchPriority { priority }));
        }
    }
}
