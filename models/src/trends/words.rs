//! What trends show, in sentences.

use super::changes::FEWEST_RECORDINGS;
use super::date::TimeScale;
use super::series::Trend;
use crate::report::{behind, significant};

/// The recordings of the series with the most of them.
#[must_use]
pub fn recordings(trends: &[Trend]) -> usize {
    trends.iter().map(|trend| trend.points.len()).max().unwrap_or(0)
}

/// The scale on which the recordings' times are said.
#[must_use]
pub fn time_scale(trends: &[Trend]) -> TimeScale {
    TimeScale::of(times(trends))
}

/// What was found, without a full stop: `7 recordings from 2026-11-02 to 2026-11-20: 1 change`.
#[must_use]
pub fn conclusion(trends: &[Trend]) -> String {
    let scale = time_scale(trends);
    let first = times(trends).fold(f64::INFINITY, f64::min);
    let last = times(trends).fold(f64::NEG_INFINITY, f64::max);
    let count = recordings(trends);
    let when = match count {
        0 => String::new(),
        1 => format!(" of {}", scale.said(first)),
        _ => format!(" from {} to {}", scale.said(first), scale.said(last)),
    };
    let changes: usize = trends.iter().map(|trend| trend.levels.changes.len()).sum();
    let found = match changes {
        _ if too_few(trends) => format!("too few to tell a change ({FEWEST_RECORDINGS} at least)"),
        0 => "no parameter has changed".to_owned(),
        _ => counted(changes, "change"),
    };
    format!("{}{when}: {found}", counted(count, "recording"))
}

/// One sentence a change, without a full stop.
#[must_use]
pub fn changes(trends: &[Trend]) -> Vec<String> {
    let scale = time_scale(trends);
    let of_one = |trend: &Trend| {
        let (channel, parameter, unit) = (trend.channel, trend.parameter.clone(), behind(&trend.unit));
        let sentences = trend.levels.changes.iter().map(|change| {
            let [until, from] = change.between_unix_s.map(|unix_s| scale.said(unix_s));
            let [before, after] = [change.before, change.after].map(|value| significant(value, 3));
            format!("{channel} {parameter}: {before}{unit} until {until}, {after}{unit} from {from} on")
        });
        sentences.collect::<Vec<_>>()
    };
    trends.iter().flat_map(of_one).collect()
}

/// That nothing has changed cannot be said then either.
pub(super) fn too_few(trends: &[Trend]) -> bool {
    recordings(trends) < FEWEST_RECORDINGS
}

pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn times(trends: &[Trend]) -> impl Iterator<Item = f64> + Clone {
    trends.iter().flat_map(|trend| &trend.points).map(|point| point.unix_s)
}

#[cfg(test)]
mod tests {
    use super::super::changes::levels;
    use super::super::point::Point;
    use super::*;
    use crate::data::ChannelId;

    /// The parameter `beta` in recordings that lie so many seconds apart.
    fn trend(values: &[f64], apart_s: f64) -> Trend {
        let point = |(k, &value): (usize, &f64)| Point {
            unix_s: 1_793_664_000.0 + apart_s * k as f64,
            value,
            ci95: None,
        };
        let points: Vec<Point> = values.iter().enumerate().map(point).collect();
        Trend {
            channel: ChannelId { board: 1, channel: 2 },
            parameter: "beta".to_owned(),
            unit: "1/s".to_owned(),
            levels: levels(&points, points.len().saturating_sub(1)),
            points,
        }
    }

    #[test]
    fn few_recordings_are_too_few_and_not_unchanged() {
        let said =
            |count: usize| conclusion(&[trend(&[2.0, 2.01, 1.99, 2.02, 2.0, 1.98][..count], 86_400.0)]);
        assert_eq!(said(1), "1 recording of 2026-11-03 00:00:00 UTC: too few to tell a change (5 at least)");
        assert_eq!(
            said(4),
            "4 recordings from 2026-11-03 to 2026-11-06: too few to tell a change (5 at least)"
        );
        assert_eq!(said(5), "5 recordings from 2026-11-03 to 2026-11-07: no parameter has changed");
        assert_eq!(conclusion(&[]), "0 recordings: too few to tell a change (5 at least)");
    }

    #[test]
    fn a_change_between_two_runs_of_one_morning_has_its_time() {
        let found = [trend(&[2.0, 2.01, 1.99, 2.0, 3.0, 3.01, 2.99, 3.0], 600.0)];
        assert_eq!(
            changes(&found),
            ["b1c2 beta: 2.00 1/s until 2026-11-03 00:30:00 UTC, 3.00 1/s from 2026-11-03 00:40:00 UTC on"]
        );
        assert!(conclusion(&found).ends_with("01:10:00 UTC: 1 change"), "{}", conclusion(&found));
    }
}
