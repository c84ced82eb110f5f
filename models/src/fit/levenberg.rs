//! Levenberg-Marquardt within a box.
//!
//! Damping after Nielsen (1999), scaling by the largest diagonal of `J^T J` seen so far after Moré
//! (1978). A variable that would leave the box is put on its bound and the step of the others
//! solved again; a variable on a bound whose gradient points outwards is left out.

use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Cholesky, DMatrix, DVector};

use super::{Normal, Objective};

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stopping {
    /// Evaluations of the normal equations at most.
    pub evaluations: usize,
    /// Relative decrease of the cost, made and predicted, that ends the search.
    pub cost_tolerance: f64,
    /// Cosine between the residuals and any column of the Jacobian that ends the search.
    pub gradient_tolerance: f64,
}

impl Default for Stopping {
    /// A relative decrease of 5e-9 of the cost of 20,000 residuals is a step of a hundredth of a
    /// standard error.
    fn default() -> Self {
        Self { evaluations: 200, cost_tolerance: 5e-9, gradient_tolerance: 1e-10 }
    }
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// The cost no longer decreases.
    Converged,
    /// The number of evaluations ran out.
    Evaluations,
    /// No step decreases the cost although the gradient does not vanish (rounding, or a kink).
    NoProgress,
    /// The simulation runs away at the start.
    NotFinite,
    /// The caller asked to stop.
    Cancelled,
}

/// Where a search ended.
#[derive(Debug, Clone)]
pub struct Minimum {
    /// Coordinates.
    pub coordinates: Vec<f64>,
    /// Normal equations there.
    pub normal: Normal,
    /// Coordinates that sit on a bound with the gradient pointing outwards.
    pub active: Vec<bool>,
    /// Evaluations of the normal equations.
    pub evaluations: usize,
    /// Why it ended.
    pub ending: Ending,
}

/// Searches the least sum of squares from `start` (moved into `bounds`). Equal bounds keep a
/// coordinate where it is.
pub fn minimise(
    objective: &(impl Objective + ?Sized),
    bounds: &[(f64, f64)],
    start: &[f64],
    stopping: &Stopping,
    cancel: &AtomicBool,
) -> Minimum {
    let mut x: Vec<f64> = start.iter().zip(bounds).map(|(x, (low, high))| x.max(*low).min(*high)).collect();
    let mut normal = objective.normal(&x);
    let mut evaluations = 1;
    let mut scale = DVector::<f64>::zeros(x.len());
    let (mut damping, mut growth) = (1e-3, 2.0);
    let mut ending = if normal.is_finite() { None } else { Some(Ending::NotFinite) };
    while ending.is_none() {
        for (i, scale) in scale.iter_mut().enumerate() {
            *scale = scale.max(normal.matrix[(i, i)]);
        }
        let blocked = blocked(&x, bounds, &normal.gradient);
        if steepest(&normal, &blocked) < stopping.gradient_tolerance {
            ending = Some(Ending::Converged);
            break;
        }
        // Tries steps until one decreases the cost.
        loop {
            if cancel.load(Ordering::Relaxed) {
                ending = Some(Ending::Cancelled);
                break;
            }
            if evaluations >= stopping.evaluations {
                ending = Some(Ending::Evaluations);
                break;
            }
            let step = boxed_step(&normal, &scale, damping, &x, bounds, &blocked);
            let predicted = -(2.0 * normal.gradient.dot(&step) + step.dot(&(&normal.matrix * &step)));
            let trial: Vec<f64> = x
                .iter()
                .zip(&step)
                .zip(bounds)
                .map(|((x, d), (low, high))| (x + d).max(*low).min(*high))
                .collect();
            let negligible = predicted <= stopping.cost_tolerance * normal.cost;
            // A strongly damped step promises little anywhere; that is no sign of a minimum.
            if negligible && damping <= 1e-2 {
                ending = Some(Ending::Converged);
                break;
            }
            evaluations += 1;
            let next = if evaluations < stopping.evaluations {
                objective.normal(&trial)
            } else {
                objective.last(&trial)
            };
            let gain = (normal.cost - next.cost) / predicted;
            if next.is_finite() && gain > 1e-4 {
                let decrease = normal.cost - next.cost;
                if decrease <= stopping.cost_tolerance * normal.cost && negligible {
                    ending = Some(Ending::Converged);
                }
                damping = (damping * f64::max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0).powi(3))).max(1e-14);
                growth = 2.0;
                x = trial;
                normal = next;
                break;
            }
            damping *= growth;
            growth *= 2.0;
            if damping > 1e12 {
                // Even a step along the gradient that changes nothing measurable is not an
                // improvement.
                ending = Some(if negligible { Ending::Converged } else { Ending::NoProgress });
                break;
            }
        }
    }
    let active = blocked(&x, bounds, &normal.gradient);
    Minimum { coordinates: x, normal, active, evaluations, ending: ending.unwrap_or(Ending::Converged) }
}

/// Coordinates that cannot move downhill: fixed, or on a bound with the descent pointing outwards.
fn blocked(x: &[f64], bounds: &[(f64, f64)], gradient: &DVector<f64>) -> Vec<bool> {
    let blocked = |((x, (low, high)), gradient): ((&f64, &(f64, f64)), &f64)| {
        low >= high || (x <= low && *gradient > 0.0) || (x >= high && *gradient < 0.0)
    };
    x.iter().zip(bounds).zip(gradient.iter()).map(blocked).collect()
}

/// Largest cosine between the residuals and a column of the Jacobian that may move.
fn steepest(normal: &Normal, blocked: &[bool]) -> f64 {
    let cosine = |i: usize| {
        let length = (normal.matrix[(i, i)] * normal.cost).sqrt();
        if length > 0.0 { normal.gradient[i].abs() / length } else { 0.0 }
    };
    (0..blocked.len()).filter(|&i| !blocked[i]).map(cosine).fold(0.0, f64::max)
}

/// The damped step, with variables that would leave the box put on its wall.
fn boxed_step(
    normal: &Normal,
    scale: &DVector<f64>,
    damping: f64,
    x: &[f64],
    bounds: &[(f64, f64)],
    blocked: &[bool],
) -> DVector<f64> {
    let mut step = DVector::zeros(x.len());
    let mut free: Vec<usize> = (0..x.len()).filter(|&i| !blocked[i] && normal.matrix[(i, i)] > 0.0).collect();
    while !free.is_empty() {
        let matrix = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            let value = normal.matrix[(free[i], free[j])];
            if i == j { value + damping * scale[free[i]] } else { value }
        });
        let pushed = &normal.matrix * &step;
        let right = DVector::from_fn(free.len(), |i, _| -normal.gradient[free[i]] - pushed[free[i]]);
        let solved = match Cholesky::new(matrix) {
            Some(factor) => factor.solve(&right),
            // Rounding made it indefinite: a scaled gradient step.
            None => DVector::from_fn(free.len(), |i, _| right[i] / (scale[free[i]] * (1.0 + damping))),
        };
        let outside = |i: usize| {
            let (low, high) = bounds[free[i]];
            let target = x[free[i]] + solved[i];
            if target < low {
                Some(low - x[free[i]])
            } else if target > high {
                Some(high - x[free[i]])
            } else {
                None
            }
        };
        let walls: Vec<(usize, f64)> = (0..free.len()).filter_map(|i| Some((free[i], outside(i)?))).collect();
        if walls.is_empty() {
            for (i, &index) in free.iter().enumerate() {
                step[index] = solved[i];
            }
            break;
        }
        for (index, distance) in &walls {
            step[*index] = *distance;
        }
        free.retain(|index| walls.iter().all(|(wall, _)| wall != index));
    }
    step
}
