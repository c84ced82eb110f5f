//! Cells without a number: pressures are masked, inputs held for a short while.

use super::finding::{Finding, FindingKind, counted, rows_text, spans_where};
use crate::{ChannelId, Flags};

/// A missing input is held over at most this many rows, as over a short gap in time.
pub(crate) const HELD_ROWS: usize = 5;

/// Marks the rows where `values` (a measured pressure) is missing.
pub(crate) fn mark_missing_pressure(
    id: ChannelId,
    time_s: &[f64],
    line: &[u32],
    values: &[f32],
    flags: &mut [Flags],
) -> Option<Finding> {
    let mut count = 0;
    for (flag, value) in flags.iter_mut().zip(values) {
        if value.is_nan() {
            flag.insert(Flags::PRESSURE_MISSING);
            count += 1;
        }
    }
    if count == 0 {
        return None;
    }
    let spans = spans_where(time_s, line, |row| values[row].is_nan());
    let sentence = format!(
        "{}: {} empty or not a number ({}); nothing is compared with the simulation there.",
        id.pressure_column(),
        counted(count, "cell"),
        rows_text(&spans)
    );
    Some(Finding::new(FindingKind::MissingPressure, Some(id), count, spans, sentence))
}

/// Holds the last value of an input over short stretches of missing cells, in place. Returns for
/// each row [`Flags::INPUT_HELD`], [`Flags::INPUT_MISSING`] or nothing, and what is said; `None`
/// when no cell is missing.
pub(crate) fn hold_inputs(
    name: &str,
    channel: Option<ChannelId>,
    time_s: &[f64],
    line: &[u32],
    values: &mut [f32],
) -> Option<(Vec<Flags>, Finding)> {
    if !values.iter().any(|v| v.is_nan()) {
        return None;
    }
    let spans = spans_where(time_s, line, |row| values[row].is_nan());
    let mut marks = vec![Flags::NONE; values.len()];
    let mut held = 0;
    let mut count = 0;
    let mut row = 0;
    while row < values.len() {
        if !values[row].is_nan() {
            row += 1;
            continue;
        }
        let length = values[row..].iter().take_while(|v| v.is_nan()).count();
        count += length;
        let stretch = row..row + length;
        // Nothing to hold before the first value.
        if row > 0 && length <= HELD_ROWS {
            let last = values[row - 1];
            values[stretch.clone()].fill(last);
            marks[stretch].fill(Flags::INPUT_HELD);
            held += length;
        } else {
            marks[stretch].fill(Flags::INPUT_MISSING);
        }
        row += length;
    }
    let sentence = format!(
        "{name}: {} empty or not a number ({}); the last value is held in {held} of them (up to {HELD_ROWS} in a row), and no simulation passes the other {}.",
        counted(count, "cell"),
        rows_text(&spans),
        count - held
    );
    Some((marks, Finding::new(FindingKind::MissingInput, channel, count, spans, sentence)))
}

/// What is said of an input that is read now and then, and was missing for long: rows that `values`
/// still has no number in.
pub(crate) fn missing_for_long(name: &str, time_s: &[f64], line: &[u32], values: &[f32]) -> Option<Finding> {
    let count = values.iter().filter(|value| value.is_nan()).count();
    if count == 0 {
        return None;
    }
    let spans = spans_where(time_s, line, |row| values[row].is_nan());
    let sentence = format!(
        "{name}: no reading for more than 1 s in {} ({}); no simulation passes there.",
        counted(count, "row"),
        rows_text(&spans),
    );
    Some(Finding::new(FindingKind::MissingInput, None, count, spans, sentence))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_stretches_are_held_and_long_ones_end_the_simulation() {
        let nan = f32::NAN;
        let mut values = vec![nan, 1.0, nan, nan, 2.0];
        values.extend([nan; HELD_ROWS + 1]);
        values.push(3.0);
        let time: Vec<f64> = (0..).map(f64::from).take(values.len()).collect();
        let line: Vec<u32> = (2..).take(values.len()).collect();
        let (marks, finding) =
            hold_inputs("b0_u0", None, &time, &line, &mut values).expect("cells are missing");
        assert_eq!(marks[0], Flags::INPUT_MISSING);
        assert_eq!(&values[1..5], [1.0, 1.0, 1.0, 2.0]);
        assert_eq!(marks[2], Flags::INPUT_HELD);
        assert!(marks[5..5 + HELD_ROWS + 1].iter().all(|m| *m == Flags::INPUT_MISSING));
        assert_eq!(finding.count, 3 + HELD_ROWS + 1);
        assert!(finding.sentence.contains("held in 2 of them"), "{}", finding.sentence);
    }
}
