//! Venting that holds until somebody releases it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// While it is closed, the poller commands 0 kPa to all boards, whatever its source says. Clones
/// are the same latch.
///
/// Closing it is one store and waits for nobody. The poller closes it by itself when a port that
/// was gone comes back: nobody may be at the rig any more.
#[derive(Debug, Clone, Default)]
pub struct VentLatch(Arc<AtomicU8>);

/// Somebody closed it.
const BY_HAND: u8 = 1;
/// The poller closed it.
const AFTER_OUTAGE: u8 = 2;

impl VentLatch {
    /// Commands 0 kPa to all boards from their next exchange on, until [`release`](Self::release).
    pub fn vent(&self) {
        self.0.fetch_or(BY_HAND, Ordering::Relaxed);
    }

    /// The same because the line was gone.
    pub(super) fn vent_after_outage(&self) {
        self.0.fetch_or(AFTER_OUTAGE, Ordering::Relaxed);
    }

    /// Ends it. The source is followed again; where it commands pressure, that returns by a ramp.
    pub fn release(&self) {
        // Release: who sees the latch open sees the set points that were changed before.
        self.0.store(0, Ordering::Release);
    }

    /// Whether the boards are vented.
    pub fn is_vented(&self) -> bool {
        self.0.load(Ordering::Acquire) != 0
    }

    /// Whether somebody vented them, and not only the poller after an outage.
    pub(super) fn by_hand(&self) -> bool {
        self.0.load(Ordering::Relaxed) & BY_HAND != 0
    }
}
