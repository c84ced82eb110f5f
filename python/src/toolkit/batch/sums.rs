//! Derivatives by arrays that broadcast: sums over whatever used a value.

use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// The derivative by an argument, in the shape that it was given in.
pub struct Sums {
    values: Vec<f64>,
    shape: Vec<usize>,
    chambers: usize,
    columns: usize,
}

impl Sums {
    /// Zeros for an array of shape (), (columns,) or (chambers, columns).
    pub fn of_rows(shape: &[usize]) -> Self {
        let (chambers, columns) = match *shape {
            [] => (1, 1),
            [columns] => (1, columns),
            [chambers, columns, ..] => (chambers, columns),
        };
        Self { values: vec![0.0; chambers * columns], shape: shape.to_vec(), chambers, columns }
    }

    /// Zeros for an array of shape () or (chambers,).
    pub fn of_chambers(shape: &[usize]) -> Self {
        let chambers = shape.first().copied().unwrap_or(1);
        Self { values: vec![0.0; chambers], shape: shape.to_vec(), chambers, columns: 1 }
    }

    /// Adds what one chamber at one row or parameter contributes.
    pub fn add(&mut self, chamber: usize, column: usize, slope: f64) {
        let chamber = if self.chambers == 1 { 0 } else { chamber };
        let column = if self.columns == 1 { 0 } else { column };
        self.values[chamber * self.columns + column] += slope;
    }

    pub fn into_array(self, py: Python<'_>) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
        numpy::PyArray1::from_vec(py, self.values).reshape(self.shape)
    }
}
