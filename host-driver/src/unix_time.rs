//! Stamps for others: what the times of the line are on the calendar.
//!
//! Apart from the modules between wire and rows, none of which asks for the system's time: setting
//! it must not touch the bus.

use std::time::SystemTime;

use crate::line::Clock;

impl Clock {
    /// What to add to a time of this clock to get ns since 1970-01-01 UTC. It changes when the
    /// system's time is set.
    pub fn unix_offset_ns(self) -> u64 {
        // The system's clock counts from 1970, this one from the last start of the machine: the
        // difference is positive. A clock that has never been set counts as 1970.
        let since_1970 = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        // u64 ns are 584 years.
        (since_1970.as_nanos() as u64).saturating_sub(self.now_ns())
    }
}
