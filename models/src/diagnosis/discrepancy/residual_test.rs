//! What a residual depends on.
//!
//! A missing term `f(x)` in the rate of pressure is looked for as a sum of hat functions of a
//! variable `x` (drive, pressure, time, ...). The readings' derivatives by the hats' heights follow
//! from the simulation; the heights are fitted on the fit blocks and the correction they predict is
//! scored, with random signs, on blocks not fitted.

use crate::diagnosis::channel::HATS;
use crate::diagnosis::channel::Variable;
use crate::diagnosis::channel::hats;
use crate::diagnosis::channel::rows_of;
use crate::order::descending;
use nalgebra::{DMatrix, DVector};

use crate::diagnosis::channel::{ChannelData, Role};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::resampling::{generator, quantile, signs};
use crate::parallel;

const DRAWS: usize = 999;

/// A dependence on one channel.
#[derive(Debug, Clone)]
pub struct Dependence {
    /// The variable.
    pub variable: Variable,
    /// Channel, by position.
    pub channel: usize,
    /// Block-robust statistic.
    pub statistic: f64,
    /// Share of random-sign draws in which any variable of any channel reaches it.
    pub p_value: f64,
    /// Part of the squared whitened residual that it accounts for on blocks not fitted.
    pub share: f64,
    /// What it takes out of the sum of squared whitened residuals on the blocks where causes are
    /// chosen.
    pub explained: f64,
    /// Positions of the hats, in the variable's own unit.
    pub knots: Vec<f64>,
    scores: Vec<f64>,
}

/// Positions of hats over the values that a variable takes.
#[must_use]
pub fn knots(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (quantile(&sorted, 0.01), quantile(&sorted, 0.99));
    // Half by frequency, half by range: neither empty hats nor all of them where the data crowd.
    (0..HATS)
        .map(|k| {
            let share = k as f64 / (HATS - 1) as f64;
            0.5 * quantile(&sorted, 0.01 + 0.98 * share) + 0.5 * (low + share * (high - low))
        })
        .collect()
}

/// Tests all variables of all channels; strongest first.
#[must_use]
pub fn dependences(channels: &[ChannelData], stages: &[ChannelStage]) -> Vec<Dependence> {
    let of_channel = |(channel, (data, stage)): (usize, (&ChannelData, &ChannelStage))| {
        let trace = data.trace(&stage.model);
        // The shape of what a rate does is enough.
        let rough = data.rough();
        parallel::map(Variable::ALL, |variable| {
            let values = data.series(&trace, variable)?;
            dependence((data, &rough), stage, channel, variable, &values)
        })
    };
    let tested = parallel::map(channels.iter().zip(stages).enumerate(), of_channel);
    let mut found: Vec<Dependence> = tested.into_iter().flatten().flatten().collect();
    let length = found.iter().map(|d| d.scores.len()).max().unwrap_or(0);
    let mut rng = generator(3);
    let mut draws: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let s = signs(&mut rng, length);
            found.iter().map(|d| d.scores.iter().zip(&s).map(|(z, s)| z * s).sum::<f64>()).fold(0.0, f64::max)
        })
        .collect();
    draws.sort_by(f64::total_cmp);
    for d in &mut found {
        let reached = draws.iter().filter(|v| **v >= d.statistic).count();
        d.p_value = (reached + 1) as f64 / (DRAWS + 1) as f64;
    }
    descending(&mut found, |item| item.share);
    found
}

fn dependence(
    (data, rough): (&ChannelData, &ChannelData),
    stage: &ChannelStage,
    channel: usize,
    variable: Variable,
    values: &[f64],
) -> Option<Dependence> {
    let knots = knots(values);
    if !(knots[HATS - 1] > knots[0]) {
        return None;
    }
    let weights: Vec<[f64; HATS]> = values.iter().map(|v| hats(&knots, *v)).collect();
    let raw = rough.rate_derivatives(&stage.model, &weights);
    let mut white: Vec<f64> = raw.iter().flatten().map(|v| v / data.noise_kpa).collect();
    stage.whitening.apply_columns(&mut white, HATS);
    // What the model's own parameters could do instead is not a dependence.
    let mut columns: Vec<Vec<f64>> =
        (0..HATS).map(|h| white.iter().skip(h).step_by(HATS).copied().collect()).collect();
    for column in &mut columns {
        let along = stage.project(data, column);
        stage.remove(column, &along);
    }
    let fit: Vec<usize> = rows_of(data, &[Role::Fit]);
    let mut gram = DMatrix::<f64>::zeros(HATS, HATS);
    let mut right = DVector::<f64>::zeros(HATS);
    for &row in &fit {
        for a in 0..HATS {
            right[a] += columns[a][row] * stage.residuals[row];
            for b in 0..HATS {
                gram[(a, b)] += columns[a][row] * columns[b][row];
            }
        }
    }
    let ridge = 1e-3 * gram.trace() / HATS as f64 + 1e-9;
    for k in 0..HATS {
        gram[(k, k)] += ridge;
    }
    let heights = gram.cholesky()?.solve(&right);
    let predicted = |row: usize| (0..HATS).map(|h| columns[h][row] * heights[h]).sum::<f64>();
    let mut scores = Vec::new();
    let (mut before, mut after, mut explained) = (0.0, 0.0, 0.0);
    for (block, span) in data.blocks.iter().zip(&data.spans) {
        if block.role == Role::Fit {
            continue;
        }
        let half = span.start + span.len() / 2;
        for range in [span.start..half, half..span.end] {
            let mut score = 0.0;
            for row in range {
                let (r, d) = (stage.residuals[row], predicted(row));
                score += r * d;
                before += r * r;
                after += (r - d) * (r - d);
                if block.role == Role::Select {
                    explained += r * r - (r - d) * (r - d);
                }
            }
            scores.push(score);
        }
    }
    let length = scores.iter().map(|z| z * z).sum::<f64>().sqrt();
    if length > 0.0 {
        scores.iter_mut().for_each(|z| *z /= length);
    }
    Some(Dependence {
        variable,
        channel,
        statistic: scores.iter().sum(),
        p_value: 1.0,
        share: (1.0 - after / before).max(0.0),
        explained,
        knots,
        scores,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_ascend_over_nearly_the_whole_range() {
        // Most values in a small part of it.
        let values: Vec<f64> =
            (0..1000).map(|k| if k < 900 { 1e-4 * f64::from(k) } else { f64::from(k) }).collect();
        let knots = knots(&values);
        assert!(knots.windows(2).all(|pair| pair[0] < pair[1]), "{knots:?}");
        assert!(knots[0] < 0.002 && knots[HATS - 1] > 980.0, "{knots:?}");
    }
}
