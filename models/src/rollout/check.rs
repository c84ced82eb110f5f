//! Is the step short enough? Halve it and see.

use super::{Series, Start, System, simulate};

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

/// Compares a rollout with `substeps` Runge-Kutta steps per tick with one of twice as many. Of a fourth-order method the
/// difference is 15/16 of the coarser one's error.
pub fn step_check<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    parameters: &[f64],
    series: &Series<M>,
    start: Start<'_, M>,
    substeps: usize,
) -> StepCheck {
    let coarse = simulate(system, parameters, series, start, substeps);
    let fine = simulate(system, parameters, series, start, 2 * substeps);
    compare(substeps, series, &coarse, &fine)
}

/// Doubles the substeps from `least` until the [`step_check`] stays below `tolerance_pa` everywhere, or until twice as many
/// would exceed `most`: compare the returned `max_pa`.
pub fn choose_substeps<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    parameters: &[f64],
    series: &Series<M>,
    start: Start<'_, M>,
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

fn compare<const M: usize>(
    substeps: usize,
    series: &Series<M>,
    coarse: &[[f64; M]],
    fine: &[[f64; M]],
) -> StepCheck {
    let (mut sum, mut count, mut max_pa) = (0.0, 0.0, 0.0_f64);
    for row in series.segments().iter().flat_map(Clone::clone) {
        for (a, b) in coarse[row].iter().zip(&fine[row]) {
            // A rollout that ran away is infinitely wrong, not skipped.
            let difference = if (a - b).is_nan() { f64::INFINITY } else { (a - b).abs() };
            sum += difference * difference;
            count += 1.0;
            max_pa = max_pa.max(difference);
        }
    }
    StepCheck { substeps, rms_pa: (sum / f64::max(count, 1.0)).sqrt(), max_pa }
}
