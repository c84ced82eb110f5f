use super::{FaultKind, FaultSpec, Passage, Path, When};
use crate::bus::BusCounters;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// An adapter's fault with its own random numbers, so that adding one fault does not change
/// another.
#[derive(Debug)]
pub(super) struct AdapterFault {
    spec: FaultSpec,
    rng: ChaCha8Rng,
    spent: bool,
}

impl AdapterFault {
    pub fn new(spec: FaultSpec, rng: ChaCha8Rng) -> Self {
        Self { spec, rng, spent: false }
    }

    /// Lets one character pass on `path`, or not.
    pub fn pass(&mut self, path: Path, now_ns: u64, passage: &mut Passage, counters: &mut BusCounters) {
        if passage.copies == 0 || !self.spec.path.covers(path) || !self.strikes(now_ns) {
            return;
        }
        match self.spec.kind {
            FaultKind::BitFlip => passage.byte ^= 1 << self.rng.random_range(0..8),
            FaultKind::Drop => passage.copies = 0,
            FaultKind::Duplicate => passage.copies += 1,
            FaultKind::Delay => passage.hold_ns += self.spec.duration_ns,
            _ => return,
        }
        counters.count_fault(self.spec.kind.name());
    }

    /// Whether it takes effect this time: by chance, or once from its time on.
    pub fn strikes(&mut self, now_ns: u64) -> bool {
        match self.spec.when {
            When::Rate(rate) => self.rng.random_bool(rate),
            When::At { time_ns } => {
                let due = !self.spent && now_ns >= time_ns;
                self.spent |= due;
                due
            }
        }
    }
}
