//! What models are worth on the blocks where causes are chosen.

use super::lasting::Lasting;
use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::likelihood::Expected;

/// What the model of one channel predicts of one recording.
#[derive(Debug, Clone)]
pub struct Predicted {
    /// Logarithms of the predictive density of each reading, block by block.
    pub log_terms: Vec<Vec<f64>>,
    /// Size of the discrepancy where the model was fitted, kPa RMS.
    pub discrepancy_kpa: f64,
    /// Squared residuals, kPa^2, and their number.
    pub squares: (f64, f64),
}

impl Predicted {
    /// Of a model. The size of its discrepancy is that of the blocks it was fitted to.
    #[must_use]
    pub fn of(data: &ChannelData, model: &Extended) -> Self {
        let Expected { readings, hunting } = Expected::of(data, model);
        let residuals: Vec<[f64; 2]> = readings
            .iter()
            .zip(data.measured_kpa.iter())
            .zip(hunting)
            .map(|((y, measured), hunting)| [measured - y, hunting])
            .collect();
        let stretches = |role: Role| -> Vec<&[[f64; 2]]> {
            let chosen = data.blocks.iter().zip(&data.spans).filter(|(block, _)| block.role == role);
            chosen.map(|(_, span)| &residuals[span.clone()]).collect()
        };
        let (fit, select) = (stretches(Role::Fit), stretches(Role::Select));
        let lasting = Lasting::of(data);
        let discrepancy_kpa = lasting.likeliest(&fit);
        Self {
            log_terms: select.iter().map(|block| lasting.log_terms(block, discrepancy_kpa)).collect(),
            discrepancy_kpa,
            squares: select
                .iter()
                .flat_map(|block| block.iter())
                .fold((0.0, 0.0), |(s, n), [r, _]| (s + r * r, n + 1.0)),
        }
    }

    /// With each block a unit of its own.
    #[must_use]
    pub fn by_block(&self) -> Evidence {
        Evidence {
            log_densities: self.log_terms.iter().map(|block| block.iter().sum()).collect(),
            discrepancy_kpa: vec![self.discrepancy_kpa],
            squares: self.squares,
        }
    }
}

/// What models are worth, unit by unit: a recording, a piece of one or a block.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Evidence {
    /// Logarithms of the predictive density of each unit.
    pub log_densities: Vec<f64>,
    /// Size of the discrepancy in each recording, channel by channel, kPa RMS.
    pub discrepancy_kpa: Vec<f64>,
    /// Squared residuals over the parts where causes are chosen, kPa^2, and their number.
    pub squares: (f64, f64),
}

impl Evidence {
    /// Of several channels together.
    #[must_use]
    pub fn together(parts: &[Self]) -> Self {
        let mut all = parts.first().cloned().unwrap_or_default();
        for part in parts.iter().skip(1) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_is_likelier_by_has_the_error_of_its_scatter() {
        let evidence =
            |log_densities: &[f64]| Evidence { log_densities: log_densities.to_vec(), ..Evidence::default() };
        let (gain, error) = evidence(&[3.0, 5.0, 4.0, 4.0]).over(&evidence(&[1.0; 4]));
        assert!((gain - 12.0).abs() < 1e-12);
        assert!((error - (4.0 * 2.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{error}");
    }
}
