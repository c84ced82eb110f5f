//! Where the search stands: the model of every channel, its whitened residuals and sensitivities.

use crate::diagnosis::channel::OPEN;
use crate::diagnosis::likelihood::whitened_residuals;
use nalgebra::{Cholesky, DVector, Dyn};

use super::objective::normal_equations;
use crate::diagnosis::channel::{ChannelData, Extended, Steps};
use crate::diagnosis::likelihood::{Losses, Whitening};

/// One channel's model and what follows from it.
#[derive(Debug, Clone)]
pub struct ChannelStage {
    /// The model.
    pub model: Extended,
    /// Positions of its free parameters.
    pub free: Vec<usize>,
    /// Weights.
    pub whitening: Whitening,
    /// Simulated readings, kPa.
    pub readings: Vec<f64>,
    /// Whitened residuals, measured minus simulated, in standard deviations of the noise.
    pub residuals: Vec<f64>,
    /// Whitened sensitivities of the readings, row by row, in the same unit.
    pub sensitivities: Vec<f64>,
    /// What it leaves.
    pub losses: Losses,
    /// The steps in which it was simulated.
    steps: Steps,
    /// Factor of the sensitivities' normal matrix over the open blocks.
    factor: Option<Cholesky<f64, Dyn>>,
}

/// The models of channels, one a channel.
#[must_use]
pub fn models_of(stages: &[ChannelStage]) -> Vec<Extended> {
    stages.iter().map(|stage| stage.model.clone()).collect()
}

impl ChannelStage {
    /// Evaluates a model.
    #[must_use]
    pub fn new(data: &ChannelData, model: Extended, free: Vec<usize>) -> Self {
        let whitening = Whitening::new(data, &data.disturbances(&model));
        Self::weighted(data, model, free, whitening)
    }

    /// Evaluates a model with given weights.
    #[must_use]
    pub fn weighted(data: &ChannelData, model: Extended, free: Vec<usize>, whitening: Whitening) -> Self {
        let (readings, mut sensitivities) = data.sensitivities(&model, &free);
        whitening.apply_columns(&mut sensitivities, free.len());
        let scale = 1.0 / data.noise_kpa;
        sensitivities.iter_mut().for_each(|v| *v *= scale);
        let residuals = whitened_residuals(data, &whitening, &readings);
        let mut normal = normal_equations(data, &OPEN, &residuals, &sensitivities, free.len());
        for (k, held) in held(data, &model, &free).into_iter().enumerate() {
            let stiffness = if held { HELD } else { 1.0 };
            normal.matrix[(k, k)] = normal.matrix[(k, k)] * (1.0 + 1e-9) * stiffness + 1e-12;
        }
        let factor = Cholesky::new(normal.matrix);
        let losses = Losses::of_one(data, &whitening, &model, &residuals);
        let steps = data.steps();
        Self { model, free, whitening, readings, residuals, sensitivities, losses, steps, factor }
    }

    /// The same model evaluated again, where the channel is simulated in other steps now. What its
    /// steps left would else look like an effect.
    pub fn renew(&mut self, data: &ChannelData) -> bool {
        let renewed = self.steps != data.steps();
        if renewed {
            *self = Self::new(data, self.model.clone(), self.free.clone());
        }
        renewed
    }

    /// Would a usual effect be more than is usual, if it were let?
    #[must_use]
    pub fn is_held(&self, data: &ChannelData, effect: usize) -> bool {
        let held = held(data, &self.model, &self.free);
        let range = self.model.range(&data.plant, effect).unwrap_or(0..0);
        self.free.iter().zip(held).any(|(k, held)| held && range.contains(k))
    }

    /// Where a parameter of this model is in one with an effect more; nowhere if it is a parameter
    /// of that effect.
    #[must_use]
    pub fn moved(&self, data: &ChannelData, position: usize, effect: usize) -> Option<usize> {
        match self.model.range(&data.plant, effect) {
            Some(own) => Some(position).filter(|position| !own.contains(position)),
            None => {
                let with = self.model.with_usual(&data.plant, effect);
                let inserted = with.range(&data.plant, effect)?;
                Some(if position < inserted.start { position } else { position + inserted.len() })
            }
        }
    }

    /// Coefficients of the sensitivities that take most out of a whitened series on the open
    /// blocks.
    #[must_use]
    pub fn project(&self, data: &ChannelData, series: &[f64]) -> Vec<f64> {
        let n = self.free.len();
        let mut gradient = vec![0.0; n];
        for (block, span) in data.blocks.iter().zip(&data.spans) {
            if OPEN.contains(&block.role) {
                for row in span.clone() {
                    let slopes = &self.sensitivities[row * n..(row + 1) * n];
                    for k in 0..n {
                        gradient[k] += slopes[k] * series[row];
                    }
                }
            }
        }
        match &self.factor {
            Some(factor) => factor.solve(&DVector::from_vec(gradient)).as_slice().to_vec(),
            None => vec![0.0; n],
        }
    }

    /// The series without its part along the sensitivities.
    pub fn remove(&self, series: &mut [f64], coefficients: &[f64]) {
        let n = self.free.len();
        for (row, value) in series.iter_mut().enumerate() {
            let slopes = &self.sensitivities[row * n..(row + 1) * n];
            let mut along = 0.0;
            for k in 0..n {
                along += slopes[k] * coefficients[k];
            }
            *value -= along;
        }
    }
}

/// By so much more stiffly than its own curvature a parameter is held: whatever else it could make
/// up for, it stays.
const HELD: f64 = 1e12;
/// A parameter so near to the end of what is usual, as a part of that, is at its end.
const AT_END: f64 = 1e-3;

/// Which of the free parameters are held at the end of what is usual.
fn held(data: &ChannelData, model: &Extended, free: &[usize]) -> Vec<bool> {
    let usual: Vec<std::ops::Range<usize>> =
        model.usual.iter().filter_map(|&effect| model.range(&data.plant, effect)).collect();
    let parameters = model.parameters(&data.plant);
    let at_end = |&k: &usize| {
        let (p, value) = (&parameters[k], model.values[k]);
        let margin = AT_END * (p.upper - p.lower);
        usual.iter().any(|range| range.contains(&k)) && (value - p.lower).min(p.upper - value) < margin
    };
    free.iter().map(at_end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, with};

    #[test]
    fn a_stage_is_evaluated_again_when_the_steps_are_others_and_only_then() {
        let (mut data, base) = channel(false);
        data.plant.longest_step_s = 0.01;
        // Fast enough for its steps to matter.
        let model = with(&data, &base, "valve_lag", &[0.01]);
        let mut stage = ChannelStage::new(&data, model, vec![0]);
        let before = stage.readings.clone();
        assert!(!stage.renew(&data));
        data.plant.longest_step_s = 0.0025;
        assert!(stage.renew(&data) && stage.readings != before);
        assert_eq!(stage.readings, data.readings(&stage.model));
        assert!(!stage.renew(&data));
    }
}
