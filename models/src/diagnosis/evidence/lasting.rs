//! The residual of a rollout as the noise of the reading and a discrepancy that lasts (Kennedy and
//! O'Hagan, J. R. Stat. Soc. B 63, 2001): a first-order process. Its density is a scalar Kalman
//! filter's.

use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::settings::SETTINGS;

/// Evaluations in the search for the discrepancy's size.
const SEARCH: usize = 24;

/// The density of a residual as noise and a discrepancy that lasts. Residuals go with the variance
/// of a loop's hunting, which lasts as long: kPa and kPa^2.
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

    /// Logarithms of the densities of each residual, given those before, with a discrepancy of a
    /// size beside the variance of the hunting; the discrepancy at the first is not known.
    #[must_use]
    pub fn log_terms(&self, residuals: &[[f64; 2]], size_kpa: f64) -> Vec<f64> {
        let stationary = |hunting: f64| size_kpa * size_kpa + hunting;
        let (mut mean, mut variance) = (0.0, residuals.first().map_or(0.0, |r| stationary(r[1])));
        let mut terms = Vec::with_capacity(residuals.len());
        for [r, hunting] in residuals {
            let total = variance + self.noise_kpa * self.noise_kpa;
            let error = r - mean;
            terms.push(-0.5 * (error * error / total + total.ln() + std::f64::consts::TAU.ln()));
            let gain = variance / total;
            (mean, variance) = (mean + gain * error, variance * (1.0 - gain));
            mean *= self.keep;
            variance =
                self.keep * self.keep * variance + (1.0 - self.keep * self.keep) * stationary(*hunting);
        }
        terms
    }

    /// Size of the discrepancy under which the residuals of some stretches are likeliest, kPa:
    /// golden section over its logarithm.
    #[must_use]
    pub fn likeliest(&self, stretches: &[&[[f64; 2]]]) -> f64 {
        let (sum, count) =
            stretches.iter().flat_map(|s| s.iter()).fold((0.0, 0.0), |(s, n), [r, _]| (s + r * r, n + 1.0));
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
        let residuals: Vec<[f64; 2]> = noise
            .iter()
            .zip(&pushes)
            .map(|(n, p)| {
                slow = 0.97 * slow + (1.0_f64 - 0.97 * 0.97).sqrt() * 0.5 * p;
                [slow + 0.1 * n, 0.0]
            })
            .collect();
        let halves = [&residuals[..2000], &residuals[2000..]];
        for stretches in [&[&residuals[..]][..], &halves[..]] {
            let size = lasting.likeliest(stretches);
            assert!((size / 0.5 - 1.0).abs() < 0.2, "{size}");
        }
        let only_noise: Vec<[f64; 2]> = noise.iter().map(|n| [0.1 * n, 0.0]).collect();
        assert!(lasting.likeliest(&[&only_noise]) < 0.02);
        // Hunting is no discrepancy where the model hunts as far.
        let hunting: Vec<[f64; 2]> = residuals.iter().map(|[r, _]| [*r, 0.25]).collect();
        assert!(lasting.likeliest(&[&hunting]) < 0.2);
    }

    #[test]
    fn hunting_at_the_right_time_is_likelier_than_a_discrepancy_all_the_time() {
        let lasting = Lasting { noise_kpa: 0.1, keep: 0.97 };
        let (noise, pushes) = (normals(3, 4000), normals(4, 4000));
        let hunts = |row: usize| row % 1000 < 300;
        let mut slow = 0.0;
        let mut of = |variance: &dyn Fn(usize) -> f64| -> f64 {
            let residuals: Vec<[f64; 2]> = (0..4000)
                .map(|row| {
                    let push = if hunts(row) { 0.5 * pushes[row] } else { 0.0 };
                    slow = 0.97 * slow + (1.0_f64 - 0.97 * 0.97).sqrt() * push;
                    [slow + 0.1 * noise[row], variance(row)]
                })
                .collect();
            let size = lasting.likeliest(&[&residuals]);
            lasting.log_terms(&residuals, size).iter().sum()
        };
        let (without, right) = (of(&|_| 0.0), of(&|row| if hunts(row) { 0.25 } else { 0.0 }));
        let wrong = of(&|row| if hunts(row) { 0.0 } else { 0.25 });
        assert!(right > without + 50.0 && without > wrong + 50.0, "{right} {without} {wrong}");
    }
}
