//! What can be so wrong with a data file that it cannot be used.

use std::io;

/// Why a file cannot be opened, without the system's number of the error where everybody means the
/// same by it.
#[must_use]
pub fn why(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "you may not read it".to_owned(),
        _ => error.to_string(),
    }
}

/// A data file that cannot be read. Every message names the file, the row as an editor counts lines
/// (the header is row 1) and the column where they are known, what was expected, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DataError {
    /// The file could not be opened.
    #[error("{file}: cannot be opened: {}", why(.source))]
    Open {
        /// The file as given.
        file: String,
        /// The operating system's word.
        source: io::Error,
    },
    /// Reading stopped in the middle.
    #[error(
        "{file}: reading failed after row {line}: {source}; the file may be cut off or damaged, copy it again"
    )]
    Read {
        /// The file as given.
        file: String,
        /// Last row that was read whole.
        line: u64,
        /// What the reader or decompressor said.
        source: io::Error,
    },
    /// No content.
    #[error(
        "{file}: the file is empty; a recording starts with a header row such as t_s,b0_cmd0_kpa,b0_p0_kpa"
    )]
    Empty {
        /// The file as given.
        file: String,
    },
    /// Recognised, but not a format that can be read.
    #[error("{file}: this is {what}, which cannot be read; {advice}")]
    Unsupported {
        /// The file as given.
        file: String,
        /// What its first bytes say it is.
        what: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// The content is not what the name says.
    #[error(
        "{file}: the content is not {what}, which the name promises: the file is damaged or was renamed; copy it again"
    )]
    NotAsNamed {
        /// The file as given.
        file: String,
        /// What the name says it is.
        what: &'static str,
    },
    /// A ROS 2 bag that cannot be used.
    #[error("{file}: {source}")]
    Bag {
        /// The file as given.
        file: String,
        /// What is wrong with it.
        source: super::BagError,
    },
    /// A row is not UTF-8 text.
    #[error("{file}, row {line}: not valid UTF-8 text; save the file as plain CSV in UTF-8")]
    NotText {
        /// The file as given.
        file: String,
        /// Row.
        line: u64,
    },
    /// The time column is missing.
    #[error(
        "{file}, row 1: no column t_s (time in s) among: {found}; rename the time column, or use `pneudrive-model import --time`{hint}"
    )]
    NoTime {
        /// The file as given.
        file: String,
        /// The columns that are there.
        found: String,
        /// Further advice, with its leading separator, or empty.
        hint: String,
    },
    /// No command, pressure or drive column.
    #[error(
        "{file}, row 1: no channel columns such as b0_cmd0_kpa and b0_p0_kpa among: {found}; rename them, or use `pneudrive-model import --map`{hint}"
    )]
    NoChannels {
        /// The file as given.
        file: String,
        /// The columns that are there.
        found: String,
        /// Further advice, with its leading separator, or empty.
        hint: String,
    },
    /// A column name that appears twice.
    #[error("{file}, row 1: column {column} appears twice; remove or rename one of them")]
    DuplicateColumn {
        /// The file as given.
        file: String,
        /// The column.
        column: String,
    },
    /// Only one of the two separate drives.
    #[error(
        "{file}, row 1: column {present} has no {missing} beside it; separate fill and vent drives come in pairs (a single spool valve's drive is b{{n}}_u{{k}})"
    )]
    HalfDrive {
        /// The file as given.
        file: String,
        /// The column that is there.
        present: String,
        /// The column that is not.
        missing: String,
    },
    /// A spool drive and separate drives for one channel.
    #[error(
        "{file}, row 1: columns {spool} and {fill} both describe the drive of {channel}; keep the ones the valve really got"
    )]
    TwoDrives {
        /// The file as given.
        file: String,
        /// The channel.
        channel: super::ChannelId,
        /// The spool drive's column.
        spool: String,
        /// The fill drive's column.
        fill: String,
    },
    /// A cell that is no number.
    #[error("{file}, row {line}, column {column}: expected a number, found \"{text}\"; {}", advice(text))]
    NotANumber {
        /// The file as given.
        file: String,
        /// Row.
        line: u64,
        /// Column.
        column: String,
        /// The cell.
        text: String,
    },
    /// A value its column cannot have.
    #[error("{file}, row {line}, column {column}: {value} is outside {low} to {high}; {advice}")]
    OutOfRange {
        /// The file as given.
        file: String,
        /// Row.
        line: u64,
        /// Column.
        column: String,
        /// The value.
        value: f64,
        /// Lowest allowed.
        low: f64,
        /// Highest allowed.
        high: f64,
        /// What it most likely is, and what to do.
        advice: &'static str,
    },
    /// A row with too few or too many cells.
    #[error(
        "{file}, row {line}: {found} cells where the header has {expected} columns; correct or remove the row"
    )]
    Ragged {
        /// The file as given.
        file: String,
        /// Row.
        line: u64,
        /// Columns in the header.
        expected: usize,
        /// Cells in the row.
        found: usize,
    },
    /// Nothing to work with.
    #[error("{file}: usable rows: {rows}; a recording needs at least 2, and fitting a few hundred.{why}")]
    TooFewRows {
        /// The file as given.
        file: String,
        /// Rows left.
        rows: usize,
        /// What made the others unusable, each sentence behind a space, or empty.
        why: String,
    },
    /// Time stamps that no recording has.
    #[error(
        "{file}: t_s gives a sampling rate of {rate_hz:e} Hz, which nothing was recorded at: it must be in seconds"
    )]
    ImpossibleRate {
        /// The file as given.
        file: String,
        /// One over the median step.
        rate_hz: f64,
    },
    /// A channel was asked for that is not there.
    #[error("{file}: no channel {channel}; the file has {found}")]
    NoSuchChannel {
        /// The file as given.
        file: String,
        /// The channel asked for.
        channel: super::ChannelId,
        /// The channels that are there.
        found: String,
    },
    /// A channel lacks a column that the work needs.
    #[error("{file}: channel {channel} has no column {column}, which {purpose} needs")]
    MissingColumn {
        /// The file as given.
        file: String,
        /// The channel.
        channel: super::ChannelId,
        /// The column's name.
        column: String,
        /// What it is needed for.
        purpose: &'static str,
    },
    /// A result could not be written.
    #[error("{file}: cannot be written: {source}")]
    Write {
        /// The file.
        file: String,
        /// The operating system's word.
        source: io::Error,
    },
}

fn advice(cell: &str) -> &'static str {
    match cell.replacen(',', ".", 1).parse::<f64>() {
        Ok(_) => "decimals have a point: `pneudrive-model import --decimal-comma` reads those with a comma",
        Err(_) => "correct the cell, or leave it empty to have it masked",
    }
}
