//! The time of day.

use std::time::{SystemTime, UNIX_EPOCH};

/// ns since 1970.
pub fn unix_now_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}
