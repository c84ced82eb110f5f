//! Range checks whose messages say what the key means.

use super::RigError;

/// Checks values of one file.
pub(super) struct Checker<'a> {
    pub file: &'a str,
}

impl Checker<'_> {
    /// `value` of `key` must lie in `low..=high` (`unit` may be empty).
    pub(super) fn within(
        &self,
        key: &'static str,
        value: f64,
        (low, high): (f64, f64),
        unit: &'static str,
        advice: &'static str,
    ) -> Result<(), RigError> {
        // Written so that NaN fails.
        if value >= low && value <= high {
            return Ok(());
        }
        let space = if unit.is_empty() { "" } else { " " };
        Err(RigError::OutOfRange {
            file: self.file.to_owned(),
            key,
            value,
            range: format!("{low} to {high}{space}{unit}"),
            advice,
        })
    }

    /// A problem between keys.
    pub(super) fn inconsistent(&self, problem: impl Into<String>) -> RigError {
        RigError::Inconsistent { file: self.file.to_owned(), problem: problem.into() }
    }
}
