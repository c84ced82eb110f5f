use std::path::PathBuf;
use thiserror::Error;

/// A recording that cannot be made, or stopped.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The name's ending says nothing about the format.
    #[error("{file}: a recording's name ends in .csv, .csv.gz, .csv.zst or .mcap", file = .file.display())]
    UnknownFormat {
        /// The file.
        file: PathBuf,
    },
    /// Several buses in a table.
    #[error("{file}: a recording of several buses is a bag, whose name ends in .mcap", file = .file.display())]
    NotABag {
        /// The file.
        file: PathBuf,
    },
    /// It is there already.
    #[error("{file}: exists; choose another name, or pass --overwrite", file = .file.display())]
    Exists {
        /// The file.
        file: PathBuf,
    },
    /// The file cannot be made.
    #[error("{file}: cannot be created: {reason}", file = .file.display())]
    NotCreated {
        /// The file.
        file: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The disk is full or failed. What was written before is whole.
    #[error("{file}: writing failed after {rows} rows: {reason}", file = .file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Rows that are in the file.
        rows: u64,
        /// What the system said.
        reason: String,
    },
    /// The disk was too slow for too long.
    #[error("{file}: {lost} rows were not recorded because the disk was too slow", file = .file.display())]
    TooSlow {
        /// The file.
        file: PathBuf,
        /// Rows that are missing.
        lost: u64,
    },
}
