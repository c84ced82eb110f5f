//! Is the step short enough? Halve it and see.

use super::simulate::{Start, simulate};
use super::{Series, System};

/// Difference between a rollout and the same with half the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepCheck {
    /// Substeps per tick that were checked.
    pub substeps: usize,
    /// Root mean square difference, Pa.
    pub rms_pa: f64,
    /// Largest difference, Pa.
    pub max_pa: f64,
}

/// Compares a rollout with `substeps` Runge-Kutta steps per tick with one of twice as many. Of a
/// fourth-order method the difference is 15/16 of the coarser one's error.
#[must_use]
pub fn step_check(
    system: &dyn System,
    parameters: &[f64],
    series: &Series,
    start: Start<'_>,
    substeps: usize,
) -> StepCheck {
    let coarse = simulate(system, parameters, series, start, substeps);
    let fine = simulate(system, parameters, series, start, 2 * substeps);
    compare(substeps, series, &coarse, &fine)
}

/// Doubles the substeps from `least` until the [`step_check`] stays below `tolerance_pa`
/// everywhere, or until twice as many would exceed `most`: compare the returned `max_pa`.
#[must_use]
pub fn choose_substeps(
    system: &dyn System,
    parameters: &[f64],
    series: &Series,
    start: Start<'_>,
    (least, most): (usize, usize),
    tolerance_pa: f64,
) -> StepCheck {
    let mut substeps = least;
    let mut coarse = simulate(system, parameters, series, start, substeps);
    loop {
        let fine = simulate(system, parameters, series, start, 2 * substeps);
        let check = compare(substeps, series, &coarse, &fine);
        if check.max_pa < tolerance_pa || 2 * substeps > most {
            return check;
        }
        substeps *= 2;
        coarse = fine;
    }
}

fn compare(substeps: usize, series: &Series, coarse: &[f64], fine: &[f64]) -> StepCheck {
    let (mut sum, mut count, mut max_pa) = (0.0, 0.0, 0.0_f64);
    for row in series.segments().iter().flat_map(Clone::clone) {
        // A rollout that ran away is infinitely wrong, not skipped.
        let difference = coarse[row] - fine[row];
        let difference = if difference.is_nan() { f64::INFINITY } else { difference.abs() };
        sum += difference * difference;
        count += 1.0;
        max_pa = max_pa.max(difference);
    }
    StepCheck { substeps, rms_pa: (sum / f64::max(count, 1.0)).sqrt(), max_pa }
}
