use std::time::{Duration, Instant};

/// Virtual time by the wall clock, ns.
///
/// When the simulator could not keep up (the machine was busy, or it was stopped), virtual time
/// stands still for that long instead of being made up for in a rush: boards would take the rush
/// for a host that fell silent.
#[derive(Debug)]
pub(super) struct PacedClock {
    start: Instant,
    start_ns: u64,
    slipped_ns: u64,
}

impl PacedClock {
    /// A clock that shows `now_ns` and runs.
    pub fn start_at(now_ns: u64) -> Self {
        Self { start: Instant::now(), start_ns: now_ns, slipped_ns: 0 }
    }

    pub fn now_ns(&self) -> u64 {
        self.start_ns + saturating_ns(self.start.elapsed()).saturating_sub(self.slipped_ns)
    }

    /// Lets virtual time stand still for `by_ns`.
    pub fn slip(&mut self, by_ns: u64) {
        self.slipped_ns += by_ns;
    }
}

pub(super) fn saturating_ns(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
