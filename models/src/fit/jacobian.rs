//! Derivatives of more parameters than one simulation carries.

use nalgebra::{DMatrixView, DVectorView};

use super::Normal;

/// Residuals of one segment with their derivatives, row by row.
pub(super) struct Jacobian {
    pub directions: usize,
    pub residuals: Vec<f64>,
    pub slopes: Vec<f64>,
}

impl Jacobian {
    /// Adds the sums to the coordinates `indices`.
    pub fn add_to(&self, indices: &[usize], normal: &mut Normal) {
        let jacobian = DMatrixView::from_slice(&self.slopes, self.directions, self.residuals.len());
        let residuals = DVectorView::from_slice(&self.residuals, self.residuals.len());
        let (matrix, gradient) = (jacobian * jacobian.transpose(), jacobian * residuals);
        normal.cost += residuals.norm_squared();
        for (i, &row) in indices.iter().enumerate() {
            normal.gradient[row] += gradient[i];
            for (j, &column) in indices.iter().enumerate() {
                normal.matrix[(row, column)] += matrix[(i, j)];
            }
        }
    }
}
