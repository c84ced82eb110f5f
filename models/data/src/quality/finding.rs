//! One thing that was found, where, and the sentence that says it.

use serde::{Deserialize, Serialize};

use crate::ChannelId;

/// What kind of defect it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// A column that is not read, though its name nearly is one of the format's.
    UnusedColumn,
    /// The last row stops in the middle.
    CutOffRow,
    /// Rows without a time.
    MissingTime,
    /// Rows whose time does not come after the time of the row before.
    TimeOrder,
    /// Time that passes without a row.
    Gap,
    /// A sampling rate that hints at a wrong unit.
    OddRate,
    /// Pressures that do not go with the rig file's supply.
    OddPressure,
    /// Pressure cells without a number.
    MissingPressure,
    /// Command, drive, joint or supply cells without a number.
    MissingInput,
    /// A sensor that repeats one value while it should move.
    StuckSensor,
    /// Samples at a limit of the sensor.
    Saturated,
}

/// Consecutive rows that a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// First row, as an editor counts (the header is row 1).
    pub first_row: u32,
    /// Last row.
    pub last_row: u32,
    /// Time of the first row, s; of the row before it where the row itself has none.
    pub from_s: f64,
    /// Time of the last row, s.
    pub to_s: f64,
}

/// One defect of one column or of the time axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// What kind of defect.
    pub kind: FindingKind,
    /// The channel, where it is one channel's.
    pub channel: Option<ChannelId>,
    /// Rows or cells affected.
    pub count: usize,
    /// Where, at most [`Finding::SPANS_KEPT`] stretches.
    pub spans: Vec<Span>,
    /// What was found, where, and what is done about it.
    pub sentence: String,
}

impl Finding {
    /// Stretches listed one by one; the count covers all.
    pub const SPANS_KEPT: usize = 20;

    /// A finding about `spans`, of which the first few are kept.
    pub(crate) fn new(
        kind: FindingKind,
        channel: Option<ChannelId>,
        count: usize,
        mut spans: Vec<Span>,
        sentence: String,
    ) -> Self {
        spans.truncate(Self::SPANS_KEPT);
        Self { kind, channel, count, spans, sentence }
    }
}

/// Stands for the name of a column: no text of a file holds it.
pub(super) const COLUMN: &str = "\u{0}";

impl Finding {
    /// The sentence with [`COLUMN`] in place of the column that it begins with, and that column;
    /// unchanged if it is about none of a channel.
    pub(super) fn without_column(&self) -> (String, Option<String>) {
        let column = self.channel.and_then(|id| {
            let (fill, vent) = id.fill_vent_columns();
            let names = [id.pressure_column(), id.command_column(), id.drive_column(), fill, vent];
            names.into_iter().find(|name| self.sentence.starts_with(&format!("{name}:")))
        });
        match column {
            Some(name) => (format!("{COLUMN}{}", &self.sentence[name.len()..]), Some(name)),
            None => (self.sentence.clone(), None),
        }
    }
}

/// "rows 4, 9 to 12 and 3 more places" for a sentence.
pub(crate) fn rows_text(spans: &[Span]) -> String {
    const SHOWN: usize = 3;
    let one = |s: &Span| {
        if s.first_row == s.last_row {
            s.first_row.to_string()
        } else {
            format!("{} to {}", s.first_row, s.last_row)
        }
    };
    let shown = spans.iter().take(SHOWN).map(one).collect::<Vec<_>>().join(", ");
    let plural =
        if spans.len() > 1 || spans.iter().any(|s| s.first_row != s.last_row) { "rows" } else { "row" };
    match spans.len().saturating_sub(SHOWN) {
        0 => format!("{plural} {shown}"),
        1 => format!("{plural} {shown} and 1 more place"),
        more => format!("{plural} {shown} and {more} more places"),
    }
}

/// `1 cell is`, `2 cells are`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun} is") } else { format!("{count} {noun}s are") }
}

/// Consecutive runs of rows for which `hit` holds.
pub(crate) fn spans_where(time_s: &[f64], line: &[u32], mut hit: impl FnMut(usize) -> bool) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    let mut inside = false;
    for row in 0..time_s.len() {
        if hit(row) {
            if !inside {
                spans.push(Span {
                    first_row: line[row],
                    last_row: line[row],
                    from_s: time_s[row],
                    to_s: time_s[row],
                });
            }
            inside = true;
            if let Some(span) = spans.last_mut() {
                span.last_row = line[row];
                span.to_s = time_s[row];
            }
        } else {
            inside = false;
        }
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_name_a_few_places_and_count_the_rest() {
        let time: Vec<f64> = (0..10).map(f64::from).collect();
        let line: Vec<u32> = (2..12).collect();
        let spans = spans_where(&time, &line, |row| [0, 2, 3, 5, 7, 9].contains(&row));
        assert_eq!(rows_text(&spans), "rows 2, 4 to 5, 7 and 2 more places");
        assert_eq!(rows_text(&spans[..1]), "row 2");
        assert_eq!((spans[1].from_s, spans[1].to_s), (2.0, 3.0));
        assert_eq!(counted(1, "cell"), "1 cell is");
        assert_eq!(counted(4, "row"), "4 rows are");
    }
}
