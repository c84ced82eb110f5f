//! The maximum of a posterior by Fisher scoring, with steps damped after Levenberg and Marquardt.
//!
//! Derivatives of errors and variances are differences: a filter with derivatives of its
//! derivatives would cost as much.

use crate::diagnosis::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};

use super::filter::Innovations;
use super::posterior::{Density, Posterior};
use super::steered::{LANES, steered_errors};
use super::uncertainty::Uncertainty;
use crate::diagnosis::channel::Extended;
use crate::model::Scale;
use crate::parallel;

/// A rise of the logarithm of the density that is not worth another round.
const SMALL: f64 = 0.05;
/// Steps that are tried in a round.
const TRIES: usize = 6;
/// Longest step of a coordinate that is a logarithm.
const LONGEST: f64 = 1.0;

/// Where a search ended.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// The model.
    pub model: Extended,
    /// What it leaves open.
    pub uncertainty: Uncertainty,
    /// Logarithm of the posterior density.
    pub log: f64,
    /// Standard errors of the free parameters on their scales; empty before the end of a search.
    pub errors: Vec<f64>,
}

impl Posterior<'_> {
    /// Climbs from a start, with so many sets of derivatives at most.
    #[must_use]
    pub fn climb(&self, start: &Extended, uncertainty: &Uncertainty, rounds: usize) -> Estimate {
        let bounds = self.bounds();
        let mut x = self.coordinates(start, uncertainty);
        let mut here = self.density(&x);
        let mut damping = 1e-3;
        for _ in 0..rounds {
            if here.log == f64::NEG_INFINITY {
                break;
            }
            let (gradient, fisher) = self.slopes(&x, &here);
            let before = here.log;
            for _ in 0..TRIES {
                let next = step(&x, &bounds, &gradient, &fisher, damping).map(|step| self.moved(&x, &step));
                let better = next.map(|next| (self.density(&next), next)).filter(|(d, _)| d.log > here.log);
                if let Some(better) = better {
                    (here, x) = better;
                    damping *= 0.2;
                    break;
                }
                damping = f64::max(damping * 8.0, 1e-5);
            }
            if here.log < before + SMALL {
                break;
            }
        }
        let (model, uncertainty) = self.at(&x);
        Estimate { model, uncertainty, log: here.log, errors: Vec::new() }
    }

    /// Standard errors of the free parameters at an estimate, on their scales, from the information
    /// of all of them.
    #[must_use]
    pub fn standard_errors(&self, estimate: &Estimate) -> Vec<f64> {
        let x = self.coordinates(&estimate.model, &estimate.uncertainty);
        let (_, fisher) = self.slopes(&x, &self.density(&x));
        let n = self.free.len();
        let inverse = fisher.cholesky().map(|c| c.inverse());
        (0..n).map(|k| inverse.as_ref().map_or(f64::INFINITY, |m| m[(k, k)].sqrt())).collect()
    }

    fn moved(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let linear = |k: usize| {
            self.free.get(k).is_some_and(|&position| self.parameters[position].scale == Scale::Linear)
        };
        let bounds = self.bounds();
        let most = |k: usize| if linear(k) { f64::INFINITY } else { LONGEST };
        let moved =
            |(k, x): (usize, &f64)| (x + step[k].clamp(-most(k), most(k))).clamp(bounds[k].0, bounds[k].1);
        x.iter().enumerate().map(moved).collect()
    }

    /// Distance over which a difference is taken.
    fn difference(&self, x: &[f64], k: usize) -> f64 {
        let Some(&position) = self.free.get(k) else { return 0.02 };
        let p = &self.parameters[position];
        match p.scale {
            Scale::Logarithmic => 1e-3,
            Scale::Linear => 1e-4 * x[k].abs().max(1e-2 * (p.upper - p.lower).min(10.0)),
        }
    }

    /// Derivatives by some coordinates, of the errors in standard deviations and of the relative
    /// variances over root two; empty where the simulation runs away. By several at once, which are
    /// the model's, with the filter's gain as it is.
    fn columns(&self, x: &[f64], here: &Density, part: &[usize]) -> Vec<(Vec<f64>, Vec<f64>)> {
        let Innovations { errors, variances } = &here.innovations;
        let bounds = self.bounds();
        let moved = |&k: &usize| {
            let mut moved = x.to_vec();
            let h = self.difference(x, k);
            moved[k] += if x[k] + h > bounds[k].1 { -h } else { h };
            moved
        };
        let moved: Vec<Vec<f64>> = part.iter().map(moved).collect();
        let there: Vec<Innovations> = if part.len() > 1 {
            let models: Vec<Extended> = moved.iter().map(|x| self.at(x).0).collect();
            let errors = steered_errors(self.data, &models, &here.gains, self.counted);
            errors.into_iter().map(|errors| Innovations { errors, variances: variances.clone() }).collect()
        } else {
            moved.iter().map(|x| self.density(x).innovations).collect()
        };
        let column = |((k, moved), there): ((&usize, &Vec<f64>), Innovations)| {
            if there.errors.len() != errors.len() || there.errors.iter().any(|error| !error.is_finite()) {
                return (Vec::new(), Vec::new());
            }
            let by = |a: &f64, b: &f64| (a - b) / (moved[*k] - x[*k]);
            let scaled = there.errors.iter().zip(errors).zip(variances);
            let relative = there.variances.iter().zip(variances);
            (
                scaled.map(|((a, b), v)| by(a, b) / v.sqrt()).collect(),
                relative.map(|(a, b)| by(a, b) / b * std::f64::consts::FRAC_1_SQRT_2).collect(),
            )
        };
        part.iter().zip(&moved).zip(there).map(column).collect()
    }

    /// Gradient of the log density and Fisher's information, the prior's included.
    fn slopes(&self, x: &[f64], here: &Density) -> (DVector<f64>, DMatrix<f64>) {
        let (n, bounds) = (x.len(), self.bounds());
        let (errors, variances) = (&here.innovations.errors, &here.innovations.variances);
        // In units in which the information is one sum of products.
        // What cannot move is held, whatever its slope: a run of the filter less.
        let moving: Vec<usize> = (0..n).filter(|&k| bounds[k].0 < bounds[k].1).collect();
        let alike = if self.stiff { LANES } else { 1 };
        let (of_model, of_uncertainty): (Vec<usize>, Vec<usize>) =
            moving.into_iter().partition(|&k| k < self.free.len());
        let parts: Vec<&[usize]> = of_model.chunks(alike).chain(of_uncertainty.chunks(1)).collect();
        let mut columns = vec![(vec![0.0; errors.len()], vec![0.0; errors.len()]); n];
        let found = parallel::map(parts.iter(), |part| self.columns(x, here, part));
        for (&k, column) in parts.iter().copied().flatten().zip(found.into_iter().flatten()) {
            if column.0.len() == errors.len() {
                columns[k] = column;
            }
        }
        let mut gradient = DVector::<f64>::zeros(n);
        let mut fisher = DMatrix::<f64>::zeros(n, n);
        let z: Vec<f64> = errors.iter().zip(variances).map(|(e, v)| e / v.sqrt()).collect();
        let weight =
            |z: f64| if z.abs() < SETTINGS.greybox_huber { 1.0 } else { SETTINGS.greybox_huber / z.abs() };
        for a in 0..n {
            let (by_error, by_variance) = &columns[a];
            for (t, &z) in z.iter().enumerate() {
                let w = weight(z);
                gradient[a] -= w * z * by_error[t]
                    + by_variance[t] * std::f64::consts::FRAC_1_SQRT_2 * (1.0 - w * z * z);
            }
            for b in a..n {
                let (other_error, other_variance) = &columns[b];
                let mut sum = 0.0;
                for (t, &z) in z.iter().enumerate() {
                    sum += weight(z) * by_error[t] * other_error[t] + by_variance[t] * other_variance[t];
                }
                (fisher[(a, b)], fisher[(b, a)]) = (sum, sum);
            }
            let (slope, information) = self.prior_slope(x, a);
            gradient[a] += slope;
            fisher[(a, a)] += information;
        }
        (gradient, fisher)
    }
}

/// A damped step inside bounds; what stands at one and is pushed outwards stays.
fn step(
    x: &[f64],
    bounds: &[(f64, f64)],
    gradient: &DVector<f64>,
    fisher: &DMatrix<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let held =
        |k: usize| (x[k] <= bounds[k].0 && gradient[k] < 0.0) || (x[k] >= bounds[k].1 && gradient[k] > 0.0);
    let open: Vec<usize> = (0..x.len()).filter(|&k| !held(k)).collect();
    let matrix = DMatrix::from_fn(open.len(), open.len(), |a, b| {
        let value: f64 = fisher[(open[a], open[b])];
        if a == b { value * (1.0 + damping) + 1e-9 } else { value }
    });
    let short = matrix.cholesky()?.solve(&DVector::from_fn(open.len(), |a, _| gradient[open[a]]));
    let mut step = DVector::zeros(x.len());
    for (a, &k) in open.iter().enumerate() {
        step[k] = short[a];
    }
    Some(step)
}
