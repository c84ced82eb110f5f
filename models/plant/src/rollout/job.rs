//! What a batch is made of.

use crate::model::column;

/// Rollouts in lockstep without sensitivities; batches of multiples of it leave no lane empty.
///
/// Four 512-bit vectors: a Runge-Kutta step is one chain of operations, and one or two vectors
/// would wait for each result. What bounds it then are the square roots (docs/performance.md).
pub const BATCH_LANES: usize = 32;

/// The same in single precision: as many vectors, twice as wide in numbers.
pub const SINGLE_LANES: usize = 64;

/// One rollout of a batch; its inputs are in [`BatchInputs`](super::BatchInputs).
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// Parameters in the order and units of [`System::parameters`](super::System::parameters).
    pub parameters: &'a [f64],
    /// Absolute pressure at the first row, Pa.
    pub start: f64,
}

/// What pressures are counted in: `(p - zero_pa) per_pa` of an absolute pressure `p` in Pa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchUnit {
    /// Absolute pressure that counts as 0, Pa.
    pub zero_pa: f64,
    /// Units in a Pa.
    pub per_pa: f64,
}

impl BatchUnit {
    /// Absolute, Pa.
    pub const PASCAL: Self = Self { zero_pa: 0.0, per_pa: 1.0 };

    /// An absolute pressure in Pa, counted in it.
    #[must_use]
    pub fn of(&self, pa: f64) -> f64 {
        (pa - self.zero_pa) * self.per_pa
    }
}

/// Why a batch cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// Jobs and inputs are not equally many.
    #[error("{jobs} rollouts, but inputs of {inputs}")]
    Jobs {
        /// Rollouts.
        jobs: usize,
        /// Rollouts there are inputs for.
        inputs: usize,
    },
    /// Too few columns.
    #[error("{columns} input columns; there must be {least} at least", least = column::COUNT)]
    Columns {
        /// Columns given.
        columns: usize,
    },
    /// A column of the wrong size.
    #[error("input column {column} has {found} values, expected {expected}")]
    Values {
        /// The column.
        column: usize,
        /// Values expected.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// A value that its column does not allow.
    #[error("input column {column} is {value} at row {row} of rollout {job}")]
    Range {
        /// The column.
        column: usize,
        /// The rollout; 0 if they share the column.
        job: usize,
        /// The row; 0 if they share the value.
        row: usize,
        /// The value, as given.
        value: f64,
    },
    /// Memory for the results that is too small or too large.
    #[error("room for {found} values of the results, expected {expected}")]
    Results {
        /// Values expected.
        expected: usize,
        /// Values there is room for.
        found: usize,
    },
    /// A model that is not differentiated.
    #[error(
        "a smooth correction follows a simulation without it, and has no derivatives: only pressures can be simulated with it"
    )]
    Correction,
    /// A job has the wrong number of parameters.
    #[error("job {job} has {found} parameters, the system has {expected}")]
    Parameters {
        /// The job.
        job: usize,
        /// Parameters of the system.
        expected: usize,
        /// Parameters of the job.
        found: usize,
    },
}
