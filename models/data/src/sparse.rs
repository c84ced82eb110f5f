//! Columns that have a value now and then: a board that is asked for its supply pressure between
//! polls.

use super::Flags;

/// Over more than this nothing is drawn between two readings, s: a sensor that was unplugged.
pub(super) const LONGEST_GAP_S: f64 = 1.0;

/// Fills the cells between two readings with the straight line, and those before the first and
/// after the last one with that reading, in place, but over no more than [`LONGEST_GAP_S`]. Returns
/// [`Flags::INPUT_MISSING`] for each row that stays empty, if one does.
#[allow(clippy::cast_possible_truncation)] // columns are kept in single precision
pub(super) fn fill(time_s: &[f64], values: &mut [f32]) -> Option<Vec<Flags>> {
    let readings: Vec<usize> = (0..values.len()).filter(|&row| !values[row].is_nan()).collect();
    for pair in readings.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let span = time_s[to] - time_s[from];
        if span > LONGEST_GAP_S {
            continue;
        }
        let (low, high) = (f64::from(values[from]), f64::from(values[to]));
        for row in from + 1..to {
            values[row] = (low + (high - low) * (time_s[row] - time_s[from]) / span) as f32;
        }
    }
    if let (Some(&first), Some(&last)) = (readings.first(), readings.last()) {
        let near = |row: usize, reading: usize| (time_s[row] - time_s[reading]).abs() <= LONGEST_GAP_S;
        (0..first).filter(|&row| near(row, first)).for_each(|row| values[row] = values[first]);
        (last + 1..values.len()).filter(|&row| near(row, last)).for_each(|row| values[row] = values[last]);
    }
    values.iter().any(|value| value.is_nan()).then(|| {
        let mark = |value: &f32| if value.is_nan() { Flags::INPUT_MISSING } else { Flags::NONE };
        values.iter().map(mark).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f32 = f32::NAN;

    #[test]
    fn between_two_readings_is_the_straight_line_and_outside_the_nearest() {
        let time_s = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5];
        let mut values = [NONE, 550.0, NONE, NONE, 547.0, NONE];
        assert_eq!(fill(&time_s, &mut values), None);
        assert_eq!(values, [550.0, 550.0, 549.0, 548.0, 547.0, 547.0]);
    }

    #[test]
    fn a_long_gap_stays_empty() {
        let time_s = [0.0, 1.1, 1.2, 1.3, 2.4, 2.5];
        let mut values = [NONE, 550.0, NONE, NONE, NONE, 540.0];
        let marks = fill(&time_s, &mut values).unwrap();
        assert_eq!(marks[0], Flags::INPUT_MISSING, "more than 1 s before the first reading");
        assert_eq!(marks[1], Flags::NONE);
        assert!(marks[2..5].iter().all(|mark| *mark == Flags::INPUT_MISSING), "{marks:?}");
    }
}
