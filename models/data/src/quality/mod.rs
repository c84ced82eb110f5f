//! What is doubtful in a recording: found, counted, said in sentences, and masked.

mod finding;
mod missing;
mod odd_pressure;
mod order;
mod sampling;
mod saturated;
mod stuck;

pub use finding::{Finding, FindingKind, Span};
pub use sampling::Sampling;
pub use saturated::SensorLimits;

pub(crate) use missing::{hold_inputs, mark_missing_pressure, missing_for_long};
pub(crate) use odd_pressure::odd_pressure;
pub(crate) use order::keep_increasing;
pub(crate) use sampling::{find_breaks, sampling};
pub(crate) use saturated::mark_saturated;
pub(crate) use stuck::{Told, mark_stuck};

use serde::{Deserialize, Serialize};

/// What was found in a recording before anything was computed from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QualityReport {
    /// Data rows in the file.
    pub rows_read: usize,
    /// Rows kept.
    pub rows_kept: usize,
    /// Sampling rate and its regularity.
    pub sampling: Sampling,
    /// What was found, most basic first. Empty for a recording without blemish.
    pub findings: Vec<Finding>,
}

impl QualityReport {
    /// The findings of one kind.
    pub fn of_kind(&self, kind: FindingKind) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |f| f.kind == kind)
    }

    /// One sentence per finding, the sampling first. What is the same of several channels, as a
    /// lost exchange is of all four of its board, is said once.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let mut said: Vec<(String, Vec<String>, &Finding)> = Vec::new();
        for finding in &self.findings {
            let (pattern, column) = finding.without_column();
            match said.iter_mut().find(|(same, _, first)| *same == pattern && first.spans == finding.spans) {
                Some((_, columns, _)) => columns.extend(column),
                None => said.push((pattern, column.into_iter().collect(), finding)),
            }
        }
        let whole = |(pattern, columns, _): (String, Vec<String>, &Finding)| {
            pattern.replace(finding::COLUMN, &columns.join(", "))
        };
        std::iter::once(self.sampling.sentence()).chain(said.into_iter().map(whole)).collect()
    }
}
