//! Whether values are well: for themselves, beside the other channels, and beside an earlier check.

use crate::compare::{Change, change};
use crate::measure::Measured;
use crate::quantity::Limits;
use crate::{BoardReport, Missing, Quantity, Value, Verdict};

/// Standard errors to either side of a 95 % interval.
const NORMAL_95: f64 = 1.96;

/// Judges what was measured of a board; `before` is the same board in an earlier check, if there
/// was one.
///
/// For itself each value has limits that any rig should keep. Beside an earlier check it may differ
/// by as much as its noise allows and rigs differ from day to day; `docs/check.md` has all numbers.
pub fn judge(board: u8, measured: Vec<Measured>, before: Option<&BoardReport>) -> BoardReport {
    let ratios: Vec<_> = measured.iter().map(|one| usual(&measured, one)).collect();
    let values = measured.into_iter().zip(ratios).map(|(one, usual)| value(one, usual, before));
    BoardReport { board, values: values.collect(), aborted: None, unjudged: false }
}

/// The median of the same quantity over the board's channels, if at least three have it.
fn usual(measured: &[Measured], of: &Measured) -> Option<f64> {
    let same = measured.iter().filter(|one| one.quantity == of.quantity);
    let mut values: Vec<f64> = same.filter_map(|one| Some(one.estimate.as_ref().ok()?.0)).collect();
    values.sort_by(f64::total_cmp);
    let count = values.len();
    (count >= 3).then(|| 0.5 * (values[(count - 1) / 2] + values[count / 2]))
}

fn value(measured: Measured, usual: Option<f64>, before: Option<&BoardReport>) -> Value {
    let Measured { quantity, channel, estimate } = measured;
    let earlier = before.and_then(|board| board.value(quantity, channel));
    let mut value = Value {
        quantity,
        channel,
        value: None,
        interval: None,
        limits: (None, None),
        before: earlier.and_then(|earlier| earlier.value),
        verdict_alone: Verdict::NotMeasured,
        verdict: Verdict::NotMeasured,
        note: String::new(),
    };
    let (measured, error) = match estimate {
        Ok(estimate) => estimate,
        Err(why) => {
            // What could be measured before and cannot now is no matter of taste, unless this
            // machine was in the way.
            if value.before.is_some() && why != Missing::Busy {
                value.verdict = Verdict::Fail;
            }
            value.note = why.to_string();
            return value;
        }
    };
    value.value = Some(measured);
    value.interval = Some(NORMAL_95 * error);
    let (limits, verdict, note) = for_itself(quantity, measured, usual);
    (value.limits, value.verdict_alone, value.verdict, value.note) = (limits, verdict, verdict, note);
    if let Some(earlier) = earlier
        && let Some(Change { limits, verdict, note }) = change(quantity, measured, error, earlier)
    {
        value.limits = limits;
        if verdict > value.verdict {
            (value.verdict, value.note) = (verdict, note);
        }
    }
    value
}

type Judged = ((Option<f64>, Option<f64>), Verdict, String);

fn for_itself(quantity: Quantity, value: f64, usual: Option<f64>) -> Judged {
    let graded = |is: f64, warn: f64, fail: f64| match is {
        // Written so that NaN fails.
        is if is <= warn => Verdict::Pass,
        is if is <= fail => Verdict::Warn,
        _ => Verdict::Fail,
    };
    let (limits, verdict) = match quantity.limits() {
        Limits::Magnitude(warn, fail) => {
            ((Some(-warn).filter(|_| quantity.is_signed()), Some(warn)), graded(value.abs(), warn, fail))
        }
        Limits::Ratio(warn, fail) => match usual.filter(|&usual| usual > 0.0) {
            None => ((None, None), Verdict::Pass),
            Some(usual) => {
                let ratio = if value > 0.0 { (value / usual).max(usual / value) } else { f64::INFINITY };
                ((Some(usual / warn), Some(usual * warn)), graded(ratio, warn, fail))
            }
        },
    };
    let note = match (verdict, quantity.limits()) {
        (Verdict::Pass, _) => String::new(),
        (_, Limits::Ratio(..)) => "far from the board's other channels".to_owned(),
        _ => "beyond what a rig should have".to_owned(),
    };
    (limits, verdict, note)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(values: [f64; 4], quantity: Quantity, error: f64) -> Vec<Measured> {
        let one = |(channel, value)| Measured { quantity, channel, estimate: Ok((value, error)) };
        values.into_iter().enumerate().map(one).collect()
    }

    #[test]
    fn a_value_warns_and_fails_at_its_limits() {
        let board = judge(0, measured([1.0, -7.5, 26.0, f64::NAN], Quantity::Zero, 0.1), None);
        let verdicts: Vec<_> = board.values.iter().map(|value| value.verdict).collect();
        assert_eq!(verdicts, [Verdict::Pass, Verdict::Warn, Verdict::Fail, Verdict::Fail]);
        assert_eq!(board.verdict(), Verdict::Fail);
    }

    #[test]
    fn a_rate_is_judged_by_the_other_channels() {
        let board = judge(0, measured([700.0, 720.0, 350.0, 710.0], Quantity::FillRate, 5.0), None);
        let problems: Vec<_> = board.problems().map(|value| (value.channel, value.verdict)).collect();
        assert_eq!(problems, [(2, Verdict::Warn)]);
    }

    #[test]
    fn beside_an_earlier_check_small_changes_count_and_noise_does_not() {
        let before = judge(0, measured([700.0, 720.0, 690.0, 710.0], Quantity::FillRate, 2.0), None);
        let now = |values, error| judge(0, measured(values, Quantity::FillRate, error), Some(&before));
        assert_eq!(now([705.0, 715.0, 700.0, 705.0], 2.0).verdict(), Verdict::Pass);
        let slower = now([705.0, 715.0, 600.0, 705.0], 2.0);
        let problem = slower.problems().next().unwrap();
        assert_eq!((problem.channel, problem.verdict, problem.before), (2, Verdict::Warn, Some(690.0)));
        // The same change, uncertain by as much as itself.
        assert_eq!(now([705.0, 715.0, 600.0, 705.0], 60.0).verdict(), Verdict::Pass);
        assert_eq!(now([705.0, 715.0, 300.0, 705.0], 2.0).verdict(), Verdict::Fail);
    }

    /// Noise has no sign: that it is less than before is no news.
    #[test]
    fn what_cannot_be_negative_has_no_limit_below_0() {
        let limits = |quantity, kpa| {
            let board = judge(0, measured([kpa; 4], quantity, 0.0), None);
            let again = judge(0, measured([kpa; 4], quantity, 0.0), Some(&board));
            [board, again].map(|board| board.values[0].limits)
        };
        assert_eq!(limits(Quantity::Noise, 0.0), [(None, Some(2.0)), (None, Some(0.8))]);
        assert_eq!(limits(Quantity::Crosstalk, 1.5)[1], (Some(0.5), Some(2.5)));
        assert_eq!(limits(Quantity::Hold, 0.25)[1], (Some(-0.25), Some(0.75)));
    }

    #[test]
    fn what_was_measured_before_has_to_be_measurable() {
        let before = judge(0, measured([700.0; 4], Quantity::FillRate, 2.0), None);
        let gone = |why| vec![Measured { quantity: Quantity::FillRate, channel: 1, estimate: Err(why) }];
        let slow = || gone(Missing::Because("too slow".into()));
        assert_eq!(judge(0, slow(), None).verdict(), Verdict::NotMeasured);
        assert_eq!(judge(0, slow(), Some(&before)).verdict(), Verdict::Fail);
        assert_eq!(judge(0, gone(Missing::Busy), Some(&before)).verdict(), Verdict::NotMeasured);
    }
}
