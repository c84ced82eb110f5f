//! Days for people.

use std::time::{Duration, UNIX_EPOCH};

/// The day of a time, s since 1970, as in `2026-11-03`. Times before 1970 are its first day.
#[must_use]
pub fn day(unix_s: f64) -> String {
    let since = Duration::try_from_secs_f64(unix_s).unwrap_or_default();
    // The calendar ends in the year 9999.
    let last = Duration::from_secs(253_402_300_799);
    let text = humantime::format_rfc3339_seconds(UNIX_EPOCH + since.min(last)).to_string();
    text.get(..10).unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_is_the_one_in_greenwich() {
        assert_eq!(day(0.0), "1970-01-01");
        assert_eq!(day(1_793_664_000.0 + 86_399.0), "2026-11-03");
        assert_eq!((day(-5.0), day(1e300)), ("1970-01-01".to_owned(), "1970-01-01".to_owned()));
    }
}
