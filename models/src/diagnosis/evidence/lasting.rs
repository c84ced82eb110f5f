//! The residual of a rollout as the noise of the reading and a discrepancy that lasts (Kennedy and
//! O'Hagan, J. R. Stat. Soc. B 63, 2001): a first-order process. Its density is a scalar Kalman
//! filter's.

use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::settings::SETTINGS;

/// Evaluations in the search for the discrepancy's size.
const SEARCH: usize = 24;

/// The density of a residual as noise and a discrepancy that lasts.
pub struct Lasting {
    noise_kpa: f64,
    keep: f64,
}

impl Lasting {
    /// Of a channel's rows.
    #[must_use]
    pub fn of(data: &ChannelData) -> Self {
        let inputs = &data.inputs;
        // Residuals are those of the compared rows, of a long recording every other or fewer.
        let stride = data.rows.windows(2).map(|pair| pair[1] - pair[0]).min().unwrap_or(1).max(1);
        let between_s = f64::from(stride) * inputs.duration_s / inputs.rows().max(1) as f64;
        Self { noise_kpa: data.noise_kpa, keep: (-between_s / SETTINGS.greybox_discrepancy_s).exp() }
    }

    /// Logarithms of the densities of each residual, given those before; the discrepancy at the
    /// first is not known.
    #[must_use]
    pub fn log_terms(&self, residuals: &[f64], size_kpa: f64) -> Vec<f64> {
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

    /// Size of the discrepancy under which the residuals of some stretches are likeliest, kPa:
    /// golden section over its logarithm.
    #[must_use]
    pub fn likeliest(&self, stretches: &[&[f64]]) -> f64 {
        let (sum, count) =
            stretches.iter().flat_map(|s| s.iter()).fold((0.0, 0.0), |(s, n), r| (s + r * r, n + 1.0));
        let rms_kpa = (sum / f64::max(count, 1.0)).sqrt();
        let (mut low, mut high) = ((0.01 * self.noise_kpa).ln(), (10.0 * rms_kpa + self.noise_kpa).ln());
        let log =
            |x: f64| -> f64 { stretches.iter().flat_map(|stretch| self.log_terms(stretch, x.exp())).sum() };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::normals;

    #[test]
    fn the_size_of_a_discrepancy_is_found_and_none_is_seen_in_noise() {
        let lasting = Lasting { noise_kpa: 0.1, keep: 0.97 };
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
        let halves = [&residuals[..2000], &residuals[2000..]];
        for stretches in [&[&residuals[..]][..], &halves[..]] {
            let size = lasting.likeliest(stretches);
            assert!((size / 0.5 - 1.0).abs() < 0.2, "{size}");
        }
        let only_noise: Vec<f64> = noise.iter().map(|n| 0.1 * n).collect();
        assert!(lasting.likeliest(&[&only_noise]) < 0.02);
    }
}
