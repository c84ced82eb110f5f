//! Rows of several rollouts side by side.

use super::source::RowSource;
use crate::numeric::{Lanes, Scalar};

/// Inputs of `L` rollouts in lockstep. A rollout shorter than the longest repeats its last row.
#[derive(Debug, Clone)]
pub struct GatheredRows<'a, const L: usize> {
    inputs: [&'a [f64]; L],
    /// All lanes read the same slice.
    shared: bool,
    row: Vec<Lanes<L>>,
}

impl<'a, const L: usize> GatheredRows<'a, L> {
    /// One slice of rows of `width` columns per lane, each with a row at least. The same slice may
    /// be given to several lanes.
    #[must_use]
    pub fn new(inputs: [&'a [f64]; L], width: usize) -> Self {
        let shared = inputs.iter().all(|lane| std::ptr::eq(*lane, inputs[0]));
        Self { inputs, shared, row: vec![Lanes::constant(0.0); width] }
    }
}

impl<const L: usize> RowSource<Lanes<L>> for GatheredRows<'_, L> {
    #[inline(always)]
    fn row(&mut self, k: usize) -> &[Lanes<L>] {
        let width = self.row.len();
        if self.shared {
            let from = (k * width).min(self.inputs[0].len() - width);
            let values = &self.inputs[0][from..from + width];
            for column in 0..width {
                self.row[column] = Lanes::constant(values[column]);
            }
            return &self.row;
        }
        for (lane, inputs) in self.inputs.iter().enumerate() {
            let from = (k * width).min(inputs.len() - width);
            let values = &inputs[from..from + width];
            for column in 0..width {
                self.row[column].0[lane] = values[column];
            }
        }
        &self.row
    }
}
