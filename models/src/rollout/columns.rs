//! Inputs of a batch, column by column: what is the same for all rollouts, or for all rows, is kept once.

use super::BatchError;
use super::run::RowSource;
use crate::model::column;
use crate::numeric::{Lanes, Scalar};

/// One input of all rollouts: `offset + factor * value`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchColumn<'a> {
    /// None for a constant.
    values: &'a [f64],
    constant: f64,
    by_job: bool,
    by_row: bool,
    factor: f64,
    offset: f64,
    /// What the values must be within; they may be anything without it.
    range: Option<[f64; 2]>,
}

impl<'a> BatchColumn<'a> {
    /// The same for all rollouts and rows.
    #[must_use]
    pub const fn constant(value: f64) -> Self {
        Self {
            values: &[],
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
        Self { values, constant: 0.0, by_job: false, by_row: true, factor: 1.0, offset: 0.0, range: None }
    }

    /// The same for all rows, one value per rollout.
    #[must_use]
    pub const fn per_job(values: &'a [f64]) -> Self {
        Self { values, constant: 0.0, by_job: true, by_row: false, factor: 1.0, offset: 0.0, range: None }
    }

    /// `[rollout][row]`.
    #[must_use]
    pub const fn per_job_and_row(values: &'a [f64]) -> Self {
        Self { values, constant: 0.0, by_job: true, by_row: true, factor: 1.0, offset: 0.0, range: None }
    }

    /// The same in another unit: `offset + factor * value`.
    #[must_use]
    pub fn scaled(self, factor: f64, offset: f64) -> Self {
        Self { factor: factor * self.factor, offset: offset + factor * self.offset, ..self }
    }

    /// The values, as they are before [`scaled`](Self::scaled), must be within `[lowest, highest]`.
    ///
    /// Those of `[rollout][row]` are looked at when they are fetched: that costs less than another pass over so many.
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
        let own = [self.constant];
        let values = if self.by_job || self.by_row { self.values } else { &own };
        let at = values.iter().position(|value| !within(*value, range))?;
        Some((at, values[at]))
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
    fn at(&self, job: usize, row: usize, rows: usize) -> f64 {
        let index = match (self.by_job, self.by_row) {
            (false, false) => return self.offset + self.factor * self.constant,
            (false, true) => row,
            (true, false) => job,
            (true, true) => job * rows + row,
        };
        self.offset + self.factor * self.values[index]
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
    columns: Vec<BatchColumn<'a>>,
    jobs: usize,
    rows: usize,
}

impl<'a> BatchInputs<'a> {
    /// Inputs of `jobs` rollouts over `rows` rows; the interval's length must be the same for all rollouts.
    ///
    /// # Errors
    /// [`BatchError::Columns`] or [`BatchError::Values`] when the sizes do not fit, [`BatchError::Range`] for what can be seen at
    /// little cost.
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

    /// Where the value is that was out of range when it was fetched.
    pub(super) fn check_late(&self) -> Result<(), BatchError> {
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

    /// One input of one rollout.
    #[must_use]
    pub fn value(&self, job: usize, row: usize, column: usize) -> f64 {
        self.columns[column].at(job, row, self.rows)
    }

    /// Rollouts `first`, `first + 1`, ... side by side; spare lanes repeat the last.
    pub(super) fn lanes<const L: usize>(&self, first: usize) -> ColumnRows<'_, L> {
        let jobs: [usize; L] = std::array::from_fn(|lane| (first + lane).min(self.jobs - 1));
        let at = |column: &BatchColumn<'_>, row| Lanes(jobs.map(|job| column.at(job, row, self.rows)));
        let mut arrays: Vec<Varying<'_, L>> = Vec::new();
        for (index, column) in self.columns.iter().enumerate().filter(|(_, column)| column.by_row) {
            let place = Use { index, factor: column.factor, offset: column.offset };
            // A spool's fill and vent drives are one array, with either sign.
            let same = |known: &Varying<'_, L>| {
                std::ptr::eq(known.values, column.values)
                    && known.by_job == column.by_job
                    && known.range == column.range
            };
            match arrays.iter_mut().find(|known| same(known)) {
                Some(known) => known.uses.push(place),
                None => arrays.push(Varying {
                    values: column.values,
                    by_job: column.by_job,
                    first: jobs.map(|job| job * self.rows),
                    range: column.range,
                    possible: true,
                    uses: vec![place],
                    block: [Lanes::constant(0.0); BLOCK],
                }),
            }
        }
        let row = self.columns.iter().map(|column| at(column, 0)).collect();
        ColumnRows { arrays, row, rows: self.rows }
    }
}

/// Rows that are fetched at once: four cache lines of each rollout. With one line of each, a batch larger than the caches takes some
/// 5 % longer.
pub(super) const BLOCK: usize = 32;

/// Rows that are copied without a loop, a cache line.
pub(super) const LINE: usize = 8;

/// Where in the row an array goes, and in what unit.
#[derive(Debug, Clone, Copy)]
struct Use {
    index: usize,
    factor: f64,
    offset: f64,
}

/// An array whose values change from row to row.
#[derive(Debug)]
struct Varying<'a, const L: usize> {
    values: &'a [f64],
    by_job: bool,
    /// Where each lane's rollout begins.
    first: [usize; L],
    range: Option<[f64; 2]>,
    /// No value fetched so far was out of range.
    possible: bool,
    uses: Vec<Use>,
    /// The rows from the last multiple of `BLOCK` on.
    block: [Lanes<L>; BLOCK],
}

impl<const L: usize> Varying<'_, L> {
    /// Fetches the rows from `from` on, of `rows` in all.
    #[inline(always)]
    fn fetch(&mut self, from: usize, rows: usize) {
        let count = BLOCK.min(rows - from);
        if !self.by_job {
            for (lanes, value) in self.block.iter_mut().zip(&self.values[from..from + count]) {
                *lanes = Lanes::constant(*value);
            }
            return;
        }
        for lane in 0..L {
            let values = &self.values[self.first[lane] + from..][..count];
            let (lines, rest) = values.as_chunks::<LINE>();
            let (blocks, last) = self.block[..count].as_chunks_mut::<LINE>();
            for (rows, line) in blocks.iter_mut().zip(lines) {
                for i in 0..LINE {
                    rows[i].0[lane] = line[i];
                }
            }
            for (row, value) in last.iter_mut().zip(rest) {
                row.0[lane] = *value;
            }
        }
        if let Some(range) = self.range {
            // Without an early end the compiler looks at several at once.
            let all = |row: &Lanes<L>| row.0.iter().fold(true, |all, value| all & within(*value, range));
            self.possible &= self.block[..count].iter().fold(true, |possible, row| possible & all(row));
        }
    }
}

/// Rows of `L` rollouts in lockstep: only what changes is fetched.
#[derive(Debug)]
pub(super) struct ColumnRows<'a, const L: usize> {
    arrays: Vec<Varying<'a, L>>,
    row: Vec<Lanes<L>>,
    rows: usize,
}

impl<const L: usize> ColumnRows<'_, L> {
    /// Whether all values fetched so far were within their columns' ranges.
    pub(super) fn possible(&self) -> bool {
        self.arrays.iter().all(|array| array.possible)
    }
}

impl<const L: usize> RowSource<Lanes<L>> for &mut ColumnRows<'_, L> {
    #[inline(always)]
    fn row(&mut self, k: usize) -> &[Lanes<L>] {
        for array in &mut self.arrays {
            if k.is_multiple_of(BLOCK) {
                array.fetch(k, self.rows);
            }
            for Use { index, factor, offset } in &array.uses {
                self.row[*index] = array.block[k % BLOCK].times(*factor).plus(*offset);
            }
        }
        &self.row
    }
}
