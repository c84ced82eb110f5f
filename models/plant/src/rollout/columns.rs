//! Inputs of a batch, column by column: what is the same for all rollouts, or for all rows, is kept
//! once.

use super::job::BatchError;
use crate::model::column;

/// The values of a column, in either precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BatchValues<'a> {
    /// In double precision.
    Double(&'a [f64]),
    /// In single precision.
    Single(&'a [f32]),
}

impl BatchValues<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Double(values) => values.len(),
            Self::Single(values) => values.len(),
        }
    }

    #[inline(always)]
    fn at(&self, index: usize) -> f64 {
        match self {
            Self::Double(values) => values[index],
            Self::Single(values) => f64::from(values[index]),
        }
    }

    /// The first value that is not within a range.
    fn outside(&self, range: [f64; 2]) -> Option<usize> {
        match self {
            Self::Double(values) => values.iter().position(|value| !within(*value, range)),
            Self::Single(values) => values.iter().position(|value| !within(f64::from(*value), range)),
        }
    }

    /// Whether it is the same memory.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Double(a), Self::Double(b)) => std::ptr::eq(*a, *b),
            (Self::Single(a), Self::Single(b)) => std::ptr::eq(*a, *b),
            _ => false,
        }
    }
}

impl<'a> From<&'a [f64]> for BatchValues<'a> {
    fn from(values: &'a [f64]) -> Self {
        Self::Double(values)
    }
}

impl<'a> From<&'a Vec<f64>> for BatchValues<'a> {
    fn from(values: &'a Vec<f64>) -> Self {
        Self::Double(values)
    }
}

impl<'a> From<&'a Vec<f32>> for BatchValues<'a> {
    fn from(values: &'a Vec<f32>) -> Self {
        Self::Single(values)
    }
}

impl<'a> From<&'a [f32]> for BatchValues<'a> {
    fn from(values: &'a [f32]) -> Self {
        Self::Single(values)
    }
}

/// One input of all rollouts: `offset + factor * value`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchColumn<'a> {
    /// None for a constant.
    pub(super) values: BatchValues<'a>,
    constant: f64,
    pub(super) by_job: bool,
    pub(super) by_row: bool,
    pub(super) factor: f64,
    pub(super) offset: f64,
    /// What the values must be within; they may be anything without it.
    pub(super) range: Option<[f64; 2]>,
}

impl<'a> BatchColumn<'a> {
    /// The same for all rollouts and rows.
    #[must_use]
    pub const fn constant(value: f64) -> Self {
        Self {
            values: BatchValues::Double(&[]),
            constant: value,
            by_job: false,
            by_row: false,
            factor: 1.0,
            offset: 0.0,
            range: None,
        }
    }

    /// The same for all rollouts, one value per row.
    #[must_use]
    pub const fn per_row(values: &'a [f64]) -> Self {
        let values = BatchValues::Double(values);
        Self { values, constant: 0.0, by_job: false, by_row: true, factor: 1.0, offset: 0.0, range: None }
    }

    /// The same for all rows, one value per rollout.
    #[must_use]
    pub const fn per_job(values: &'a [f64]) -> Self {
        let values = BatchValues::Double(values);
        Self { values, constant: 0.0, by_job: true, by_row: false, factor: 1.0, offset: 0.0, range: None }
    }

    /// `[rollout][row]`, in either precision.
    #[must_use]
    pub fn per_job_and_row(values: impl Into<BatchValues<'a>>) -> Self {
        let values = values.into();
        Self { values, constant: 0.0, by_job: true, by_row: true, factor: 1.0, offset: 0.0, range: None }
    }

    /// The same in another unit: `offset + factor * value`.
    #[must_use]
    pub fn scaled(self, factor: f64, offset: f64) -> Self {
        Self { factor: factor * self.factor, offset: offset + factor * self.offset, ..self }
    }

    /// The values, as they are before [`scaled`](Self::scaled), must be within `[lowest, highest]`.
    ///
    /// Those of `[rollout][row]` are looked at when they are fetched: that costs less than another
    /// pass over so many.
    #[must_use]
    pub fn within(self, range: [f64; 2]) -> Self {
        Self { range: Some(range), ..self }
    }

    /// Whether the values are looked at while they are fetched.
    fn checked_late(&self) -> bool {
        self.by_job && self.by_row
    }

    /// The first value out of range: its place and itself.
    fn outside(&self) -> Option<(usize, f64)> {
        let range = self.range?;
        if !(self.by_job || self.by_row) {
            return (!within(self.constant, range)).then_some((0, self.constant));
        }
        let at = self.values.outside(range)?;
        Some((at, self.values.at(at)))
    }

    fn expected(&self, jobs: usize, rows: usize) -> usize {
        match (self.by_job, self.by_row) {
            (false, false) => 0,
            (false, true) => rows,
            (true, false) => jobs,
            (true, true) => jobs * rows,
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, job: usize, row: usize, rows: usize) -> f64 {
        let index = match (self.by_job, self.by_row) {
            (false, false) => return self.offset + self.factor * self.constant,
            (false, true) => row,
            (true, false) => job,
            (true, true) => job * rows + row,
        };
        self.offset + self.factor * self.values.at(index)
    }
}

/// False for NaN.
#[inline(always)]
fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    (value >= low) & (value <= high)
}

/// Inputs of all rollouts of a batch, in the columns of [`mod@column`].
#[derive(Debug, Clone, PartialEq)]
pub struct BatchInputs<'a> {
    pub(super) columns: Vec<BatchColumn<'a>>,
    pub(super) jobs: usize,
    pub(super) rows: usize,
}

impl<'a> BatchInputs<'a> {
    /// Inputs of `jobs` rollouts over `rows` rows; the interval's length must be the same for all
    /// rollouts.
    ///
    /// # Errors
    /// [`BatchError::Columns`] or [`BatchError::Values`] when the sizes do not fit,
    /// [`BatchError::Range`] for what can be seen at little cost.
    pub fn new(columns: Vec<BatchColumn<'a>>, jobs: usize, rows: usize) -> Result<Self, BatchError> {
        if columns.len() < column::COUNT {
            return Err(BatchError::Columns { columns: columns.len() });
        }
        for (index, column) in columns.iter().enumerate() {
            let (expected, found) = (column.expected(jobs, rows), column.values.len());
            if expected != found {
                return Err(BatchError::Values { column: index, expected, found });
            }
        }
        let inputs = Self { columns, jobs, rows };
        inputs.check(|column| !column.checked_late())?;
        Ok(inputs)
    }

    /// Looks at every value of some of the columns.
    fn check(&self, which: impl Fn(&BatchColumn<'_>) -> bool) -> Result<(), BatchError> {
        for (index, column) in self.columns.iter().enumerate().filter(|(_, column)| which(column)) {
            let Some((at, value)) = column.outside() else { continue };
            let (job, row) = match (column.by_job, column.by_row) {
                (true, true) => (at / self.rows, at % self.rows),
                (true, false) => (at, 0),
                _ => (0, at),
            };
            return Err(BatchError::Range { column: index, job, row, value });
        }
        Ok(())
    }

    /// Looks at the values that are otherwise looked at when they are fetched.
    ///
    /// # Errors
    /// [`BatchError::Range`] for the first that is out of range.
    pub fn check_late(&self) -> Result<(), BatchError> {
        self.check(|column| column.checked_late())
    }

    /// Number of rollouts.
    #[must_use]
    pub fn jobs(&self) -> usize {
        self.jobs
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Whether an input is the same for all rollouts.
    #[must_use]
    pub fn is_shared(&self, column: usize) -> bool {
        !self.columns[column].by_job
    }

    /// One input of one rollout.
    #[must_use]
    pub fn value(&self, job: usize, row: usize, column: usize) -> f64 {
        self.columns[column].at(job, row, self.rows)
    }
}
