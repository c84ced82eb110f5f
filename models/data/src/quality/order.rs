//! Rows whose time does not increase are left out: as few as possible.

use super::finding::{Finding, FindingKind, Span, counted, rows_text};

/// Which rows to keep so that time strictly increases, as a mask, and what is said about the
/// others.
///
/// The kept rows are a longest increasing subsequence, so that one wild time stamp costs one row,
/// not all that follow.
pub(crate) fn keep_increasing(time_s: &[f64], line: &[u32]) -> Option<(Vec<bool>, Finding)> {
    if time_s.windows(2).all(|w| w[0] < w[1]) {
        return None;
    }
    let keep = longest_increasing(time_s);
    let (mut duplicates, mut backward) = (0_usize, 0_usize);
    let mut spans: Vec<Span> = Vec::new();
    let mut previous_dropped = false;
    for row in 0..time_s.len() {
        if keep[row] {
            previous_dropped = false;
            continue;
        }
        // `total_cmp` equality: the very same time stamp.
        let same = |other: Option<&f64>| other.is_some_and(|t| t.total_cmp(&time_s[row]).is_eq());
        if same(time_s.get(row + 1)) || (row > 0 && same(time_s.get(row - 1))) {
            duplicates += 1;
        } else {
            backward += 1;
        }
        match spans.last_mut() {
            Some(span) if previous_dropped => (span.last_row, span.to_s) = (line[row], time_s[row]),
            _ => spans.push(Span {
                first_row: line[row],
                last_row: line[row],
                from_s: time_s[row],
                to_s: time_s[row],
            }),
        }
        previous_dropped = true;
    }
    let count = duplicates + backward;
    let sentence = format!(
        "t_s must increase from row to row: {} left out ({duplicates} with a time stamp that repeats, {backward} out of order; {}).",
        counted(count, "row"),
        rows_text(&spans),
    );
    Some((keep, Finding::new(FindingKind::TimeOrder, None, count, spans, sentence)))
}

/// Patience sorting: `tails[k]` is the row that ends the lowest-ending increasing subsequence of
/// length k + 1.
fn longest_increasing(time_s: &[f64]) -> Vec<bool> {
    const NONE: u32 = u32::MAX;
    let mut tails: Vec<u32> = Vec::new();
    let mut before = vec![NONE; time_s.len()];
    for (row, &t) in time_s.iter().enumerate() {
        let place = tails.partition_point(|&tail| time_s[tail as usize] < t);
        if place > 0 {
            before[row] = tails[place - 1];
        }
        // Rows are counted in u32 throughout (see `Recording::line`).
        let row = row as u32;
        match tails.get_mut(place) {
            // Of equal time stamps the first row stays: it was there when that time came.
            Some(tail) if time_s[*tail as usize].total_cmp(&t).is_gt() => *tail = row,
            Some(_) => {}
            None => tails.push(row),
        }
    }
    let mut keep = vec![false; time_s.len()];
    let mut row = tails.last().copied().unwrap_or(NONE);
    while row != NONE {
        keep[row as usize] = true;
        row = before[row as usize];
    }
    keep
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(time: &[f64]) -> (Vec<f64>, String) {
        let line: Vec<u32> = (2..).take(time.len()).collect();
        let (keep, finding) = keep_increasing(time, &line).expect("out of order");
        (time.iter().zip(&keep).filter(|(_, k)| **k).map(|(t, _)| *t).collect(), finding.sentence)
    }

    #[test]
    fn one_wild_time_stamp_costs_one_row() {
        let (times, sentence) = kept(&[0.0, 0.1, 99.0, 0.2, 0.3]);
        assert_eq!(times, [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(
            sentence,
            "t_s must increase from row to row: 1 row is left out (0 with a time stamp that repeats, 1 out of order; row 4)."
        );
    }

    #[test]
    fn repeated_rows_are_told_from_unsorted_ones() {
        let (times, sentence) = kept(&[0.0, 0.1, 0.1, 0.1, 0.2, 0.15, 0.3]);
        assert_eq!(times.len(), 4);
        assert!(
            sentence.contains("3 rows are left out (2 with a time stamp that repeats, 1 out of order"),
            "{sentence}"
        );
    }

    #[test]
    fn an_increasing_axis_is_left_alone() {
        assert!(keep_increasing(&[0.0, 0.1, 0.2], &[2, 3, 4]).is_none());
    }
}
