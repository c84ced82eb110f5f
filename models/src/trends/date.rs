//! Days and hours for people.

use std::time::{Duration, UNIX_EPOCH};

/// How times of recordings are said: those of some minutes are not told apart by their days.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeScale {
    /// Over two days and more.
    Days,
    /// Within two days.
    Hours,
    /// Within two hours.
    Minutes,
}

impl TimeScale {
    /// The one for times, s since 1970; days when there are none.
    #[must_use]
    pub fn of(times_unix_s: impl Iterator<Item = f64> + Clone) -> Self {
        let first = times_unix_s.clone().fold(f64::INFINITY, f64::min);
        let last = times_unix_s.fold(f64::NEG_INFINITY, f64::max);
        match last - first {
            span_s if !span_s.is_finite() || span_s > 2.0 * Self::Days.seconds() => Self::Days,
            span_s if span_s > 2.0 * Self::Hours.seconds() => Self::Hours,
            _ => Self::Minutes,
        }
    }

    /// Its unit's name, as in `days`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Days => "days",
            Self::Hours => "hours",
            Self::Minutes => "minutes",
        }
    }

    /// Its unit, s.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            Self::Days => 86_400.0,
            Self::Hours => 3600.0,
            Self::Minutes => 60.0,
        }
    }

    /// A time, s since 1970: as in `2026-11-03`, `2026-11-03 14:05 UTC` or
    /// `2026-11-03 14:05:09 UTC`. Times before 1970 are its first second.
    #[must_use]
    pub fn said(self, unix_s: f64) -> String {
        let text = rfc3339(unix_s);
        match (self, text.get(..10), text.get(11..16), text.get(11..19)) {
            (Self::Hours, Some(day), Some(minute), _) => format!("{day} {minute} UTC"),
            (Self::Minutes, Some(day), _, Some(second)) => format!("{day} {second} UTC"),
            (_, day, ..) => day.unwrap_or_default().to_owned(),
        }
    }
}

fn rfc3339(unix_s: f64) -> String {
    let since = Duration::try_from_secs_f64(unix_s).unwrap_or_default();
    // The calendar ends in the year 9999.
    let last = Duration::from_secs(253_402_300_799);
    humantime::format_rfc3339_seconds(UNIX_EPOCH + since.min(last)).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_is_the_one_in_greenwich() {
        let day = |unix_s| TimeScale::Days.said(unix_s);
        assert_eq!(day(0.0), "1970-01-01");
        assert_eq!(day(1_793_664_000.0 + 86_399.0), "2026-11-03");
        assert_eq!((day(-5.0), day(1e300)), ("1970-01-01".to_owned(), "1970-01-01".to_owned()));
    }

    #[test]
    fn recordings_of_one_morning_are_told_apart_by_their_time() {
        let within = |span_s: f64| TimeScale::of([1_793_664_000.0, 1_793_664_000.0 + span_s].into_iter());
        let scales = [30.0, 7200.0, 7201.0, 172_800.0, 172_801.0].map(within);
        use TimeScale::{Days, Hours, Minutes};
        assert_eq!(scales, [Minutes, Minutes, Hours, Hours, Days]);
        assert_eq!(TimeScale::of([].into_iter()), Days);
        assert_eq!(Hours.said(1_793_664_000.0 + 50_709.0), "2026-11-03 14:05 UTC");
        assert_eq!(Minutes.said(1_793_664_000.0 + 50_709.0), "2026-11-03 14:05:09 UTC");
    }
}
