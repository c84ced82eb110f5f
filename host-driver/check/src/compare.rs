//! A value beside that of an earlier check.

use crate::{Quantity, Value, Verdict};

/// What is said of a change.
pub(crate) struct Change {
    /// From where on it does not pass.
    pub(crate) limits: (Option<f64>, Option<f64>),
    pub(crate) verdict: Verdict,
    pub(crate) note: String,
}

/// A change of less than so many standard errors is no change: a check makes 44 comparisons a
/// board, and a thousand checks are to pass.
const SIGNIFICANT: f64 = 6.0;
/// A change so many times as large as one that warns fails.
const FAILS: f64 = 4.0;
/// Standard errors to either side of a 95 % interval.
const NORMAL_95: f64 = 1.96;

/// Judges a change; `None` where there is nothing to compare with.
pub(crate) fn change(quantity: Quantity, value: f64, error: f64, earlier: &Value) -> Option<Change> {
    let before = earlier.value?;
    let error = error.hypot(earlier.interval? / NORMAL_95);
    let (tolerance, away, limits) = if quantity.is_factor() {
        // A rate of nothing is infinitely less.
        if !(before > 0.0) {
            return None;
        }
        let tolerance = quantity.tolerance().max(SIGNIFICANT * error / before);
        let away = if value > 0.0 { (value / before).ln().abs() } else { f64::INFINITY };
        (tolerance, away, (Some(before * (-tolerance).exp()), before * tolerance.exp()))
    } else {
        let tolerance = quantity.tolerance().max(SIGNIFICANT * error);
        // Of what cannot be negative only a lower limit above 0 says something.
        let from = Some(before - tolerance).filter(|&from| quantity.is_signed() || from > 0.0);
        (tolerance, (value - before).abs(), (from, before + tolerance))
    };
    let verdict = match away {
        // Written so that NaN fails.
        away if away <= tolerance => Verdict::Pass,
        away if away <= FAILS * tolerance => Verdict::Warn,
        _ => Verdict::Fail,
    };
    let note = if verdict == Verdict::Pass { String::new() } else { words(quantity, value, before) };
    Some(Change { limits: (limits.0, Some(limits.1)), verdict, note })
}

/// The change in words, without the channel and the date.
fn words(quantity: Quantity, value: f64, before: f64) -> String {
    let unit = quantity.unit();
    let factor = value / before;
    let decimals = unit.decimals;
    // A leak of next to nothing is no measure for another.
    if quantity == Quantity::Leak && before > 0.2 && factor >= 1.5 {
        return format!("leaks {factor:.1} times as much");
    }
    if quantity.is_factor() && factor > 0.0 {
        return format!("{:+.0} %", 100.0 * (factor - 1.0));
    }
    format!("{:+.decimals$} {}", value - before, unit.name)
}
