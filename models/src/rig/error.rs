//! What can be wrong with a rig file.

use std::io;

/// A rig file that cannot be used. Messages name the file, the key, the value and what to do.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The file could not be opened.
    #[error("{file}: cannot be opened: {source}")]
    Open {
        /// The file as given.
        file: String,
        /// The operating system's word.
        source: io::Error,
    },
    /// Not TOML, a value of the wrong type, or a required key missing.
    #[error("{file}: {message}")]
    Syntax {
        /// The file as given.
        file: String,
        /// What the TOML reader said, with line and column.
        message: String,
    },
    /// A table or key that means nothing.
    #[error("{file}: unknown key {key}; {advice}")]
    UnknownKey {
        /// The file as given.
        file: String,
        /// The key with its table, as in `chamber.radius`.
        key: String,
        /// The nearest known key, or the list of known ones.
        advice: String,
    },
    /// A value outside what is possible.
    #[error("{file}: {key} = {value} is not possible: it must be {range}; {advice}")]
    OutOfRange {
        /// The file as given.
        file: String,
        /// The key with its table.
        key: &'static str,
        /// The value given.
        value: f64,
        /// The allowed range, with unit.
        range: String,
        /// What the key means and a likely mistake.
        advice: &'static str,
    },
    /// Two keys that exclude each other, or a key that needs another.
    #[error("{file}: {problem}")]
    Inconsistent {
        /// The file as given.
        file: String,
        /// The sentence.
        problem: String,
    },
    /// The rig file lacks a table that the chosen work needs.
    #[error("the rig file has no table [{table}], which {purpose} needs")]
    MissingTable {
        /// The table's name.
        table: &'static str,
        /// What needs it.
        purpose: &'static str,
    },
}
