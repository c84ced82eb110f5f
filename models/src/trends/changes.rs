//! Where a series has changed its level.
//!
//! A fit's own interval says how well one recording determines a parameter, and not how much it
//! differs from day to day (temperature, supply, another movement). So the scatter between
//! recordings decides: the series is cut where the two parts' means differ most by Student's t, and
//! each part again, as long as the cut would hardly be seen by chance (binary segmentation, with
//! Bonferroni's correction for all places at which a cut was looked for). Intervals only widen the
//! scatter where it is smaller than they are.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::point::Point;

/// Chance of a change anywhere in a page of series that do not change.
const BY_CHANCE: f64 = 0.05;
/// Points that tell the scatter, at the least, beside the two means.
const LEAST_FREEDOM: usize = 3;
/// Recordings of which a change can be told, at the least.
pub(super) const FEWEST_RECORDINGS: usize = 2 + LEAST_FREEDOM;
/// Standard errors of a 95 % interval.
const NORMAL_95: f64 = 1.96;

/// A change of level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    /// Number of the first point behind it.
    pub at: usize,
    /// Between these two times, s since 1970.
    pub between_unix_s: [f64; 2],
    /// Mean before.
    pub before: f64,
    /// Mean after.
    pub after: f64,
    /// Chance of so large a difference at this place in a series that does not change.
    pub by_chance: f64,
}

/// The levels of a series: means between changes.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Levels {
    /// The changes, the earliest first.
    pub changes: Vec<Change>,
}

/// Finds the changes of a series, among so many places at which changes are looked for in all
/// series together.
#[must_use]
pub fn levels(points: &[Point], chances: usize) -> Levels {
    let enough = BY_CHANCE / chances.max(1) as f64;
    let mut cuts = vec![0, points.len()];
    let mut rest = vec![(0, points.len())];
    while let Some((from, to)) = rest.pop() {
        if let Some((at, _)) = best_cut(&points[from..to]).filter(|(_, chance)| *chance <= enough) {
            cuts.push(from + at);
            rest.extend([(from, from + at), (from + at, to)]);
        }
    }
    cuts.sort_unstable();
    let change = |window: &[usize]| {
        let (from, at, to) = (window[0], window[1], window[2]);
        let (before, after) = (&points[from..at], &points[at..to]);
        Change {
            at,
            between_unix_s: [points[at - 1].unix_s, points[at].unix_s],
            before: mean(before),
            after: mean(after),
            by_chance: chance(before, after),
        }
    };
    Levels { changes: cuts.windows(3).map(change).collect() }
}

/// The place at which two means differ most, and the chance of that there.
fn best_cut(points: &[Point]) -> Option<(usize, f64)> {
    let cuts = (1..points.len()).map(|at| (at, chance(&points[..at], &points[at..])));
    cuts.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Chance that the means of two parts with one scatter differ by as much as they do.
fn chance(before: &[Point], after: &[Point]) -> f64 {
    let count = before.len() + after.len();
    let freedom = count.saturating_sub(2);
    if before.is_empty() || after.is_empty() || freedom < LEAST_FREEDOM {
        return 1.0;
    }
    let squares = |part: &[Point]| {
        let mean = mean(part);
        part.iter().map(|point| (point.value - mean).powi(2)).sum::<f64>()
    };
    let scatter = (squares(before) + squares(after)) / freedom as f64;
    let variance = scatter.max(own_variance(before.iter().chain(after), count));
    let error = (variance * (1.0 / before.len() as f64 + 1.0 / after.len() as f64)).sqrt();
    let t = (mean(after) - mean(before)).abs() / error.max(f64::MIN_POSITIVE);
    match StudentsT::new(0.0, 1.0, freedom as f64) {
        Ok(student) if t.is_finite() => 2.0 * student.cdf(-t),
        _ => 1.0,
    }
}

/// Mean variance that the points' own intervals stand for; 0 where there are none.
fn own_variance<'a>(points: impl Iterator<Item = &'a Point>, count: usize) -> f64 {
    let own =
        points.filter_map(|point| point.ci95).map(|[low, high]| (0.5 * (high - low) / NORMAL_95).powi(2));
    own.filter(|variance| variance.is_finite()).sum::<f64>() / count as f64
}

fn mean(points: &[Point]) -> f64 {
    points.iter().map(|point| point.value).sum::<f64>() / points.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    fn series(values: impl IntoIterator<Item = f64>) -> Vec<Point> {
        let point = |(k, value)| Point { unix_s: 86_400.0 * f64::from(k), value, ci95: None };
        (0..).zip(values).map(point).collect()
    }

    /// The sum of twelve even numbers: nearly normal, with a standard deviation of 1.
    fn noise(random: &mut Pcg64Mcg) -> f64 {
        (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
    }

    #[test]
    fn two_steps_are_found_where_they_are() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let level = |k: u32| {
            if k < 8 {
                1.0
            } else if k < 15 {
                3.0
            } else {
                1.5
            }
        };
        let points = series((0..22).map(|k| level(k) + 0.2 * noise(&mut random)));
        let found = levels(&points, 21).changes;
        assert_eq!(found.iter().map(|change| change.at).collect::<Vec<_>>(), [8, 15], "{found:?}");
        assert!((found[0].before - 1.0).abs() < 0.3 && (found[0].after - 3.0).abs() < 0.3, "{found:?}");
        assert_eq!(found[1].between_unix_s, [14.0 * 86_400.0, 15.0 * 86_400.0]);
    }

    #[test]
    fn a_last_recording_that_is_far_off_is_a_change() {
        let mut random = Pcg64Mcg::seed_from_u64(4);
        let points = series((0..8).map(|k| if k == 7 { 9.0 } else { 1.0 } + 0.2 * noise(&mut random)));
        assert_eq!(levels(&points, 7).changes.iter().map(|change| change.at).collect::<Vec<_>>(), [7]);
        // As large a step that the recordings themselves do not tell is none.
        let vague: Vec<Point> =
            points.iter().map(|p| Point { ci95: Some([p.value - 20.0, p.value + 20.0]), ..*p }).collect();
        assert!(levels(&vague, 7).changes.is_empty());
    }

    /// 300 pages of 28 series that do not change: about one in twenty has a mark, and not many
    /// more.
    #[test]
    fn what_does_not_change_is_hardly_ever_marked() {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let marked = (0..300).filter(|_| {
            (0..28).any(|_| !levels(&series((0..12).map(|_| noise(&mut random))), 28 * 11).changes.is_empty())
        });
        let marked = marked.count();
        assert!((1..=30).contains(&marked), "{marked} of 300");
    }

    #[test]
    fn few_points_tell_nothing() {
        assert!(levels(&series([1.0, 1.0, 5.0, 5.0]), 3).changes.is_empty());
        assert!(levels(&[], 0).changes.is_empty());
    }
}
