//! What models leave, block by block.

use super::covariance::Whitening;
use super::haar::{Octave, beside_error, deviances, octaves};
use super::limit_cycle::{hunts, otherwise};
use super::residuals::{block_losses, whitened_residuals};
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, Role, readings_of};
use crate::diagnosis::settings::SETTINGS;

/// What a model leaves in every block.
#[derive(Debug, Clone)]
pub struct Losses {
    /// Sum of squared whitened residuals in variances of the noise, without what hunting out of
    /// step adds: the error of the mean over all courses of the noise.
    pub fair: Vec<f64>,
    /// Minus twice the logarithm of a Gaussian likelihood whose variance is that of the noise and
    /// of the simulated hunting, octave by octave, up to a constant: a model that hunts must hunt
    /// as far as the recording, and as fast. The same as `fair` where a loop does not hunt.
    pub deviance: Vec<f64>,
    /// The deviance with a further error without a pattern, as large as suits the channel best:
    /// below that of another model only if hunting is where the error is, not if it only takes up
    /// what nothing explains.
    pub beside_error: Vec<f64>,
}

impl Losses {
    /// Of a model with these whitened residuals, in standard deviations of the noise.
    #[must_use]
    pub fn of_one(data: &ChannelData, whitening: &Whitening, model: &Extended, residuals: &[f64]) -> Self {
        let again = || whitened_residuals(data, whitening, &otherwise(data).readings(model));
        Self::new(data, residuals, hunts(data, model).then(again).as_deref())
    }

    /// The same of several models.
    #[must_use]
    pub fn of(
        data: &ChannelData,
        whitening: &Whitening,
        models: &[Extended],
        residuals: &[Vec<f64>],
    ) -> Vec<Self> {
        let hunting: Vec<Extended> = models.iter().filter(|model| hunts(data, model)).cloned().collect();
        let again = if hunting.is_empty() { Vec::new() } else { readings_of(&otherwise(data), &hunting) };
        let mut again = again.iter().map(|readings| whitened_residuals(data, whitening, readings));
        let of = |(model, residuals): (&Extended, &Vec<f64>)| {
            Self::new(data, residuals, if hunts(data, model) { again.next() } else { None }.as_deref())
        };
        models.iter().zip(residuals).map(of).collect()
    }

    /// From whitened residuals, where a loop hunts twice, each with another course of the noise.
    fn new(data: &ChannelData, residuals: &[f64], again: Option<&[f64]>) -> Self {
        let blocks: Vec<Vec<Octave>> = if let Some(other) = again {
            data.spans.iter().map(|span| octaves(&residuals[span.clone()], &other[span.clone()])).collect()
        } else {
            let losses = block_losses(data, residuals);
            let still = |(fair, span): (f64, &std::ops::Range<usize>)| {
                vec![Octave { fair, hunting: 0.0, count: span.len() as f64 }]
            };
            losses.into_iter().zip(&data.spans).map(still).collect()
        };
        let fair = blocks.iter().map(|octaves| octaves.iter().map(|o| o.fair).sum()).collect();
        let open: Vec<bool> = data.blocks.iter().map(|block| OPEN.contains(&block.role)).collect();
        Self { fair, deviance: deviances(&blocks, 1.0), beside_error: beside_error(&blocks, &open) }
    }
}

/// Sum over the blocks of some roles.
#[must_use]
pub fn total(data: &ChannelData, losses: &[f64], roles: &[Role]) -> f64 {
    data.blocks.iter().zip(losses).filter(|(b, _)| roles.contains(&b.role)).map(|(_, l)| l).sum()
}

/// By how much minus twice the log-likelihood of some rows must fall for a name: as with [the
/// smallest gain](crate::diagnosis::settings::Settings::practical) of error.
#[must_use]
pub fn least_gain(rows: f64) -> f64 {
    -2.0 * (1.0 - SETTINGS.practical).ln() * rows
}

/// Number of compared rows of a channel in the blocks of some roles.
#[must_use]
pub fn row_count(data: &ChannelData, roles: &[Role]) -> f64 {
    let blocks = data.blocks.iter().zip(&data.spans);
    blocks.filter(|(b, _)| roles.contains(&b.role)).map(|(_, span)| span.len() as f64).sum()
}

/// Deviances of all channels together, block by block, for the blocks of some roles.
#[must_use]
pub fn together<'a>(
    channels: &[ChannelData],
    losses: impl IntoIterator<Item = &'a Losses>,
    roles: &[Role],
) -> Vec<f64> {
    together_by(channels, losses, |losses| &losses.deviance, roles)
}

/// Deviance of all channels on the choosing blocks.
pub fn select_total<'a>(channels: &[ChannelData], losses: impl IntoIterator<Item = &'a Losses>) -> f64 {
    together(channels, losses, &[Role::Select]).iter().sum()
}

/// One kind of loss of all channels together, block by block, for the blocks of some roles.
#[must_use]
pub fn together_by<'a>(
    channels: &[ChannelData],
    losses: impl IntoIterator<Item = &'a Losses>,
    kind: impl Fn(&Losses) -> &[f64],
    roles: &[Role],
) -> Vec<f64> {
    let count = channels.iter().map(|d| d.blocks.len()).max().unwrap_or(0);
    let mut sums = vec![0.0; count];
    let mut counts = vec![false; count];
    for (data, losses) in channels.iter().zip(losses) {
        for (k, (block, loss)) in data.blocks.iter().zip(kind(losses)).enumerate() {
            if roles.contains(&block.role) {
                sums[k] += loss;
                counts[k] = true;
            }
        }
    }
    sums.into_iter().zip(counts).filter(|(_, c)| *c).map(|(s, _)| s).collect()
}
