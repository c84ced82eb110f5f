//! A smooth correction of what no name fits: a term in the rate of pressure that depends on one variable.
//!
//! The variable (drive, pressure, time, ...) is taken from the simulation without the correction, so that the corrected simulation, too,
//! needs nothing but drives or commands.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::blocks::Role;
use super::candidate::bootstrap;
use super::channel::{ChannelData, Extended};
use super::dependence::{Dependence, HATS, Variable, hats, rows_of, series};
use super::stage::{ChannelStage, block_losses, whitened_residuals};
use crate::effects::Disturbance;
use crate::model::Scale;
use crate::numeric::Scalar;

/// Steps of the fit at most.
const STEPS: usize = 4;
/// Weight of the heights' own size against the data, as a part of the data's mean weight.
const RIDGE: f64 = 1e-3;

/// A term in the rate of pressure: a sum of hat functions of one variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// The variable.
    pub variable: Variable,
    /// Positions of the hats in the variable's own unit, ascending; beyond the ends the end's height holds.
    pub knots: Vec<f64>,
    /// Heights of the hats, kPa/s.
    pub heights: Vec<f64>,
}

impl Correction {
    /// Is it well formed: as many finite heights as ascending knots as a correction has?
    #[must_use]
    pub fn is_usable(&self) -> bool {
        let finite = self.knots.iter().chain(&self.heights).all(|v| v.is_finite());
        let ascending = self.knots.windows(2).all(|w| w[0] <= w[1]) && self.knots.first() < self.knots.last();
        finite && ascending && self.knots.len() == HATS && self.heights.len() == HATS
    }

    /// Its value over the interval that starts at each row, kPa/s; `trace` is that of the model without it. All zero where
    /// the variable does not change.
    #[must_use]
    pub fn rates(&self, data: &ChannelData, trace: &[[f64; 3]]) -> Vec<f64> {
        let Some(values) = series(data, trace, self.variable) else {
            return vec![0.0; trace.len()];
        };
        let at = |v: &f64| hats(&self.knots, *v).iter().zip(&self.heights).map(|(w, h)| w * h).sum();
        values.iter().map(at).collect()
    }
}

/// Adds a correction's rates to a simulation that may be disturbed otherwise.
pub struct Corrected<'a, D> {
    /// The other disturbance.
    pub inner: &'a D,
    /// Rates over the interval that starts at each row, kPa/s; empty without a correction.
    pub rates: &'a [f64],
    /// Lengths of the intervals, s.
    pub interval_s: &'a [f64],
}

impl<S: Scalar, D: Disturbance<S>> Disturbance<S> for Corrected<'_, D> {
    fn supply(&self, row: usize, supply: S) -> S {
        self.inner.supply(row, supply)
    }

    fn pressure(&self, row: usize, pressure: S) -> S {
        let pressure = self.inner.pressure(row, pressure);
        match row.checked_sub(1) {
            Some(before) if !self.rates.is_empty() => {
                pressure.plus(1e3 * self.rates[before] * self.interval_s[before])
            }
            _ => pressure,
        }
    }
}

/// Fits a correction along a dependence, the model's own parameters giving way. `None` when it does not make the blocks better that
/// were neither fitted nor are to measure the gain.
#[must_use]
pub fn fit_correction(data: &ChannelData, stage: &ChannelStage, along: &Dependence) -> Option<Extended> {
    let mut model = stage.model.clone();
    model.correction =
        Some(Correction { variable: along.variable, knots: along.knots.clone(), heights: vec![0.0; HATS] });
    let losses = |model: &Extended| {
        block_losses(data, &whitened_residuals(data, &stage.whitening, &data.readings(model)))
    };
    let of = |losses: &[f64], role: Role| -> Vec<f64> {
        data.blocks.iter().zip(losses).filter(|(b, _)| b.role == role).map(|(_, l)| *l).collect()
    };
    let before = losses(&model);
    let mut now = before.clone();
    for _ in 0..STEPS {
        let step = gauss_newton(data, stage, &model)?;
        let fit: f64 = of(&now, Role::Fit).iter().sum();
        let next = [1.0, 0.5, 0.25].into_iter().find_map(|part| {
            let tried = moved(data, stage, &model, &step, part);
            let losses = losses(&tried);
            let better = of(&losses, Role::Fit).iter().sum::<f64>() < fit;
            better.then_some((tried, losses))
        });
        let Some((tried, losses)) = next else { break };
        let gained = 1.0 - of(&losses, Role::Fit).iter().sum::<f64>() / fit;
        (model, now) = (tried, losses);
        if gained < 1e-3 {
            break;
        }
    }
    let (a, b) = (of(&before, Role::Select), of(&now, Role::Select));
    let [_, low, ..] = bootstrap(&a, &b, 1, |a, b| a - b);
    (low > 0.0).then_some(model)
}

/// The full step of free parameters (in their coordinates) and heights on the fit blocks.
fn gauss_newton(data: &ChannelData, stage: &ChannelStage, model: &Extended) -> Option<Vec<f64>> {
    let own = stage.free.len();
    let width = own + HATS;
    let (readings, mut parameters) = data.sensitivities(model, &stage.free);
    let correction = model.correction.as_ref()?;
    let plain = data.trace(&model.uncorrected());
    let values = series(data, &plain, correction.variable)?;
    let weights: Vec<[f64; HATS]> = values.iter().map(|v| hats(&correction.knots, *v)).collect();
    let mut heights: Vec<f64> = data.rate_derivatives(model, &weights).into_iter().flatten().collect();
    stage.whitening.apply_columns(&mut parameters, own);
    stage.whitening.apply_columns(&mut heights, HATS);
    let residuals = whitened_residuals(data, &stage.whitening, &readings);
    let mut gram = DMatrix::<f64>::zeros(width, width);
    let mut right = DVector::<f64>::zeros(width);
    for row in rows_of(data, &[Role::Fit]) {
        let of_parameters = &parameters[row * own..(row + 1) * own];
        let of_heights = &heights[row * HATS..(row + 1) * HATS];
        let j: Vec<f64> = of_parameters.iter().chain(of_heights).map(|v| v / data.noise_kpa).collect();
        for a in 0..width {
            right[a] += j[a] * residuals[row];
            for b in 0..width {
                gram[(a, b)] += j[a] * j[b];
            }
        }
    }
    let mean = (own..width).map(|k| gram[(k, k)]).sum::<f64>() / HATS as f64;
    for k in 0..width {
        if k < own {
            gram[(k, k)] = gram[(k, k)] * (1.0 + 1e-6) + 1e-12;
        } else {
            gram[(k, k)] += RIDGE * mean + 1e-9;
            right[k] -= RIDGE * mean * correction.heights[k - own];
        }
    }
    Some(gram.cholesky()?.solve(&right).as_slice().to_vec())
}

fn moved(data: &ChannelData, stage: &ChannelStage, model: &Extended, step: &[f64], part: f64) -> Extended {
    let mut next = model.clone();
    let parameters = model.parameters(&data.plant);
    for (&position, change) in stage.free.iter().zip(step) {
        let p = &parameters[position];
        let value = match p.scale {
            Scale::Linear => model.values[position] + part * change,
            Scale::Logarithmic => model.values[position] * (part * change).exp(),
        };
        next.values[position] = value.clamp(p.lower, p.upper);
    }
    if let Some(correction) = &mut next.correction {
        for (height, change) in correction.heights.iter_mut().zip(&step[stage.free.len()..]) {
            *height += part * change;
        }
    }
    next
}

#[cfg(test)]
mod tests {
    use super::super::testing::channel;
    use super::*;

    fn correction(heights: [f64; HATS]) -> Correction {
        Correction {
            variable: Variable::Drive,
            knots: vec![-0.7, -0.4, -0.1, 0.1, 0.3, 0.6],
            heights: heights.to_vec(),
        }
    }

    #[test]
    fn only_as_many_finite_heights_as_ascending_knots_are_usable() {
        let good = correction([1.0; HATS]);
        assert!(good.is_usable());
        let mut descending = good.clone();
        descending.knots.swap(0, 5);
        let mut infinite = good.clone();
        infinite.heights[2] = f64::NAN;
        let mut short = good.clone();
        short.heights.pop();
        let level = Correction { knots: vec![0.0; HATS], ..good };
        for wrong in [descending, infinite, short, level] {
            assert!(!wrong.is_usable(), "{wrong:?}");
        }
    }

    #[test]
    fn its_rate_is_the_height_at_a_knot_and_between_two_their_mean() {
        let (data, model) = channel(false);
        let mut trace = data.trace(&model);
        for (row, drive) in [(0, -0.4), (1, 0.2), (2, 0.9)] {
            trace[row][1] = drive;
        }
        let rates = correction([0.0, 3.0, 0.0, 2.0, 4.0, 7.0]).rates(&data, &trace);
        assert_eq!((rates[0], rates[2]), (3.0, 7.0));
        assert!((rates[1] - 3.0).abs() < 1e-12, "{}", rates[1]);
    }

    #[test]
    fn a_rate_fills_the_chamber_over_its_interval() {
        let (data, base) = channel(false);
        let mut model = base.clone();
        model.correction = Some(correction([2.0; HATS]));
        // 2 kPa/s over the 10 ms of row 0; what flows in row 0 does not know of it yet.
        let rise = data.trace(&model)[1][0] - data.trace(&base)[1][0];
        assert!((rise - 0.02).abs() < 1e-9, "{rise}");
    }
}
