//! A line that is gone, until it is back. Times are ns on the line's clock, which goes on.

use crate::bus::{Bus, OpenBusError};
use crate::line::Line;
use crate::time::saturating_ns;
use std::time::Duration;

/// What to do when the line fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReopenPolicy {
    /// Time between two tries to open it again; less than 1 ms counts as 1 ms. Meanwhile there
    /// is a row without fresh readings for each try.
    pub every: Duration,
}

impl Default for ReopenPolicy {
    /// A USB adapter needs about a second to be ready again; trying costs less than a millisecond.
    fn default() -> Self {
        Self { every: Duration::from_millis(250) }
    }
}

/// Trying all the time would be a busy-wait, ns.
const SHORTEST_NS: u64 = 1_000_000;

#[derive(Debug)]
pub(super) struct Outage {
    every_ns: u64,
    since_ns: u64,
    next_try_ns: u64,
    reason: String,
}

/// How a try to open the line again ended.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Try {
    /// It is back.
    Back {
        /// How long it was gone.
        gone: Duration,
    },
    /// It is not, for another reason than last time.
    Refused(OpenBusError),
    /// It is not.
    NotYet,
}

impl Outage {
    pub(super) fn new(policy: ReopenPolicy, now_ns: u64) -> Self {
        let every_ns = saturating_ns(policy.every).max(SHORTEST_NS);
        Self { every_ns, since_ns: now_ns, next_try_ns: now_ns + every_ns, reason: String::new() }
    }

    pub(super) fn next_try_ns(&self) -> u64 {
        self.next_try_ns
    }

    pub(super) fn attempt<L: Line>(&mut self, bus: &mut Bus<L>) -> Try {
        let result = bus.reopen();
        let now_ns = bus.line().now_ns();
        self.next_try_ns = now_ns + self.every_ns;
        match result {
            Ok(()) => Try::Back { gone: Duration::from_nanos(now_ns.saturating_sub(self.since_ns)) },
            Err(error) => {
                let reason = error.to_string();
                if std::mem::replace(&mut self.reason, reason.clone()) == reason {
                    Try::NotYet
                } else {
                    Try::Refused(error)
                }
            }
        }
    }
}
