//! Normal equations, summed up while the residuals stream by.

use nalgebra::{DMatrix, DVector};

use crate::numeric::{Dual, Real};

/// Sums over the residuals `r` with Jacobian `J`: all that a least-squares step needs, whatever the
/// number of residuals.
#[derive(Debug, Clone, PartialEq)]
pub struct Normal {
    /// `r^T r`.
    pub cost: f64,
    /// `J^T r`.
    pub gradient: DVector<f64>,
    /// `J^T J`.
    pub matrix: DMatrix<f64>,
}

impl Normal {
    /// No residuals yet.
    #[must_use]
    pub fn zeros(dimension: usize) -> Self {
        Self { cost: 0.0, gradient: DVector::zeros(dimension), matrix: DMatrix::zeros(dimension, dimension) }
    }

    /// Are all sums finite?
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        self.cost.is_finite() && finite(self.gradient.as_slice()) && finite(self.matrix.as_slice())
    }
}

/// Sums in progress, over `W` directions and, with lanes, several residuals at a time.
#[derive(Debug, Clone, Copy)]
pub struct Accumulator<R, const W: usize> {
    cost: R,
    gradient: [R; W],
    /// Upper triangle, by rows.
    matrix: [[R; W]; W],
}

impl<R: Real, const W: usize> Accumulator<R, W> {
    /// No residuals yet.
    #[must_use]
    #[inline(always)]
    pub fn new() -> Self {
        Self { cost: R::zero(), gradient: [R::zero(); W], matrix: [[R::zero(); W]; W] }
    }

    /// Adds a residual.
    #[inline(always)]
    pub fn add(&mut self, residual: &Dual<R, W>) {
        self.cost = self.cost + residual.value * residual.value;
        for i in 0..W {
            let slope = residual.gradient[i];
            self.gradient[i] = self.gradient[i] + slope * residual.value;
            for j in i..W {
                self.matrix[i][j] = self.matrix[i][j] + slope * residual.gradient[j];
            }
        }
    }

    /// Adds the sums of all lanes to `normal`.
    pub fn scatter_all(&self, indices: &[usize], normal: &mut Normal) {
        for lane in 0..R::LANES {
            self.scatter(lane, indices, normal);
        }
    }

    /// Adds the sums of one lane to `normal`; direction `i` belongs to coordinate `indices[i]`,
    /// further ones to none.
    pub fn scatter(&self, lane: usize, indices: &[usize], normal: &mut Normal) {
        normal.cost += self.cost.lane(lane);
        for (i, &row) in indices.iter().enumerate() {
            normal.gradient[row] += self.gradient[i].lane(lane);
            for (j, &column) in indices.iter().enumerate().skip(i) {
                let value = self.matrix[i][j].lane(lane);
                normal.matrix[(row, column)] += value;
                if i != j {
                    normal.matrix[(column, row)] += value;
                }
            }
        }
    }
}

impl<R: Real, const W: usize> Default for Accumulator<R, W> {
    fn default() -> Self {
        Self::new()
    }
}
