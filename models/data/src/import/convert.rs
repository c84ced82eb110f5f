//! The conversion itself, row by row, in constant memory.

use std::io::{self, Write};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Trim};

use super::unit::{Linear, UnitContext};
use super::{ImportError, Mapping, OutOfRange};
use crate::column::ColumnKind;
use crate::csv::{delimiter_hint, parse_number};
use crate::rig::Rig;
use crate::{DataError, Source, source, write};

/// Where the time of a row comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeSource {
    /// A column.
    Column(Mapping),
    /// The row's number at this rate, Hz.
    Rate(f64),
}

/// How the foreign file is written, and what becomes of it.
#[derive(Debug, Clone)]
pub struct Foreign {
    /// Between two cells.
    pub delimiter: u8,
    /// Decimal comma instead of point.
    pub decimal_comma: bool,
    /// Lines before the header.
    pub skip_lines: usize,
    /// Subtract the first row's time.
    pub from_zero: bool,
    /// Time.
    pub time: TimeSource,
    /// All other columns.
    pub columns: Vec<Mapping>,
    /// What counts and absolute pressures mean.
    pub rig: Rig,
}

/// What an import did.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The foreign file.
    pub source: Source,
    /// Rows written.
    pub rows: usize,
}

/// One target column: where its cell is and how it converts.
struct Job<'a> {
    mapping: &'a Mapping,
    index: usize,
    conversion: Linear,
    kind: Option<ColumnKind>,
}

/// Converts `input` to the measured-data format at `output`, compressed as its extension says.
///
/// Cells without a number stay empty: the loader masks them.
///
/// # Errors
/// [`ImportError`], naming file, row and column.
pub fn convert(input: &Path, output: &Path, foreign: &Foreign) -> Result<Imported, ImportError> {
    for (index, mapping) in foreign.columns.iter().enumerate() {
        if foreign.columns[..index].iter().any(|other| other.target == mapping.target) {
            return Err(ImportError::MappedTwice { target: mapping.target.clone() });
        }
    }
    let mut open = source::open(input)?;
    let file = open.file.clone();
    let mut text = io::BufReader::with_capacity(1 << 16, &mut *open.text);
    skip_lines(&mut text, foreign.skip_lines).map_err(|source| DataError::Read {
        file: file.clone(),
        line: 0,
        source,
    })?;
    let mut rows = 0;
    write::compressed_atomically::<ImportError>(output, |writer| {
        let reader = Reader { file: &file, foreign, first_line: foreign.skip_lines as u64 };
        rows = reader.copy(&mut text, writer, output)?;
        Ok(())
    })?;
    drop(text);
    Ok(Imported { source: open.finish()?, rows })
}

fn skip_lines(text: &mut dyn io::BufRead, lines: usize) -> io::Result<()> {
    let mut line = Vec::new();
    for _ in 0..lines {
        line.clear();
        text.read_until(b'\n', &mut line)?;
    }
    Ok(())
}

struct Reader<'a> {
    file: &'a str,
    foreign: &'a Foreign,
    /// Lines before the header: added to the line numbers the CSV reader counts.
    first_line: u64,
}

impl Reader<'_> {
    fn copy(
        &self,
        text: &mut dyn io::Read,
        writer: &mut dyn Write,
        output: &Path,
    ) -> Result<usize, ImportError> {
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .delimiter(self.foreign.delimiter)
            .from_reader(text);
        let mut record = ByteRecord::new();
        if !self.next(&mut reader, &mut record, 0)? {
            return Err(DataError::Empty { file: self.file.to_owned() }.into());
        }
        let names: Vec<String> = record
            .iter()
            .map(|cell| String::from_utf8_lossy(cell).trim_start_matches('\u{feff}').trim().to_owned())
            .collect();
        let time = match &self.foreign.time {
            TimeSource::Column(mapping) => Some(self.job(mapping, &names)?),
            TimeSource::Rate(_) => None,
        };
        let jobs = self.foreign.columns.iter().map(|m| self.job(m, &names)).collect::<Result<Vec<_>, _>>()?;
        let failed = |source| DataError::Write { file: output.display().to_string(), source };

        let header: Vec<&str> =
            std::iter::once("t_s").chain(jobs.iter().map(|j| j.mapping.target.as_str())).collect();
        writeln!(writer, "{}", header.join(",")).map_err(failed)?;
        let (mut rows, mut line, mut origin) = (0_usize, 1, None);
        while self.next(&mut reader, &mut record, line)? {
            line = record.position().map_or(line + 1, csv::Position::line);
            if record.len() != names.len() {
                let (expected, found) = (names.len(), record.len());
                let line = line + self.first_line;
                return Err(DataError::Ragged { file: self.file.to_owned(), line, expected, found }.into());
            }
            let time_s = match (&time, &self.foreign.time) {
                (Some(job), _) => self.value(job, &record, line)?,
                // Rows are far fewer than 2^53.
                (None, TimeSource::Rate(rate_hz)) => rows as f64 / rate_hz,
                (None, TimeSource::Column(_)) => f64::NAN,
            };
            if self.foreign.from_zero && origin.is_none() && time_s.is_finite() {
                origin = Some(time_s);
            }
            number(writer, time_s - origin.unwrap_or(0.0), 9).map_err(failed)?;
            for job in &jobs {
                writer.write_all(b",").map_err(failed)?;
                number(writer, self.value(job, &record, line)?, 6).map_err(failed)?;
            }
            writer.write_all(b"\n").map_err(failed)?;
            rows += 1;
        }
        Ok(rows)
    }

    fn next(
        &self,
        reader: &mut csv::Reader<&mut dyn io::Read>,
        record: &mut ByteRecord,
        line: u64,
    ) -> Result<bool, DataError> {
        reader.read_byte_record(record).map_err(|e| DataError::Read {
            file: self.file.to_owned(),
            line: line + self.first_line,
            source: io::Error::other(e),
        })
    }

    fn job<'m>(&self, mapping: &'m Mapping, names: &[String]) -> Result<Job<'m>, ImportError> {
        let by_number = || {
            let n: usize = mapping.source.strip_prefix('#')?.parse().ok()?;
            n.checked_sub(1).filter(|index| *index < names.len())
        };
        let index =
            names.iter().position(|name| *name == mapping.source).or_else(by_number).ok_or_else(|| {
                ImportError::NoSuchColumn {
                    file: self.file.to_owned(),
                    line: 1 + self.first_line,
                    column: mapping.source.clone(),
                    found: names.join(", "),
                    hint: delimiter_hint(names),
                }
            })?;
        let kind = ColumnKind::parse(&mapping.target);
        let context = UnitContext::of(&self.foreign.rig, kind.and_then(ColumnKind::channel));
        let conversion = mapping
            .unit
            .conversion(mapping.quantity, mapping.offset, &context)
            .map_err(|table| ImportError::CountsWithoutRig { text: mapping.text.clone(), table })?;
        Ok(Job { mapping, index, conversion, kind })
    }

    fn value(&self, job: &Job<'_>, record: &ByteRecord, line: u64) -> Result<f64, ImportError> {
        let line = line + self.first_line;
        let cell = String::from_utf8_lossy(&record[job.index]);
        let cell = if self.foreign.decimal_comma { cell.replace(',', ".") } else { cell.into_owned() };
        let value = parse_number(&cell).ok_or_else(|| DataError::NotANumber {
            file: self.file.to_owned(),
            line,
            column: job.mapping.source.clone(),
            text: cell,
        })?;
        let converted = job.conversion.apply(value);
        match job.kind.map(ColumnKind::valid_range) {
            Some(range) if !range.admits(converted) => Err(ImportError::OutOfRange(Box::new(OutOfRange {
                file: self.file.to_owned(),
                line,
                column: job.mapping.source.clone(),
                value,
                converted,
                target: job.mapping.target.clone(),
                low: range.low,
                high: range.high,
                advice: range.advice,
            }))),
            _ => Ok(converted),
        }
    }
}

/// Writes a number rounded to `decimals` places without trailing zeros; nothing for a missing one.
fn number(writer: &mut dyn Write, value: f64, decimals: usize) -> io::Result<()> {
    if value.is_nan() {
        return Ok(());
    }
    let text = format!("{value:.decimals$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    writer.write_all(if text == "-0" { b"0" } else { text.as_bytes() })
}
