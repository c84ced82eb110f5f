//! Profile likelihood: how far can one parameter move if all others make up for it?

use std::sync::atomic::AtomicBool;

use super::{Minimum, Objective, Stopping, minimise};

/// Refits per side of an interval at most.
const REFITS: usize = 12;

/// The interval of one coordinate in which refits of all others stay within a rise of the cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileInterval {
    /// Lower end; `None` when the bound is reached first: open on that side.
    pub lower: Option<f64>,
    /// Upper end; `None` when the bound is reached first.
    pub upper: Option<f64>,
}

/// Profiles one coordinate of a minimum. `rise` is the rise of the cost at the interval's ends;
/// `standard_error` the first guess of its half width. Ends are found to a twentieth of the half
/// width.
pub fn profile(
    objective: &(impl Objective + ?Sized),
    minimum: &Minimum,
    coordinate: usize,
    rise: f64,
    standard_error: f64,
    cancel: &AtomicBool,
) -> ProfileInterval {
    let side =
        |direction: f64| one_side(objective, minimum, coordinate, rise, direction * standard_error, cancel);
    ProfileInterval { lower: side(-1.0), upper: side(1.0) }
}

/// Follows the profile from the minimum in steps that start at `stride` until the rise is
/// bracketed, then closes in by the secant of the root of the rise, which is straight for a
/// parabola.
fn one_side(
    objective: &(impl Objective + ?Sized),
    minimum: &Minimum,
    coordinate: usize,
    rise: f64,
    stride: f64,
    cancel: &AtomicBool,
) -> Option<f64> {
    let bounds = objective.bounds();
    let (low, high) = bounds[coordinate];
    let centre = minimum.coordinates[coordinate];
    let wall = if stride > 0.0 { high } else { low };
    let whole = wall - centre;
    let mut warm = minimum.coordinates.clone();
    let mut root_of_rise = |distance: f64| {
        let mut bounds = bounds.clone();
        bounds[coordinate] = (centre + distance, centre + distance);
        let refit =
            minimise(objective, &bounds, &warm, &Stopping { evaluations: 40, ..Stopping::default() }, cancel);
        if refit.normal.is_finite() {
            warm.clone_from(&refit.coordinates);
        }
        (refit.normal.cost - minimum.normal.cost).max(0.0).sqrt()
    };
    let target = rise.sqrt();
    let (mut inside, mut root_inside) = (0.0, 0.0);
    let mut outside: Option<(f64, f64)> = None;
    let mut next = if stride.is_finite() && stride.abs() < whole.abs() { 2.0 * stride } else { whole };
    for _ in 0..REFITS {
        if next.abs() >= whole.abs() {
            next = whole;
        }
        let root = root_of_rise(next);
        if !root.is_finite() || root > target {
            outside = Some((next, root));
        } else {
            (inside, root_inside) = (next, root);
            if next == whole {
                return None;
            }
        }
        next = match outside {
            None => 2.0 * next,
            Some((far, root_far)) => {
                if (far - inside).abs() < 0.02 * far.abs() || (root - target).abs() < 0.01 * target {
                    break;
                }
                let share = (target - root_inside) / (root_far - root_inside);
                let share = if share.is_finite() { share.clamp(0.1, 0.9) } else { 0.5 };
                inside + share * (far - inside)
            }
        };
    }
    // The last point tried is the nearest; without a crossing within the bounds the side is open.
    outside.map(|(far, root_far)| {
        let share = (target - root_inside) / (root_far - root_inside);
        centre + inside + if share.is_finite() { share.clamp(0.0, 1.0) * (far - inside) } else { 0.0 }
    })
}
