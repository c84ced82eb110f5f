//! Rows of inputs fetched from the columns of a batch, for lanes or for one rollout.

use super::columns::{BatchColumn, BatchInputs, within};
use super::source::RowSource;
use crate::numeric::{Lanes, Scalar};

impl BatchInputs<'_> {
    /// One rollout alone.
    pub(super) fn job(&self, job: usize) -> JobRow<'_> {
        JobRow { inputs: self, job, row: vec![0.0; self.columns.len()] }
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

impl<const L: usize> RowSource<Lanes<L>> for ColumnRows<'_, L> {
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

/// Rows of one rollout.
#[derive(Debug)]
pub(super) struct JobRow<'a> {
    inputs: &'a BatchInputs<'a>,
    job: usize,
    row: Vec<f64>,
}

impl RowSource<f64> for JobRow<'_> {
    fn row(&mut self, k: usize) -> &[f64] {
        for (value, column) in self.row.iter_mut().zip(&self.inputs.columns) {
            *value = column.at(self.job, k, self.inputs.rows);
        }
        &self.row
    }
}
