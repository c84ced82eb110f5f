//! The part that is fitted, and the part that judges.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::data::Recording;

/// How a recording is divided in time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// The first so many seconds are fitted.
    FitSeconds(f64),
    /// The first part of this share of the recording's length is fitted.
    FitFraction(f64),
}

/// A division that leaves too little on one side.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{file}: fitting the first {fit_seconds} s of {seconds:.3} s leaves {fit_rows} rows to fit and {test_rows} to judge by; both need {least} at least: name a shorter part to fit, or none"
)]
pub struct SplitError {
    /// The recording.
    pub file: String,
    /// Length of the part to fit, s.
    pub fit_seconds: f64,
    /// Length of the recording, s.
    pub seconds: f64,
    /// Rows in the part to fit.
    pub fit_rows: usize,
    /// Rows in the rest.
    pub test_rows: usize,
    /// Rows that each part needs.
    pub least: usize,
}

impl Split {
    /// Rows that each part needs at least: enough for the fit of ten parameters to be
    /// over-determined.
    pub const LEAST_ROWS: usize = 50;

    /// Rows to fit and rows to judge by.
    ///
    /// # Errors
    /// [`SplitError`] when one part is too small.
    pub fn rows(self, recording: &Recording) -> Result<[Range<usize>; 2], SplitError> {
        let fit_seconds = match self {
            Self::FitSeconds(seconds) => seconds,
            Self::FitFraction(share) => share * recording.duration_s(),
        };
        let (at, rows) = (recording.row_at(fit_seconds), recording.rows());
        if at < Self::LEAST_ROWS || rows - at < Self::LEAST_ROWS {
            return Err(SplitError {
                file: recording.source.file.clone(),
                fit_seconds,
                seconds: recording.duration_s(),
                fit_rows: at,
                test_rows: rows - at,
                least: Self::LEAST_ROWS,
            });
        }
        Ok([0..at, at..rows])
    }
}
