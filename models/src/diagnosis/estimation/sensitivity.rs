//! Derivatives of the readings by a model's parameters.

use super::finite_difference::secants;
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::likelihood::hunts;
use crate::effects::{NARROW, SENSITIVITIES, Simulated, Undisturbed};
use crate::model::{Parameter, Scale};
use crate::numeric::{Dual, Scalar, Slope};

impl ChannelData {
    /// Readings and their derivatives by the parameters whose positions are listed, row by row. On
    /// a logarithmic scale the derivative is by the logarithm. Of a loop that hunts, secants take
    /// the place of derivatives. Those of a base model, where everything begins, are in double
    /// precision: along what can hardly be told apart, the last digits of single ones decide where
    /// a fit ends.
    #[must_use]
    pub fn sensitivities(&self, model: &Extended, free: &[usize]) -> (Vec<f64>, Vec<f64>) {
        if hunts(self, model) {
            return secants(self, model, free);
        }
        let parameters = model.parameters(&self.plant);
        let mut readings = Vec::with_capacity(self.rows.len());
        let mut matrix = vec![0.0; self.rows.len() * free.len()];
        let base = model.effects.iter().all(|effect| !model.has(*effect));
        let (width, differentiate): (usize, Differentiate) = match (base, free.len() <= NARROW) {
            (true, _) => (NARROW, Self::differentiate::<NARROW, f64>),
            (false, true) => (NARROW, Self::differentiate::<NARROW, f32>),
            (false, false) => (SENSITIVITIES, Self::differentiate::<SENSITIVITIES, f32>),
        };
        for (k, part) in free.chunks(width).enumerate() {
            let into = Part { first: k * width, of: free.len(), part };
            differentiate(self, model, &parameters, &into, &mut readings, &mut matrix);
        }
        if free.is_empty() {
            readings = self.readings(model);
        }
        (readings, matrix)
    }

    fn differentiate<const N: usize, G: Slope<f64> + Into<f64>>(
        &self,
        model: &Extended,
        parameters: &[Parameter],
        into: &Part<'_>,
        readings: &mut Vec<f64>,
        matrix: &mut [f64],
    ) where
        Dual<f64, N, G>: Simulated<Real = f64>,
    {
        let mut values: Vec<Dual<f64, N, G>> = model.values.iter().map(|v| Dual::constant(*v)).collect();
        for (k, &position) in into.part.iter().enumerate() {
            let variable = Dual::<f64, N, G>::variable(model.values[position], k);
            values[position] = match parameters[position].scale {
                Scale::Linear => variable,
                Scale::Logarithmic => variable.chain(variable.value, variable.value),
            };
        }
        let run = self.run(model, &values, &Undisturbed);
        readings.clear();
        for (row, reading) in run.iter().enumerate() {
            readings.push(reading.value);
            let at = row * into.of + into.first;
            for (to, slope) in matrix[at..at + into.part.len()].iter_mut().zip(reading.gradient) {
                *to = slope.into();
            }
        }
    }
}

/// [`ChannelData::differentiate`] with one kind of number.
type Differentiate = fn(&ChannelData, &Extended, &[Parameter], &Part<'_>, &mut Vec<f64>, &mut [f64]);

/// A part of the columns of a matrix of derivatives.
struct Part<'a> {
    first: usize,
    of: usize,
    part: &'a [usize],
}

#[cfg(test)]
mod tests {
    use crate::diagnosis::channel::{ChannelData, Extended};
    use crate::diagnosis::testing::{channel, with};

    /// Are the slopes by a model's first parameters all numbers of single precision?
    fn is_single(data: &ChannelData, model: &Extended) -> bool {
        let (_, slopes) = data.sensitivities(model, &[0, 1, 2]);
        assert!(slopes.iter().any(|slope| slope.abs() > 0.0), "nothing depends on them");
        #[allow(clippy::cast_possible_truncation)] // that is the question
        slopes.iter().all(|&slope| f64::from(slope as f32).to_bits() == slope.to_bits())
    }

    #[test]
    fn slopes_of_a_base_model_are_in_double_precision_and_others_in_single() {
        let (data, base) = channel(false);
        assert!(!is_single(&data, &base));
        assert!(is_single(&data, &with(&data, &base, "valve_lag", &[0.02])));
    }
}
