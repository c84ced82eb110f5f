//! Derivatives of the readings by a model's parameters.

use super::finite_difference::secants;
use crate::diagnosis::channel::{ChannelData, Extended, NARROW};
use crate::diagnosis::likelihood::hunts;
use crate::effects::Undisturbed;
use crate::model::{Parameter, Scale};
use crate::numeric::Dual;

impl ChannelData {
    /// Readings and their derivatives by the parameters whose positions are listed, row by row. On a logarithmic scale the
    /// derivative is by the logarithm. Of a loop that hunts, secants take the place of derivatives.
    #[must_use]
    pub fn sensitivities(&self, model: &Extended, free: &[usize]) -> (Vec<f64>, Vec<f64>) {
        if hunts(self, model) {
            return secants(self, model, free);
        }
        let parameters = model.parameters(&self.plant);
        let mut readings = Vec::with_capacity(self.rows.len());
        let mut matrix = vec![0.0; self.rows.len() * free.len()];
        for (k, part) in free.chunks(NARROW).enumerate() {
            let into = Part { first: k * NARROW, of: free.len(), part };
            self.differentiate(model, &parameters, &into, &mut readings, &mut matrix);
        }
        if free.is_empty() {
            readings = self.readings(model);
        }
        (readings, matrix)
    }

    fn differentiate(
        &self,
        model: &Extended,
        parameters: &[Parameter],
        into: &Part<'_>,
        readings: &mut Vec<f64>,
        matrix: &mut [f64],
    ) {
        let mut values: Vec<Dual<f64, NARROW>> =
            model.values.iter().map(|v| Dual { value: *v, gradient: [0.0; NARROW] }).collect();
        for (k, &position) in into.part.iter().enumerate() {
            values[position].gradient[k] = match parameters[position].scale {
                Scale::Linear => 1.0,
                Scale::Logarithmic => model.values[position],
            };
        }
        let run = self.run(model, &values, &Undisturbed);
        readings.clear();
        for (row, reading) in run.iter().enumerate() {
            readings.push(reading.value);
            let at = row * into.of + into.first;
            matrix[at..at + into.part.len()].copy_from_slice(&reading.gradient[..into.part.len()]);
        }
    }
}

/// A part of the columns of a matrix of derivatives.
struct Part<'a> {
    first: usize,
    of: usize,
    part: &'a [usize],
}
