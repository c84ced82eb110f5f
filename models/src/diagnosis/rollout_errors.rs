//! Errors of rollouts on blocks that were not fitted, and what a change of the model gains there.

use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::json::Gain;
use crate::diagnosis::likelihood::{Expected, Whitening};
use crate::diagnosis::resampling::{generator, quantile, runs};
use crate::parallel;

/// Pieces a block is cut into for resampling.
const PIECES: usize = 5;
const RESAMPLES: usize = 1999;

/// Squared errors of one model over the blocks of one role.
#[derive(Debug, Clone)]
pub struct BlockErrors {
    /// Sum of squares and number of rows, channel by channel and piece by piece, kPa^2.
    pieces: Vec<Vec<(f64, f64)>>,
}

/// Residuals of a rollout whose start pressure in every block is right, kPa, at the compared rows;
/// of a loop that hunts, those of the [expected readings](Expected).
#[must_use]
pub fn rollout_residuals(data: &ChannelData, model: &Extended) -> Vec<f64> {
    let Expected { readings, .. } = Expected::of(data, model);
    let mut r: Vec<f64> = readings.iter().zip(data.measured_kpa.iter()).map(|(y, m)| m - y).collect();
    // How a start pressure dies away is a matter of the gas, not of every loop of the board.
    Whitening::start_only(data, &data.rough().disturbances(model)).apply(&mut r);
    r
}

impl BlockErrors {
    /// Of the models of every channel on the blocks of some roles.
    #[must_use]
    pub fn of(channels: &[ChannelData], models: &[Extended], roles: &[Role]) -> Self {
        let residuals: Vec<Vec<f64>> =
            parallel::map(channels.iter().zip(models), |(d, m)| rollout_residuals(d, m));
        Self::new(channels, &residuals, roles)
    }

    /// Of some stages on the test blocks, weighted by what noise, the wander of the supply and the
    /// hunting of a loop explain: what the search goes by. In variances of the noise instead of
    /// kPa^2.
    #[must_use]
    pub fn weighted(channels: &[ChannelData], stages: &[ChannelStage]) -> Self {
        let pieces = channels.iter().zip(stages).map(|(data, stage)| {
            let blocks = data.blocks.iter().zip(&data.spans).zip(&stage.losses.deviance);
            let tested = blocks.filter(|((block, _), _)| block.role == Role::Test);
            // A block's loss is one number: its pieces are alike.
            let part = |sum: f64, rows: usize| (sum / PIECES as f64, rows as f64 / PIECES as f64);
            tested.flat_map(|((_, span), loss)| [part(*loss, span.len()); PIECES]).collect()
        });
        Self { pieces: pieces.collect() }
    }

    fn new(channels: &[ChannelData], residuals: &[Vec<f64>], roles: &[Role]) -> Self {
        let pieces = channels.iter().zip(residuals).map(|(data, r)| {
            let blocks = data.blocks.iter().zip(&data.spans).filter(move |(b, _)| roles.contains(&b.role));
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

    /// Reduction from `self` to `after` with its 95 % interval.
    ///
    /// The interval is that of a studentised bootstrap (Hall, Annals of Statistics 16, 1988) of the
    /// ratio's logarithm over moving blocks (Kuensch, Annals of Statistics 17, 1989): squared
    /// errors of a dozen blocks are skewed, and plain percentiles would be too narrow and too low.
    #[must_use]
    pub fn gain(&self, after: &Self) -> Gain {
        let together = |e: &Self| {
            let count = e.pieces.iter().map(Vec::len).max().unwrap_or(0);
            let sum = |k: usize| e.pieces.iter().filter_map(|c| c.get(k)).map(|p| p.0).sum::<f64>();
            (0..count).map(sum).collect::<Vec<f64>>()
        };
        let (a, b) = (together(self), together(after));
        let whole = log_ratio(&a, &b);
        let mut rng = generator(4);
        let mut values: Vec<f64> = (0..RESAMPLES)
            .filter(|_| !a.is_empty())
            .filter_map(|_| {
                let drawn = runs(&mut rng, a.len(), PIECES);
                let of = |x: &[f64]| drawn.iter().map(|&k| x[k]).collect::<Vec<f64>>();
                let (ratio, error) = log_ratio(&of(&a), &of(&b));
                // The same block every time has no error: such a resample says nothing.
                Some((ratio - whole.0) / error).filter(|t| t.is_finite())
            })
            .collect();
        values.sort_by(f64::total_cmp);
        let end = |share: f64| 1.0 - (whole.0 - quantile(&values, share) * whole.1).exp();
        let ci95 = if values.is_empty() { [0.0, 0.0] } else { [end(0.025), end(0.975)] };
        Gain {
            test_rmse_before_kpa: self.all(),
            test_rmse_after_kpa: after.all(),
            reduction: 1.0 - whole.0.exp(),
            ci95,
            weighted_ci95: ci95,
        }
    }
}

/// Logarithm of the ratio of two root mean squares, and its standard error from the scatter of
/// blocks (delta method).
fn log_ratio(before: &[f64], after: &[f64]) -> (f64, f64) {
    let sum = |x: &[f64]| x.iter().sum::<f64>();
    let (a, b) = (sum(before), sum(after));
    let blocks = before.chunks(PIECES).zip(after.chunks(PIECES));
    let pulls: Vec<f64> = blocks.map(|(x, y)| 0.5 * (sum(y) / b - sum(x) / a)).collect();
    let n = pulls.len() as f64;
    let scatter = pulls.iter().map(|v| v * v).sum::<f64>() * n / (n - 1.0).max(1.0);
    (0.5 * (b / a).ln(), scatter.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::likelihood::limit_cycle::otherwise;
    use crate::diagnosis::testing::{channel, measured, with};
    use rand::RngExt;

    fn errors(sums: &[f64]) -> BlockErrors {
        BlockErrors { pieces: vec![sums.iter().map(|s| (*s, 1.0)).collect()] }
    }

    #[test]
    fn the_interval_of_a_gain_covers_the_gain_of_skewed_errors() {
        // Eleven blocks whose level wanders: squares of normal numbers. The true reduction is one
        // half.
        let mut rng = generator(9);
        let mut square = || {
            let sum: f64 = (0..12).map(|_| rng.random::<f64>()).sum();
            (sum - 6.0) * (sum - 6.0)
        };
        let mut covered = 0;
        for _ in 0..200 {
            let series =
                |levels: &[f64]| errors(&levels.iter().flat_map(|v| [*v; PIECES]).collect::<Vec<_>>());
            let (before, after): (Vec<f64>, Vec<f64>) = (0..11).map(|_| (4.0 * square(), square())).unzip();
            let gain = series(&before).gain(&series(&after));
            covered += i32::from((gain.ci95[0]..=gain.ci95[1]).contains(&0.5));
        }
        assert!((180..=198).contains(&covered), "{covered} of 200");
    }

    #[test]
    fn a_loop_that_hunts_as_the_recording_does_gains_where_errors_are_weighed() {
        let (data, base) = channel(true);
        let sticking = with(&data, &base, "valve_stiction", &[0.1]);
        let data = measured(otherwise(&otherwise(&data)), &sticking, 1);
        let stage = |model: &Extended| vec![ChannelStage::new(&data, model.clone(), Vec::new())];
        let weighted = |model: &Extended| BlockErrors::weighted(std::slice::from_ref(&data), &stage(model));
        let (still, hunting) = (weighted(&base), weighted(&sticking));
        assert!(still.gain(&hunting).ci95[0] > 0.01, "{:?}", still.gain(&hunting));
    }
}
