//! Rows of inputs fetched from the columns of a batch, for lanes or for one rollout.

use super::columns::{BatchColumn, BatchInputs, BatchValues};
use super::source::RowSource;
use crate::numeric::{Float, Lanes, Scalar};

impl BatchInputs<'_> {
    /// One rollout alone.
    pub(super) fn job(&self, job: usize) -> JobRow<'_> {
        JobRow { inputs: self, job, row: vec![0.0; self.columns.len()] }
    }

    /// Rollouts `first`, `first + 1`, ... side by side; spare lanes repeat the last.
    pub(super) fn lanes<const L: usize, T: Float>(&self, first: usize) -> ColumnRows<'_, L, T> {
        let jobs: [usize; L] = std::array::from_fn(|lane| (first + lane).min(self.jobs - 1));
        let at = |column: &BatchColumn<'_>, row| {
            Lanes(jobs.map(|job| T::from_f64(column.at(job, row, self.rows))))
        };
        let mut arrays: Vec<Varying<'_, L, T>> = Vec::new();
        for (index, column) in self.columns.iter().enumerate().filter(|(_, column)| column.by_row) {
            let place = Use { index, factor: column.factor, offset: column.offset };
            // A spool's fill and vent drives are one array, with either sign.
            let range = column.range.map(|range| range.map(T::from_f64));
            let same = |known: &Varying<'_, L, T>| {
                known.values.is_same(&column.values) && known.by_job == column.by_job && known.range == range
            };
            match arrays.iter_mut().find(|known| same(known)) {
                Some(known) => known.uses.push(place),
                None => arrays.push(Varying {
                    values: column.values,
                    by_job: column.by_job,
                    first: jobs.map(|job| job * self.rows),
                    range,
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

/// Rows that are fetched at once: four cache lines of each rollout. With one line of each, a batch
/// larger than the caches takes some 5 % longer.
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
struct Varying<'a, const L: usize, T> {
    values: BatchValues<'a>,
    by_job: bool,
    /// Where each lane's rollout begins.
    first: [usize; L],
    range: Option<[T; 2]>,
    /// No value fetched so far was out of range.
    possible: bool,
    uses: Vec<Use>,
    /// The rows from the last multiple of `BLOCK` on.
    block: [Lanes<L, T>; BLOCK],
}

impl<const L: usize, T: Float> Varying<'_, L, T> {
    /// Fetches the rows from `from` on, of `rows` in all.
    #[inline(always)]
    fn fetch(&mut self, from: usize, rows: usize) {
        let count = BLOCK.min(rows - from);
        match self.values {
            BatchValues::Double(values) => self.copy(values, from, count, T::from_f64),
            BatchValues::Single(values) => self.copy(
                values,
                from,
                count,
                #[inline(always)]
                |value| T::from_f32(value),
            ),
        }
        if let Some([low, high]) = self.range.filter(|_| self.by_job) {
            // Without an early end the compiler looks at several at once. False for NaN.
            let all = |row: &Lanes<L, T>| {
                row.0.iter().fold(true, |all, value| all & (*value >= low) & (*value <= high))
            };
            self.possible &= self.block[..count].iter().fold(true, |possible, row| possible & all(row));
        }
    }

    /// Copies `count` rows from `from` on of all lanes.
    #[inline(always)]
    fn copy<V: Copy>(&mut self, values: &[V], from: usize, count: usize, convert: impl Fn(V) -> T) {
        if !self.by_job {
            for (lanes, value) in self.block.iter_mut().zip(&values[from..from + count]) {
                *lanes = Lanes([convert(*value); L]);
            }
            return;
        }
        for lane in 0..L {
            let values = &values[self.first[lane] + from..][..count];
            let (lines, rest) = values.as_chunks::<LINE>();
            let (blocks, last) = self.block[..count].as_chunks_mut::<LINE>();
            for (rows, line) in blocks.iter_mut().zip(lines) {
                for i in 0..LINE {
                    rows[i].0[lane] = convert(line[i]);
                }
            }
            for (row, value) in last.iter_mut().zip(rest) {
                row.0[lane] = convert(*value);
            }
        }
    }
}

/// Rows of `L` rollouts in lockstep: only what changes is fetched.
#[derive(Debug)]
pub(super) struct ColumnRows<'a, const L: usize, T> {
    arrays: Vec<Varying<'a, L, T>>,
    row: Vec<Lanes<L, T>>,
    rows: usize,
}

impl<const L: usize, T: Float> ColumnRows<'_, L, T> {
    /// Whether all values fetched so far were within their columns' ranges.
    pub(super) fn possible(&self) -> bool {
        self.arrays.iter().all(|array| array.possible)
    }
}

impl<const L: usize, T: Float> RowSource<Lanes<L, T>> for ColumnRows<'_, L, T> {
    #[inline(always)]
    fn row(&mut self, k: usize) -> &[Lanes<L, T>] {
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
