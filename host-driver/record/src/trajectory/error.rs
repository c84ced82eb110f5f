use pneudrive_host::poller::AboveLimit;
use pneudrive_protocol::PressureError;
use thiserror::Error;

/// A trajectory that cannot be played. Rows are lines of the file, the header and comments among
/// them; in a bag they are counted.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// The file cannot be read.
    #[error("{file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system said.
        reason: String,
    },
    /// It is no CSV file.
    #[error("{file}, row {row}: not readable as CSV: {reason}")]
    NotCsv {
        /// The file.
        file: String,
        /// The row.
        row: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// A column that must be there is not.
    #[error(
        "{file}, row {row}: no column {expected}; the header must have t_s and one or more b{{n}}_cmd{{k}}_kpa, such as b0_cmd0_kpa"
    )]
    MissingColumn {
        /// The file.
        file: String,
        /// Row of the header.
        row: u64,
        /// What was looked for.
        expected: &'static str,
    },
    /// Two columns have one name.
    #[error("{file}, row {row}: column {column} is there twice")]
    DuplicateColumn {
        /// The file.
        file: String,
        /// Row of the header.
        row: u64,
        /// The column's name.
        column: String,
    },
    /// A column for a board or channel that is not there.
    #[error("{file}, {place}column {column}: there are boards 0 to {last_board}, each with channels 0 to 3; see --devices",
        place = row.map_or_else(String::new, |row| format!("row {row}, ")), last_board = boards - 1)]
    NoSuchChannel {
        /// The file.
        file: String,
        /// Row of the header; `None` in a bag, which has none.
        row: Option<u64>,
        /// The column's name.
        column: String,
        /// How many boards are polled.
        boards: usize,
    },
    /// A column that is meant as a command and names no channel in kPa.
    #[error(
        "{file}{place}: column {column} is not one that a trajectory has{}",
        match meant {
            Some(meant) => format!("; did you mean {meant}? Rename it (values are in kPa), or leave it out"),
            None => ": commands are called b{n}_cmd{k}_kpa, such as b0_cmd0_kpa for board 0, channel 0; rename it, \
                     or leave it out".to_owned(),
        }, place = row.map_or_else(String::new, |row| format!(", row {row}"))
    )]
    UnknownCommand {
        /// The file.
        file: String,
        /// Row of the header; `None` in a bag, which has none.
        row: Option<u64>,
        /// The column's name.
        column: String,
        /// The name that it was most likely meant to have.
        meant: Option<String>,
    },
    /// A cell that is no number.
    #[error("{file}, row {row}, column {column}: expected a number, found \"{text}\"")]
    NotANumber {
        /// The file.
        file: String,
        /// The row.
        row: u64,
        /// The column's name.
        column: String,
        /// What the cell holds.
        text: String,
    },
    /// A time that is not after the one before it.
    #[error(
        "{file}, row {row}, column t_s: {time_s} s; times must be from 0 to 1e9 s and each later than the one before"
    )]
    Time {
        /// The file.
        file: String,
        /// The row.
        row: u64,
        /// The time, s.
        time_s: f64,
    },
    /// A pressure that cannot be commanded.
    #[error("{file}, row {row}, column {column}: {reason}")]
    Pressure {
        /// The file.
        file: String,
        /// The row.
        row: u64,
        /// The column's name.
        column: String,
        /// Why it cannot be commanded.
        reason: PressureError,
    },
    /// There is a header and nothing else.
    #[error("{file}: no rows below the header")]
    NoRows {
        /// The file.
        file: String,
    },
}

/// A set point of a trajectory that is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("at {t_s} s: {refused}")]
#[non_exhaustive]
pub struct AboveLimitAt {
    /// Time of its row, s.
    pub t_s: f64,
    /// Which set point, and its limit.
    pub refused: AboveLimit,
}
