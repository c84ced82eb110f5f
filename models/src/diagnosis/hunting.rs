//! A loop that hunts.
//!
//! A loop around a spool with friction or play never rests, and two simulations that differ by next to nothing soon hunt out of
//! step. Nobody recorded the noise that the loop saw between the rows, so no simulation hunts in step with the recording either. How
//! far two of them are apart that differ in this noise alone is what a model may leave without being any worse for it.

use super::channel::{ChannelData, Extended};
use super::stage::block_losses;
use super::whiten::Whitening;
use crate::effects::catalogue::CATALOGUE;

/// Effects with which a board's loop hunts.
const HUNTING: [&str; 2] = ["valve_hysteresis", "valve_stiction"];
/// Courses of the noise over which a mean is taken.
const EXPECTED: u64 = 8;

/// Does the loop of this model hunt?
#[must_use]
pub fn hunts(data: &ChannelData, model: &Extended) -> bool {
    data.inputs.in_loop() && model.effects.iter().any(|&e| HUNTING.contains(&CATALOGUE[e].id))
}

/// What a reader of the report should know where a loop hunts.
#[must_use]
pub fn note(channels: &[ChannelData], models: &[Extended]) -> Option<String> {
    channels.iter().zip(models).any(|(data, model)| hunts(data, model)).then(|| {
        format!(
            "The loop hunts around the spool's play or friction, and no simulation hunts in step with it: the error with that cause is the one of the mean of {EXPECTED} simulations, each with a noise of its own."
        )
    })
}

/// What hunting out of step adds to the sum of squared whitened residuals of every block, in variances of the noise; nothing where a loop
/// does not hunt.
#[must_use]
pub fn out_of_step(data: &ChannelData, whitening: &Whitening, model: &Extended) -> Vec<f64> {
    if !hunts(data, model) {
        return vec![0.0; data.spans.len()];
    }
    let mut other = data.clone();
    if let Some(board) = &mut other.plant.board {
        board.noise_draw += 1;
    }
    let mut apart = other.readings(model);
    apart.iter_mut().zip(data.readings(model)).for_each(|(a, b)| *a = (*a - b) / data.noise_kpa);
    whitening.apply(&mut apart);
    // The difference has both simulations' share.
    block_losses(data, &apart).into_iter().map(|apart| 0.5 * apart).collect()
}

/// What a model leaves in every block.
#[derive(Debug, Clone)]
pub struct Losses {
    /// Sum of squared whitened residuals in variances of the noise, without what hunting out of step adds: the error of the mean over
    /// all courses of the noise.
    pub fair: Vec<f64>,
    /// Minus twice the logarithm of a Gaussian likelihood whose variance is that of the noise and of the simulated hunting, up to a
    /// constant: a model that hunts must hunt as far as the recording. The same as `fair` where a loop does not hunt.
    pub deviance: Vec<f64>,
}

impl Losses {
    /// Of a model with these whitened residuals, in standard deviations of the noise.
    #[must_use]
    pub fn new(data: &ChannelData, whitening: &Whitening, model: &Extended, residuals: &[f64]) -> Self {
        let apart = out_of_step(data, whitening, model);
        let fair: Vec<f64> =
            block_losses(data, residuals).into_iter().zip(&apart).map(|(loss, apart)| loss - apart).collect();
        let deviance = |((fair, apart), span): ((&f64, &f64), &std::ops::Range<usize>)| {
            let rows = span.len().max(1) as f64;
            let variance = 1.0 + apart / rows;
            fair / variance + rows * variance.ln()
        };
        let deviance = fair.iter().zip(&apart).zip(&data.spans).map(deviance).collect();
        Self { fair, deviance }
    }
}

/// Readings as they are expected: of a loop that hunts, the mean over some courses of the noise.
#[must_use]
pub fn expected_readings(data: &ChannelData, model: &Extended) -> Vec<f64> {
    let mut sum = data.readings(model);
    if hunts(data, model) {
        let mut other = data.clone();
        for draw in 1..EXPECTED {
            if let Some(board) = &mut other.plant.board {
                board.noise_draw = draw;
            }
            sum.iter_mut().zip(other.readings(model)).for_each(|(sum, y)| *sum += y);
        }
        sum.iter_mut().for_each(|sum| *sum /= EXPECTED as f64);
    }
    sum
}
