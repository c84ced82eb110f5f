//! Probabilities of explanations: pseudo-BMA+ weights (Yao, Vehtari, Simpson and Gelman, Bayesian
//! Analysis 13, 2018), how often each is the likeliest when what was not fitted is weighed anew
//! (Bayesian bootstrap). No model is exactly the rig, and what it leaves lasts over many rows; so
//! densities are raised to the power of a coarsened posterior (Miller and Dunson, J. Am. Stat.
//! Assoc. 114, 2019): all rows together count as
//! [`coarsening_rows`](crate::diagnosis::settings::Settings::coarsening_rows) at most.

use rand::RngExt;

use super::predicted::Evidence;
use crate::diagnosis::resampling::generator;
use crate::diagnosis::settings::SETTINGS;

/// Draws of weights.
const DRAWS: usize = 2000;

/// The probability of each of some models.
#[must_use]
pub fn probabilities(all: &[&Evidence]) -> Vec<f64> {
    let units = all.first().map_or(0, |e| e.log_densities.len());
    if units == 0 {
        return vec![1.0 / all.len().max(1) as f64; all.len()];
    }
    let power = power(all[0].squares.1);
    let mut rng = generator(6);
    let mut sums = vec![0.0; all.len()];
    for _ in 0..DRAWS {
        let drawn: Vec<f64> = (0..units).map(|_| -(1.0 - rng.random::<f64>()).ln()).collect();
        let scale = power * units as f64 / drawn.iter().sum::<f64>();
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

/// Power to which the density of so many rows is raised.
fn power(rows: f64) -> f64 {
    1.0 / (1.0 + rows / SETTINGS.coarsening_rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(log_densities: &[f64]) -> Evidence {
        Evidence { log_densities: log_densities.to_vec(), ..Evidence::default() }
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
    fn a_hundred_times_the_rows_of_the_same_error_are_hardly_surer() {
        let of_rows = |rows: f64, nats_per_row: f64| {
            let units = [rows * nats_per_row / 8.0; 8];
            let better = Evidence { squares: (rows, rows), ..evidence(&units) };
            let base = Evidence { squares: (rows, rows), ..evidence(&[0.0; 8]) };
            probabilities(&[&base, &better])[1]
        };
        let (few, many) = (of_rows(500.0, 0.02), of_rows(50_000.0, 0.02));
        assert!(few > 0.7 && many > few && many < 0.95, "{few} {many}");
        assert!(of_rows(500.0, 0.1) > 0.99);
    }
}
