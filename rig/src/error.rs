//! What can be wrong with a rig file.

use thiserror::Error;

/// A rig file that cannot be used. Messages name the file, the line, the key, and what is expected.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RigError {
    /// It cannot be read.
    #[error("{file}: cannot be read: {error}")]
    Open {
        /// The file.
        file: String,
        /// The system's word.
        error: String,
    },
    /// It is no TOML.
    #[error("{file}:{line}: {problem}")]
    Syntax {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// What the TOML reader said.
        problem: String,
    },
    /// It is a table of numbers.
    #[error("{file}: expected a rig file (TOML), and this is a table, such as a recording or a trajectory")]
    Recording {
        /// The file.
        file: String,
    },
    /// A table or key that means nothing.
    #[error("{file}:{line}: unknown {what} {path}; {advice}")]
    Unknown {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// `key` or `table`.
        what: &'static str,
        /// The key with its table, as in `limits.max_pka`.
        path: String,
        /// The nearest known one, or all of them.
        advice: String,
    },
    /// A value of the wrong type or out of its range.
    #[error("{file}:{line}: {path} = {value}: expected {expected}")]
    Value {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// The key with its table.
        path: String,
        /// Its value.
        value: String,
        /// What is expected.
        expected: String,
    },
    /// A key is missing, or some exclude each other.
    #[error("{file}:{line}: [{table}] {problem}")]
    Table {
        /// The file.
        file: String,
        /// The table's line, counted from 1.
        line: usize,
        /// The table.
        table: String,
        /// What is wrong.
        problem: String,
    },
}

impl RigError {
    /// The message without file and line, for a rig that was not read from a file.
    #[must_use]
    pub fn sentence(&self) -> String {
        let place = match self {
            Self::Open { file, .. } | Self::Recording { file } => format!("{file}: "),
            Self::Syntax { file, line, .. }
            | Self::Unknown { file, line, .. }
            | Self::Value { file, line, .. }
            | Self::Table { file, line, .. } => format!("{file}:{line}: "),
        };
        let message = self.to_string();
        message.strip_prefix(&place).unwrap_or(&message).to_owned()
    }
}
