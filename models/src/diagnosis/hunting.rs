//! A loop that hunts.
//!
//! A loop around a spool with friction or play never rests, and two simulations that differ by next to nothing soon hunt out of
//! step. Nobody recorded the noise that the loop saw between the rows, so no simulation hunts in step with the recording either. How
//! far two of them are apart that differ in this noise alone is what a model may leave without being any worse for it.

use super::blocks::Role;
use super::channel::{ChannelData, Extended};
use super::candidate::total;
use super::stage::{OPEN, block_losses, whitened_residuals};
use super::whiten::Whitening;
use crate::effects::catalogue::CATALOGUE;

/// Effects with which a board's loop hunts.
const HUNTING: [&str; 2] = ["valve_hysteresis", "valve_stiction"];
/// Courses of the noise over which a mean is taken.
const EXPECTED: u64 = 8;
/// Octaves of frequencies that are told apart, from half the sampling rate down.
const OCTAVES: usize = 4;
/// Errors that are tried, per factor of e.
const ERROR_STEPS: i32 = 10;

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

/// Whitened residuals of the same model with another course of the noise, in standard deviations of the noise.
fn otherwise(data: &ChannelData, whitening: &Whitening, model: &Extended) -> Vec<f64> {
    let mut other = data.clone();
    if let Some(board) = &mut other.plant.board {
        board.noise_draw += 1;
    }
    whitened_residuals(data, whitening, &other.readings(model))
}

/// What a model leaves in every block.
#[derive(Debug, Clone)]
pub struct Losses {
    /// Sum of squared whitened residuals in variances of the noise, without what hunting out of step adds: the error of the mean over
    /// all courses of the noise.
    pub fair: Vec<f64>,
    /// Minus twice the logarithm of a Gaussian likelihood whose variance is that of the noise and of the simulated hunting, octave by
    /// octave, up to a constant: a model that hunts must hunt as far as the recording, and as fast. The same as `fair` where a loop
    /// does not hunt.
    pub deviance: Vec<f64>,
    /// The deviance with a further error without a pattern, as large as suits the channel best: below that of another model only if
    /// hunting is where the error is, not if it only takes up what nothing explains.
    pub beside_error: Vec<f64>,
}

impl Losses {
    /// Of a model with these whitened residuals, in standard deviations of the noise.
    #[must_use]
    pub fn new(data: &ChannelData, whitening: &Whitening, model: &Extended, residuals: &[f64]) -> Self {
        let blocks: Vec<Vec<Octave>> = if hunts(data, model) {
            let other = otherwise(data, whitening, model);
            data.spans.iter().map(|span| octaves(&residuals[span.clone()], &other[span.clone()])).collect()
        } else {
            let losses = block_losses(data, residuals);
            let still = |(fair, span): (f64, &std::ops::Range<usize>)| {
                vec![Octave { fair, hunting: 0.0, count: span.len() as f64 }]
            };
            losses.into_iter().zip(&data.spans).map(still).collect()
        };
        let fair = blocks.iter().map(|octaves| octaves.iter().map(|o| o.fair).sum()).collect();
        let of = |error: f64| -> Vec<f64> {
            blocks.iter().map(|octaves| octaves.iter().map(|o| o.deviance(error)).sum()).collect()
        };
        let errors = (-ERROR_STEPS..=10 * ERROR_STEPS).map(|k| of((f64::from(k) / f64::from(ERROR_STEPS)).exp()));
        let open = |losses: &Vec<f64>| total(data, losses, &OPEN);
        let beside_error = errors.min_by(|a, b| open(a).total_cmp(&open(b))).unwrap_or_default();
        Self { fair, deviance: of(1.0), beside_error }
    }
}

/// The one of two models that has less [deviance](Losses::deviance) on the blocks for fitting, behind that. A fit of the squared error
/// prefers a model that hunts less than the recording.
#[must_use]
pub fn likelier(data: &ChannelData, whitening: &Whitening, models: [Extended; 2]) -> (f64, Extended) {
    let [one, other] = models.map(|model| {
        let residuals = whitened_residuals(data, whitening, &data.readings(&model));
        let losses = Losses::new(data, whitening, &model, &residuals);
        (total(data, &losses.deviance, &[Role::Fit]), model)
    });
    if other.0 < one.0 { other } else { one }
}

/// What two simulations that hunt out of step say about an octave of frequencies in a block.
#[derive(Debug, Clone, Copy)]
struct Octave {
    /// Sum of squares of the residuals from the mean over all courses of the noise.
    fair: f64,
    /// Sum of squares of the hunting.
    hunting: f64,
    /// Coefficients.
    count: f64,
}

impl Octave {
    /// Minus twice the log-likelihood with an error of this variance beside the hunting, up to a constant.
    fn deviance(self, error: f64) -> f64 {
        let variance = error + self.hunting / self.count;
        self.fair / variance + self.count * variance.ln()
    }
}

/// Splits the residuals of two simulations by octaves with the orthonormal Haar wavelet (Percival and Walden, Wavelet Methods for Time
/// Series Analysis, 2000, ch. 4): the fastest changes first, what is slower than the last octave at the end. The product of the two
/// has the mean square of their common part, half of their squared difference that of the hunting.
fn octaves(one: &[f64], other: &[f64]) -> Vec<Octave> {
    let mut found = Vec::new();
    let mut slow: Vec<[f64; 2]> = one.iter().zip(other).map(|(a, b)| [*a, *b]).collect();
    while found.len() < OCTAVES && slow.len() > 1 {
        let (pairs, odd) = slow.as_chunks::<2>();
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let fast = pairs.iter().map(|[x, y]| [half * (x[0] - y[0]), half * (x[1] - y[1])]);
        found.push(Octave::of(fast.chain(odd.iter().copied())));
        slow = pairs.iter().map(|[x, y]| [half * (x[0] + y[0]), half * (x[1] + y[1])]).collect();
    }
    if !slow.is_empty() {
        found.push(Octave::of(slow.into_iter()));
    }
    found
}

impl Octave {
    fn of(coefficients: impl Iterator<Item = [f64; 2]>) -> Self {
        coefficients.fold(Self { fair: 0.0, hunting: 0.0, count: 0.0 }, |sum, [a, b]| Self {
            fair: sum.fair + a * b,
            hunting: sum.hunting + 0.5 * (a - b) * (a - b),
            count: sum.count + 1.0,
        })
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
