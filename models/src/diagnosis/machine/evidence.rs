//! How well models predict what they were not fitted to, and how probable that makes them.
//!
//! The residual of a rollout is the noise of the reading and a discrepancy that lasts (Kennedy and O'Hagan, J. R. Stat. Soc. B 63, 2001):
//! a first-order process whose size is estimated where the model was fitted. The density of the next part of every recording is then a
//! scalar Kalman filter's. Probabilities are pseudo-BMA+ weights (Yao, Vehtari, Simpson and Gelman, Bayesian Analysis 13, 2018): how
//! often each model is the likeliest when recordings are weighed anew (Bayesian bootstrap).

use rand::RngExt;

use super::recordings::MachineChannel;
use super::ties::TiedModel;
use crate::diagnosis::channel::{ChannelData, Role, rows_of};
use crate::diagnosis::resampling::generator;
use crate::diagnosis::settings::SETTINGS;

/// Parts of a recording that are weighed by themselves where there are few recordings.
const PIECES: usize = 4;
/// Recordings that are enough to be weighed as wholes.
const ENOUGH: usize = 5;
/// Draws of weights.
const DRAWS: usize = 2000;
/// Evaluations in the search for the discrepancy's size.
const SEARCH: usize = 24;

/// What models of one channel are worth on the parts where causes are chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// Logarithms of the predictive density of each unit: a recording, or a piece of one where there are few.
    pub log_densities: Vec<f64>,
    /// Size of the discrepancy in each recording, kPa RMS.
    pub discrepancy_kpa: Vec<f64>,
    /// Squared residuals over the parts where causes are chosen, kPa^2, and their number.
    pub squares: (f64, f64),
}

impl Evidence {
    /// Of the models of one channel.
    #[must_use]
    pub fn of(channel: &MachineChannel, models: &TiedModel) -> Self {
        let pieces = pieces(channel.recorded.len());
        let mut evidence =
            Self { log_densities: Vec::new(), discrepancy_kpa: Vec::new(), squares: (0.0, 0.0) };
        for (data, model) in channel.recorded.iter().zip(&models.models) {
            let residuals = data.residuals(model);
            let part = |role: Role| -> Vec<f64> {
                rows_of(data, &[role]).into_iter().map(|row| residuals[row]).collect()
            };
            let (fit, select) = (part(Role::Fit), part(Role::Select));
            let filter = Filter::of(data);
            let size = filter.likeliest(&fit);
            let terms = filter.log_terms(&select, size);
            let length = terms.len().div_ceil(pieces).max(1);
            evidence.log_densities.extend(terms.chunks(length).map(|piece| piece.iter().sum::<f64>()));
            evidence.discrepancy_kpa.push(size);
            evidence.squares.0 += select.iter().map(|r| r * r).sum::<f64>();
            evidence.squares.1 += select.len() as f64;
        }
        evidence
    }

    /// Of several channels together.
    #[must_use]
    pub fn together(parts: &[Self]) -> Self {
        let mut all = parts[0].clone();
        for part in &parts[1..] {
            all.log_densities.iter_mut().zip(&part.log_densities).for_each(|(a, b)| *a += b);
            all.discrepancy_kpa.extend(&part.discrepancy_kpa);
            all.squares = (all.squares.0 + part.squares.0, all.squares.1 + part.squares.1);
        }
        all
    }

    /// Logarithm of the density of all units.
    #[must_use]
    pub fn log_density(&self) -> f64 {
        self.log_densities.iter().sum()
    }

    /// RMS error of rollouts over the parts where causes are chosen, kPa.
    #[must_use]
    pub fn rmse_kpa(&self) -> f64 {
        (self.squares.0 / self.squares.1.max(1.0)).sqrt()
    }

    /// By how much this is likelier than another, and the standard error of that over the units.
    #[must_use]
    pub fn over(&self, other: &Self) -> (f64, f64) {
        let differences: Vec<f64> =
            self.log_densities.iter().zip(&other.log_densities).map(|(a, b)| a - b).collect();
        let n = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / n;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        (n * mean, (n * variance).sqrt())
    }
}

/// Parts that each recording is weighed in.
#[must_use]
pub fn pieces(recordings: usize) -> usize {
    if recordings >= ENOUGH { 1 } else { PIECES }
}

/// The density of a residual as noise and a discrepancy that lasts.
struct Filter {
    noise_kpa: f64,
    keep: f64,
}

impl Filter {
    fn of(data: &ChannelData) -> Self {
        let inputs = &data.inputs;
        let between_s = inputs.duration_s / inputs.rows().max(1) as f64;
        Self { noise_kpa: data.noise_kpa, keep: (-between_s / SETTINGS.greybox_discrepancy_s).exp() }
    }

    /// Logarithms of the densities of each residual, given those before.
    fn log_terms(&self, residuals: &[f64], size_kpa: f64) -> Vec<f64> {
        let stationary = size_kpa * size_kpa;
        let (mut mean, mut variance) = (0.0, stationary);
        let mut terms = Vec::with_capacity(residuals.len());
        for r in residuals {
            let total = variance + self.noise_kpa * self.noise_kpa;
            let error = r - mean;
            terms.push(-0.5 * (error * error / total + total.ln() + std::f64::consts::TAU.ln()));
            let gain = variance / total;
            (mean, variance) = (mean + gain * error, variance * (1.0 - gain));
            mean *= self.keep;
            variance = self.keep * self.keep * variance + (1.0 - self.keep * self.keep) * stationary;
        }
        terms
    }

    /// Size of the discrepancy under which some residuals are likeliest, kPa: golden section over its logarithm.
    fn likeliest(&self, residuals: &[f64]) -> f64 {
        let square = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
        let (mut low, mut high) =
            ((0.01 * self.noise_kpa).ln(), (10.0 * square.sqrt() + self.noise_kpa).ln());
        let log = |x: f64| self.log_terms(residuals, x.exp()).iter().sum::<f64>();
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        let inner = |low: f64, high: f64| (high - ratio * (high - low), low + ratio * (high - low));
        let (mut a, mut b) = inner(low, high);
        let (mut at_a, mut at_b) = (log(a), log(b));
        for _ in 0..SEARCH {
            if at_a > at_b {
                (high, b, at_b) = (b, a, at_a);
                a = inner(low, high).0;
                at_a = log(a);
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = inner(low, high).1;
                at_b = log(b);
            }
        }
        (0.5 * (low + high)).exp()
    }
}

/// The probability of each of some models.
#[must_use]
pub fn probabilities(all: &[&Evidence]) -> Vec<f64> {
    let units = all.first().map_or(0, |e| e.log_densities.len());
    let mut rng = generator(6);
    let mut sums = vec![0.0; all.len()];
    for _ in 0..DRAWS {
        let drawn: Vec<f64> = (0..units).map(|_| -(1.0 - rng.random::<f64>()).ln()).collect();
        let scale = units as f64 / drawn.iter().sum::<f64>();
        let of = |e: &&Evidence| -> f64 {
            scale * e.log_densities.iter().zip(&drawn).map(|(l, w)| l * w).sum::<f64>()
        };
        let logs: Vec<f64> = all.iter().map(of).collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = logs.iter().map(|l| (l - most).exp()).collect();
        let total: f64 = weights.iter().sum();
        sums.iter_mut().zip(&weights).for_each(|(sum, w)| *sum += w / total);
    }
    sums.iter().map(|sum| sum / DRAWS as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::normals;

    fn evidence(log_densities: &[f64]) -> Evidence {
        Evidence { log_densities: log_densities.to_vec(), discrepancy_kpa: Vec::new(), squares: (0.0, 0.0) }
    }

    #[test]
    fn a_model_that_is_likelier_everywhere_is_sure_and_one_that_is_so_by_one_recording_is_not() {
        let base = evidence(&[0.0; 8]);
        let sure = probabilities(&[&base, &evidence(&[5.0; 8])]);
        assert!(sure[1] > 0.99 && (sure[0] + sure[1] - 1.0).abs() < 1e-9, "{sure:?}");
        let mut one = [-5.0; 8];
        one[3] = 40.0;
        let doubtful = probabilities(&[&base, &evidence(&one)]);
        assert!(doubtful[1] > 0.2 && doubtful[1] < 0.8, "{doubtful:?}");
    }

    #[test]
    fn the_size_of_a_discrepancy_is_found_and_none_is_seen_in_noise() {
        let filter = Filter { noise_kpa: 0.1, keep: 0.97 };
        let (noise, pushes) = (normals(1, 4000), normals(2, 4000));
        let mut slow = 0.0;
        let residuals: Vec<f64> = noise
            .iter()
            .zip(&pushes)
            .map(|(n, p)| {
                slow = 0.97 * slow + (1.0_f64 - 0.97 * 0.97).sqrt() * 0.5 * p;
                slow + 0.1 * n
            })
            .collect();
        let size = filter.likeliest(&residuals);
        assert!((size / 0.5 - 1.0).abs() < 0.2, "{size}");
        let only_noise: Vec<f64> = noise.iter().map(|n| 0.1 * n).collect();
        assert!(filter.likeliest(&only_noise) < 0.02);
    }

    #[test]
    fn what_one_is_likelier_by_has_the_error_of_its_scatter() {
        let (gain, error) = evidence(&[3.0, 5.0, 4.0, 4.0]).over(&evidence(&[1.0; 4]));
        assert!((gain - 12.0).abs() < 1e-12);
        assert!((error - (4.0 * 2.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{error}");
    }
}
