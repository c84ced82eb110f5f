//! Fitting a channel's extended model on its fit blocks.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::likelihood::Whitening;
use crate::fit::{Normal, Objective};

/// The whitened residuals of some blocks as a function of the free parameters' coordinates.
pub struct BlockObjective<'a> {
    /// The channel.
    pub data: &'a ChannelData,
    /// Its weights.
    pub whitening: &'a Whitening,
    /// The model; its values are the start and hold what is not free.
    pub model: Extended,
    /// Positions of the free parameters.
    pub free: Vec<usize>,
    /// Which blocks count.
    pub roles: &'a [Role],
}

/// The whitened residuals of an objective and their derivatives where its model stands.
pub struct Derivatives {
    /// Derivatives by the free parameters, kPa, row by row.
    pub matrix: Vec<f64>,
    /// Residuals, simulated minus measured, kPa.
    pub residuals: Vec<f64>,
    /// Sum of their squares over the blocks that count, kPa^2.
    pub cost: f64,
}

impl BlockObjective<'_> {
    /// The model at given coordinates.
    #[must_use]
    pub fn model_at(&self, coordinates: &[f64]) -> Extended {
        let parameters = self.model.parameters(&self.data.plant);
        let mut model = self.model.clone();
        for (&position, &x) in self.free.iter().zip(coordinates) {
            let p = &parameters[position];
            let value = p.scale.value(x);
            model.values[position] = value.clamp(p.lower, p.upper);
        }
        model
    }

    /// Whitened residuals at all compared rows.
    #[must_use]
    pub fn whitened(&self, model: &Extended) -> Vec<f64> {
        let mut r = self.data.residuals(model);
        self.whitening.apply(&mut r);
        r
    }

    /// Derivatives where the model stands.
    #[must_use]
    pub fn derivatives(&self) -> Derivatives {
        let (residuals, matrix) = self.linear(&self.model);
        let cost = self.cost(&residuals);
        Derivatives { matrix, residuals, cost }
    }

    /// Whitened residuals of a model, simulated minus measured, and their derivatives.
    fn linear(&self, model: &Extended) -> (Vec<f64>, Vec<f64>) {
        let (readings, mut matrix) = self.data.sensitivities(model, &self.free);
        let mut r: Vec<f64> =
            readings.iter().zip(self.data.measured_kpa.iter()).map(|(y, m)| y - m).collect();
        self.whitening.apply(&mut r);
        self.whitening.apply_columns(&mut matrix, self.free.len());
        (r, matrix)
    }

    /// Sum of squares over the blocks that count.
    fn cost(&self, residuals: &[f64]) -> f64 {
        let counted =
            self.data.blocks.iter().zip(&self.data.spans).filter(|(b, _)| self.roles.contains(&b.role));
        counted.flat_map(|(_, span)| &residuals[span.clone()]).map(|v| v * v).sum()
    }
}

impl Objective for BlockObjective<'_> {
    fn dimension(&self) -> usize {
        self.free.len()
    }

    fn bounds(&self) -> Vec<(f64, f64)> {
        let parameters = self.model.parameters(&self.data.plant);
        self.free.iter().map(|&k| parameters[k].coordinate_bounds()).collect()
    }

    fn nominal(&self) -> Vec<f64> {
        let parameters = self.model.parameters(&self.data.plant);
        self.free.iter().map(|&k| parameters[k].scale.coordinate(self.model.values[k])).collect()
    }

    fn normal(&self, coordinates: &[f64]) -> Normal {
        let (r, matrix) = self.linear(&self.model_at(coordinates));
        normal_equations(self.data, self.roles, &r, &matrix, self.free.len())
    }

    fn last(&self, coordinates: &[f64]) -> Normal {
        let mut normal = Normal::zeros(self.free.len());
        normal.cost = self.cost(&self.whitened(&self.model_at(coordinates)));
        normal
    }

    fn residuals(&self) -> usize {
        let chosen =
            self.data.blocks.iter().zip(&self.data.spans).filter(|(b, _)| self.roles.contains(&b.role));
        chosen.map(|(_, span)| span.len()).sum()
    }

    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64)) {
        let (r, matrix) = self.linear(&self.model_at(coordinates));
        let n = self.free.len();
        for (index, (block, span)) in self.data.blocks.iter().zip(&self.data.spans).enumerate() {
            if self.roles.contains(&block.role) {
                for row in span.clone() {
                    let score = DVector::from_fn(n, |i, _| matrix[row * n + i] * r[row]);
                    sink(index, &score, r[row] * r[row]);
                }
            }
        }
    }
}

/// Sums over the blocks of some roles.
pub fn normal_equations(data: &ChannelData, roles: &[Role], r: &[f64], matrix: &[f64], n: usize) -> Normal {
    let mut normal = Normal::zeros(n);
    let mut upper = vec![0.0; n * n];
    let mut gradient = vec![0.0; n];
    for (block, span) in data.blocks.iter().zip(&data.spans) {
        if !roles.contains(&block.role) {
            continue;
        }
        for row in span.clone() {
            let j = &matrix[row * n..(row + 1) * n];
            normal.cost += r[row] * r[row];
            for a in 0..n {
                gradient[a] += j[a] * r[row];
                for b in a..n {
                    upper[a * n + b] += j[a] * j[b];
                }
            }
        }
    }
    normal.gradient = DVector::from_vec(gradient);
    normal.matrix = DMatrix::from_fn(n, n, |a, b| upper[a.min(b) * n + a.max(b)]);
    normal
}
