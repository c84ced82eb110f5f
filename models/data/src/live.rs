//! The rows of a table one after the other, also while it is being written: nothing is kept of
//! them.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use csv::{ByteRecord, Reader, ReaderBuilder, Trim};

use super::column::ColumnKind;
use super::csv::parse_number;
use super::follow::{EndNotice, follow};
use super::{DataError, source};

/// How a table is opened.
pub enum Opening<'a> {
    /// A file that is whole, to its end.
    Whole(&'a Path),
    /// A file that is being written, until it says that it has ended. At its end `wait` is called,
    /// and it goes on if that returns true.
    Growing(&'a Path, Box<dyn FnMut() -> bool>),
    /// Text that somebody else provides.
    Text(Box<dyn Read>),
}

/// A table that is read row by row.
pub struct LiveTable {
    file: String,
    reader: Reader<Box<dyn Read>>,
    record: ByteRecord,
    width: usize,
    /// Places and meanings of the columns of the format, the time first.
    wanted: Vec<(usize, ColumnKind)>,
}

impl LiveTable {
    /// Opens a table and reads its header.
    ///
    /// # Errors
    /// [`DataError`] when it cannot be opened, is a bag, or has no columns of the format.
    pub fn open(opening: Opening<'_>) -> Result<Self, DataError> {
        let (file, text) = match opening {
            Opening::Whole(path) => {
                let open = source::open(path)?;
                refuse_bag(&open)?;
                (open.file, open.text)
            }
            Opening::Growing(path, wait) => {
                let file = path.display().to_string();
                let failed = |source| DataError::Open { file: file.clone(), source };
                let (stored, ended) = follow(File::open(path).map_err(failed)?, wait);
                let open = source::decode(file, 0, Box::new(stored))?;
                refuse_bag(&open)?;
                let text: Box<dyn Read> = Box::new(EndNotice::new(open.text, ended));
                (open.file, text)
            }
            Opening::Text(text) => {
                let open = source::decode("standard input".to_owned(), 0, text)?;
                refuse_bag(&open)?;
                (open.file, open.text)
            }
        };
        Self::of(file, text)
    }

    fn of(file: String, text: Box<dyn Read>) -> Result<Self, DataError> {
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .from_reader(text);
        let mut table = Self { file, reader, record: ByteRecord::new(), width: 0, wanted: Vec::new() };
        if !table.advance()? {
            return Err(DataError::Empty { file: table.file });
        }
        let names: Vec<String> = table
            .record
            .iter()
            .map(|cell| String::from_utf8_lossy(cell).trim_start_matches('\u{feff}').to_owned())
            .collect();
        table.width = names.len();
        let kinds = names.iter().enumerate().filter_map(|(k, name)| Some((k, ColumnKind::parse(name)?)));
        let (time, others): (Vec<_>, Vec<_>) = kinds.partition(|(_, kind)| *kind == ColumnKind::Time);
        let found = || names.join(", ");
        if time.is_empty() {
            return Err(DataError::NoTime { file: table.file, found: found(), hint: String::new() });
        }
        if others.iter().all(|(_, kind)| kind.channel().is_none()) {
            return Err(DataError::NoChannels { file: table.file, found: found(), hint: String::new() });
        }
        table.wanted = time.into_iter().take(1).chain(others).collect();
        Ok(table)
    }

    /// Where it is from, for messages.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// What the numbers of a row are, the time first.
    pub fn kinds(&self) -> impl Iterator<Item = ColumnKind> + '_ {
        self.wanted.iter().map(|(_, kind)| *kind)
    }

    /// Reads the next row into `values`, in the order of the kinds, not a number where a cell is
    /// empty. Returns false at the end; a last row that stops in the middle is left out, as are
    /// rows without time.
    ///
    /// # Errors
    /// [`DataError`] naming the line.
    pub fn next(&mut self, values: &mut Vec<f64>) -> Result<bool, DataError> {
        let mut cut_off = None;
        while self.advance()? {
            if let Some(error) = cut_off {
                return Err(error);
            }
            let (line, found) = (self.line(), self.record.len());
            if found != self.width {
                let ragged = DataError::Ragged { file: self.file.clone(), line, expected: self.width, found };
                cut_off = Some(ragged);
                continue;
            }
            values.clear();
            for (place, kind) in &self.wanted {
                let text = std::str::from_utf8(&self.record[*place])
                    .map_err(|_| DataError::NotText { file: self.file.clone(), line })?;
                values.push(parse_number(text).ok_or_else(|| DataError::NotANumber {
                    file: self.file.clone(),
                    line,
                    column: kind.name(),
                    text: text.chars().take(40).collect(),
                })?);
            }
            if values[0].is_finite() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn line(&self) -> u64 {
        self.record.position().map_or(0, csv::Position::line)
    }

    fn advance(&mut self) -> Result<bool, DataError> {
        self.reader.read_byte_record(&mut self.record).map_err(|error| {
            let line = self.reader.position().line();
            let source = match error.into_kind() {
                csv::ErrorKind::Io(source) => source,
                other => io::Error::other(format!("{other:?}")),
            };
            DataError::Read { file: self.file.clone(), line, source }
        })
    }
}

fn refuse_bag(open: &source::OpenFile) -> Result<(), DataError> {
    if !open.is_bag {
        return Ok(());
    }
    Err(DataError::Unsupported {
        file: open.file.clone(),
        what: "a bag (MCAP), which cannot be read row by row",
        advice: "record a table instead (--record run.csv.zst), or name the finished bag without --follow",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &'static str) -> Result<LiveTable, DataError> {
        LiveTable::open(Opening::Text(Box::new(text.as_bytes())))
    }

    #[test]
    fn rows_come_one_after_the_other_and_a_cut_off_one_does_not() {
        let text = "# program: \"x\"\nnote,t_s,b0_p0_kpa\na,0,1.5\n# event: {\"t_s\":0}\nb,0.5,\nc,,7\nd,1";
        let mut table = table(text).unwrap();
        let id = "b0c0".parse().unwrap();
        assert_eq!(table.kinds().collect::<Vec<_>>(), [ColumnKind::Time, ColumnKind::Pressure(id)]);
        let mut row = Vec::new();
        assert!(table.next(&mut row).unwrap());
        assert_eq!(row, [0.0, 1.5]);
        assert!(table.next(&mut row).unwrap());
        assert!(row[0] == 0.5 && row[1].is_nan());
        assert!(!table.next(&mut row).unwrap(), "neither a row without time nor half a row: {row:?}");
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let mut ragged = table("t_s,b0_p0_kpa\n0\n1,2\n").unwrap();
        let error = ragged.next(&mut Vec::new()).unwrap_err();
        assert!(matches!(error, DataError::Ragged { line: 2, expected: 2, found: 1, .. }), "{error}");
        let mut words = table("t_s,b0_p0_kpa\n0,much\n").unwrap();
        assert!(words.next(&mut Vec::new()).unwrap_err().to_string().contains("b0_p0_kpa"));
        assert!(matches!(table("time,b0_p0_kpa\n0,1\n"), Err(DataError::NoTime { .. })));
        assert!(matches!(table("t_s,pressure\n0,1\n"), Err(DataError::NoChannels { .. })));
    }
}
