//! CSV text to raw columns: the header understood, every cell a number or missing.

use std::io::{self, Read};

use csv::{ByteRecord, ReaderBuilder, Trim};

use super::column::{ColumnKind, near_miss};
use super::{ChannelId, DataError};

/// One column as read: `NaN` stands for a missing cell.
pub(crate) struct RawColumn {
    pub kind: ColumnKind,
    pub name: String,
    pub values: Vec<f32>,
}

/// A file's columns before any check on their content. Single precision keeps an hour of 16
/// channels at 1 kHz under 1 GiB and resolves 0.0001 kPa at 700 kPa, far below a sensor's step;
/// time keeps double precision.
pub(crate) struct RawTable {
    pub time_s: Vec<f64>,
    pub line: Vec<u32>,
    pub columns: Vec<RawColumn>,
    /// Rows left out because the time cell is empty or not finite.
    pub timeless_lines: Vec<u32>,
    /// The last row, when it stops in the middle without a line end: a recorder that was killed.
    pub cut_off_line: Option<u32>,
    /// For a bag whose end is missing: what the reader met there.
    pub unfinished: Option<String>,
    /// Columns that look as if they were meant to be the format's: (found, meant).
    pub near_misses: Vec<(String, String)>,
}

/// What to read and whom to tell how far it is.
pub(crate) struct ReadPlan<'a> {
    pub channels: Option<&'a [ChannelId]>,
    /// Called now and then with the number of rows read.
    pub progress: &'a mut dyn FnMut(usize),
}

/// Rows between two progress calls.
const PROGRESS_ROWS: usize = 1 << 14;

/// Reads all of `text`.
pub(crate) fn read(file: &str, text: &mut dyn Read, plan: &mut ReadPlan<'_>) -> Result<RawTable, DataError> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .comment(Some(b'#'))
        .from_reader(text);
    let mut record = ByteRecord::new();
    if !next(file, &mut reader, &mut record, 0)? {
        return Err(DataError::Empty { file: file.to_owned() });
    }
    let header = Header::parse(file, &record, plan.channels)?;
    let mut table = RawTable {
        time_s: Vec::new(),
        line: Vec::new(),
        columns: header
            .wanted
            .iter()
            .map(|(_, kind, name)| RawColumn { kind: *kind, name: name.clone(), values: Vec::new() })
            .collect(),
        timeless_lines: Vec::new(),
        cut_off_line: None,
        unfinished: None,
        near_misses: header.near_misses,
    };
    let mut line = 1;
    // A short row is only known to be the last, cut-off one when nothing follows.
    let mut pending: Option<DataError> = None;
    while next(file, &mut reader, &mut record, line)? {
        if let Some(error) = pending {
            return Err(error);
        }
        // The reader takes comments above a row for a part of it.
        let begin = record.position().map_or(line + 1, csv::Position::line);
        line = begin.max(reader.position().line().saturating_sub(1));
        if record.len() != header.width {
            let (expected, found) = (header.width, record.len());
            let ragged = DataError::Ragged { file: file.to_owned(), line, expected, found };
            if found > expected {
                return Err(ragged);
            }
            pending = Some(ragged);
            table.cut_off_line = Some(row_number(line));
            continue;
        }
        let cell = Cell { file, line };
        let time = cell.number("t_s", &record[header.time])?;
        if !time.is_finite() || !ColumnKind::Time.valid_range().admits(time) {
            table.timeless_lines.push(row_number(line));
            continue;
        }
        for (column, (index, kind, name)) in table.columns.iter_mut().zip(&header.wanted) {
            let value = cell.number(name, &record[*index])?;
            cell.check_range(name, *kind, value)?;
            // Single precision: see RawTable.
            column.values.push(value as f32);
        }
        table.time_s.push(time);
        table.line.push(row_number(line));
        if table.time_s.len().is_multiple_of(PROGRESS_ROWS) {
            (plan.progress)(table.time_s.len());
        }
    }
    for column in &mut table.columns {
        column.values.shrink_to_fit();
    }
    Ok(table)
}

/// Rows beyond four thousand million are past any memory; the count sticks there.
fn row_number(line: u64) -> u32 {
    u32::try_from(line).unwrap_or(u32::MAX)
}

fn next(
    file: &str,
    reader: &mut csv::Reader<&mut dyn Read>,
    record: &mut ByteRecord,
    line: u64,
) -> Result<bool, DataError> {
    reader.read_byte_record(record).map_err(|error| match error.into_kind() {
        csv::ErrorKind::Io(source) => DataError::Read { file: file.to_owned(), line, source },
        other => {
            DataError::Read { file: file.to_owned(), line, source: io::Error::other(format!("{other:?}")) }
        }
    })
}

struct Header {
    width: usize,
    time: usize,
    wanted: Vec<(usize, ColumnKind, String)>,
    near_misses: Vec<(String, String)>,
}

impl Header {
    fn parse(file: &str, record: &ByteRecord, channels: Option<&[ChannelId]>) -> Result<Self, DataError> {
        let mut names: Vec<String> = Vec::with_capacity(record.len());
        for cell in record {
            let text = std::str::from_utf8(cell)
                .map_err(|_| DataError::NotText { file: file.to_owned(), line: 1 })?;
            // Excel puts a byte-order mark before the first name.
            names.push(text.trim_start_matches('\u{feff}').trim().to_owned());
        }
        let mut time = None;
        let mut wanted: Vec<(usize, ColumnKind, String)> = Vec::new();
        let mut any_channel = false;
        for (index, name) in names.iter().enumerate() {
            let Some(kind) = ColumnKind::parse(name) else { continue };
            if names[..index].iter().any(|earlier| ColumnKind::parse(earlier) == Some(kind)) {
                return Err(DataError::DuplicateColumn { file: file.to_owned(), column: name.clone() });
            }
            if kind == ColumnKind::Time {
                time = Some(index);
                continue;
            }
            any_channel |= kind.channel().is_some();
            if let (Some(id), Some(chosen)) = (kind.channel(), channels)
                && !chosen.contains(&id)
            {
                continue;
            }
            wanted.push((index, kind, name.clone()));
        }
        let near_misses: Vec<_> =
            names.iter().filter_map(|name| Some((name.clone(), near_miss(name)?))).collect();
        let Some(time) = time else {
            return Err(DataError::NoTime {
                file: file.to_owned(),
                found: listed(&names),
                hint: delimiter_hint(&names),
            });
        };
        if !any_channel {
            let hint = near_misses.first().map_or_else(
                || delimiter_hint(&names),
                |(found, meant)| format!("; is {found} meant to be {meant}?"),
            );
            return Err(DataError::NoChannels { file: file.to_owned(), found: listed(&names), hint });
        }
        for id in channels.unwrap_or_default() {
            check_present(file, *id, &names)?;
        }
        Ok(Self { width: names.len(), time, wanted, near_misses })
    }
}

/// Fails, naming the channels that are there, when `id` has no column among `names`.
pub(super) fn check_present(file: &str, id: ChannelId, names: &[String]) -> Result<(), DataError> {
    let mut present: Vec<ChannelId> =
        names.iter().filter_map(|name| ColumnKind::parse(name)?.channel()).collect();
    present.sort_unstable();
    present.dedup();
    if present.contains(&id) {
        return Ok(());
    }
    let found = present.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    Err(DataError::NoSuchChannel { file: file.to_owned(), channel: id, found })
}

fn listed(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text = names.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}

pub(super) fn delimiter_hint(names: &[String]) -> String {
    match names {
        [only] if only.contains(';') => {
            "; the columns are separated by semicolons: use `pneudrive-model import --delimiter ';'`"
                .to_owned()
        }
        [only] if only.contains('\t') => {
            "; the columns are separated by tabs: use `pneudrive-model import --delimiter tab`".to_owned()
        }
        _ => String::new(),
    }
}

pub(super) struct Cell<'a> {
    pub(super) file: &'a str,
    pub(super) line: u64,
}

impl Cell<'_> {
    /// The cell's number; `NaN` for an empty cell, the usual words for "nothing here", and
    /// infinities.
    fn number(&self, column: &str, bytes: &[u8]) -> Result<f64, DataError> {
        let text = std::str::from_utf8(bytes)
            .map_err(|_| DataError::NotText { file: self.file.to_owned(), line: self.line })?;
        parse_number(text).ok_or_else(|| DataError::NotANumber {
            file: self.file.to_owned(),
            line: self.line,
            column: column.to_owned(),
            text: text.chars().take(40).collect(),
        })
    }

    pub(super) fn check_range(&self, name: &str, kind: ColumnKind, value: f64) -> Result<(), DataError> {
        let range = kind.valid_range();
        if range.admits(value) {
            return Ok(());
        }
        Err(DataError::OutOfRange {
            file: self.file.to_owned(),
            line: self.line,
            column: name.to_owned(),
            value,
            low: range.low,
            high: range.high,
            advice: range.advice,
        })
    }
}

/// A number, `NaN` for a cell that says there is none, `None` for anything else.
pub(crate) fn parse_number(text: &str) -> Option<f64> {
    const NOTHING: [&str; 6] = ["", "-", "na", "n/a", "null", "none"];
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Some(value),
        Ok(_) => Some(f64::NAN),
        Err(_) => NOTHING.iter().any(|word| text.eq_ignore_ascii_case(word)).then_some(f64::NAN),
    }
}
