//! Errors of rollouts on blocks that were not fitted, and what a change of the model gains there.

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::blocks::Role;
use super::channel::{ChannelData, Extended};
use super::json::Gain;
use super::random::{generator, quantile, runs};
use super::whiten::Whitening;

/// Pieces a block is cut into for resampling.
const PIECES: usize = 5;
const RESAMPLES: usize = 1999;

/// Squared errors of one model over the blocks of one role.
#[derive(Debug, Clone)]
pub struct BlockErrors {
    /// Sum of squares and number of rows, channel by channel and piece by piece, kPa^2.
    pieces: Vec<Vec<(f64, f64)>>,
}

/// Residuals of a rollout whose start pressure in every block is right, kPa, at the compared rows.
#[must_use]
pub fn rollout_residuals(data: &ChannelData, model: &Extended) -> Vec<f64> {
    let mut r = data.residuals(model);
    Whitening::start_only(data, &data.disturbances(model)).apply(&mut r);
    r
}

impl BlockErrors {
    /// Of the models of every channel on the blocks with `role`.
    #[must_use]
    pub fn of(channels: &[ChannelData], models: &[Extended], role: Role) -> Self {
        let residuals: Vec<Vec<f64>> =
            channels.par_iter().zip(models).map(|(d, m)| rollout_residuals(d, m)).collect();
        Self::new(channels, &residuals, role)
    }

    fn new(channels: &[ChannelData], residuals: &[Vec<f64>], role: Role) -> Self {
        let pieces = channels.iter().zip(residuals).map(|(data, r)| {
            let blocks = data.blocks.iter().zip(&data.spans).filter(move |(b, _)| b.role == role);
            blocks
                .flat_map(|(_, span)| {
                    (0..PIECES).map(move |k| {
                        let at = |k: usize| span.start + k * span.len() / PIECES;
                        let part = &r[at(k)..at(k + 1)];
                        (part.iter().map(|v| v * v).sum::<f64>(), part.len() as f64)
                    })
                })
                .collect()
        });
        Self { pieces: pieces.collect() }
    }

    /// RMS error of one channel, kPa.
    #[must_use]
    pub fn channel(&self, channel: usize) -> f64 {
        let (sum, count) = self.pieces[channel].iter().fold((0.0, 0.0), |a, p| (a.0 + p.0, a.1 + p.1));
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// RMS error of all channels, kPa.
    #[must_use]
    pub fn all(&self) -> f64 {
        let (sum, count) = self.pieces.iter().flatten().fold((0.0, 0.0), |a, p| (a.0 + p.0, a.1 + p.1));
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Reduction from `self` to `after` with its 95 % interval: moving-block bootstrap (Kuensch, Annals of Statistics 17, 1989) over
    /// runs as long as a block, with percentiles widened for few blocks (Hesterberg, American Statistician 69, 2015, section 4.5).
    #[must_use]
    pub fn gain(&self, after: &Self) -> Gain {
        let together = |e: &Self| {
            let count = e.pieces.iter().map(Vec::len).max().unwrap_or(0);
            let sum = |k: usize| e.pieces.iter().filter_map(|c| c.get(k)).map(|p| p.0).sum::<f64>();
            (0..count).map(sum).collect::<Vec<f64>>()
        };
        let (a, b) = (together(self), together(after));
        let reduction = |a: f64, b: f64| 1.0 - (b / a).sqrt();
        let mut rng = generator(4);
        let mut values: Vec<f64> = (0..RESAMPLES)
            .filter(|_| !a.is_empty())
            .map(|_| {
                let drawn = runs(&mut rng, a.len(), PIECES);
                let sum = |x: &[f64]| drawn.iter().map(|&k| x[k]).sum::<f64>();
                reduction(sum(&a), sum(&b))
            })
            .collect();
        values.sort_by(f64::total_cmp);
        let tail = expanded_tail(a.len() as f64 / PIECES as f64);
        let interval = if values.is_empty() {
            [0.0, 0.0]
        } else {
            [quantile(&values, tail), quantile(&values, 1.0 - tail)]
        };
        Gain {
            test_rmse_before_kpa: self.all(),
            test_rmse_after_kpa: after.all(),
            reduction: reduction(a.iter().sum(), b.iter().sum()),
            ci95: interval,
        }
    }
}

/// Share beyond each end of a bootstrap's percentile interval that covers 95 % with `n` independent parts.
fn expanded_tail(n: f64) -> f64 {
    let freedom = (n - 1.0).max(1.0);
    let Ok(student) = StudentsT::new(0.0, 1.0, freedom) else { return 0.025 };
    Normal::standard().cdf(-(n.max(2.0) / freedom).sqrt() * student.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_blocks_reach_further_into_the_tails() {
        // t(10) = 2.228: half width 2.337 standard errors, 0.97 % beyond each end.
        assert!((expanded_tail(11.0) - 0.0097).abs() < 1e-4, "{}", expanded_tail(11.0));
        assert!((expanded_tail(1e6) - 0.025).abs() < 1e-4);
    }
}
