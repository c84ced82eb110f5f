//! Rows of inputs, and how the interval between two of them is divided.

/// Where a rollout gets its rows of inputs from.
pub trait RowSource<R> {
    /// The inputs of row `k`; rows are asked for in order.
    fn row(&mut self, k: usize) -> &[R];
}

impl<R, T: RowSource<R> + ?Sized> RowSource<R> for &mut T {
    #[inline(always)]
    fn row(&mut self, k: usize) -> &[R] {
        (**self).row(k)
    }
}

/// Consecutive rows of plain numbers, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    /// The values.
    pub inputs: &'a [f64],
    /// Columns in a row.
    pub width: usize,
}

impl Rows<'_> {
    /// Number of rows.
    #[must_use]
    pub fn count(&self) -> usize {
        self.inputs.len() / self.width
    }
}

impl RowSource<f64> for Rows<'_> {
    #[inline(always)]
    fn row(&mut self, k: usize) -> &[f64] {
        &self.inputs[k * self.width..][..self.width]
    }
}

/// How a sample interval is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Ticks per interval, as the system asks for.
    pub ticks: usize,
    /// Runge-Kutta steps per tick.
    pub substeps: usize,
}
