//! Residuals of several segments at a time, summed up side by side.

use std::ops::Range;

use multiversion::multiversion;

use super::normal::Accumulator;
use crate::numeric::{Lanes, Scalar};
use crate::rollout::{DIRECTIONS, DualLanes, SENSITIVITY_LANES, Series};

/// Residuals are in kPa.
pub(super) const KPA_PER_PA: f64 = 1e-3;

/// Sums of the residuals of as many segments as there are lanes.
pub(super) type LaneSums = Accumulator<Lanes<SENSITIVITY_LANES>, DIRECTIONS>;

/// What pressures are compared with: measurement (absolute, Pa), and weight with the residual's
/// unit.
#[derive(Debug, Clone, Copy)]
struct Comparison {
    measured: Lanes<SENSITIVITY_LANES>,
    weight: Lanes<SENSITIVITY_LANES>,
}

impl Comparison {
    /// Of row `k` of each segment. A lane whose segment is over, or whose sample is masked, weighs
    /// nothing.
    fn of(series: &Series, segments: &[Range<usize>], k: usize) -> Self {
        let (measured, weights) = (series.measured(), series.weights());
        let mut comparison = Self { measured: Lanes::constant(0.0), weight: Lanes::constant(0.0) };
        for lane in 0..segments.len() {
            let row = segments[lane].start + k;
            if row < segments[lane].end && weights[row] > 0.0 {
                comparison.measured.0[lane] = measured[row];
                comparison.weight.0[lane] = weights[row] * KPA_PER_PA;
            }
        }
        comparison
    }
}

/// Adds the residuals of the rows from `first` on of each segment, where the simulated pressures
/// are `pressures` (absolute, Pa).
pub(super) fn add_rows(
    sums: &mut LaneSums,
    (series, segments): (&Series, &[Range<usize>]),
    first: usize,
    pressures: &[DualLanes],
) {
    let comparisons: Vec<Comparison> =
        (first..first + pressures.len()).map(|k| Comparison::of(series, segments, k)).collect();
    add_weighted(sums, pressures, &comparisons);
}

#[multiversion(targets("x86_64+avx2"))]
fn add_weighted(sums: &mut LaneSums, pressures: &[DualLanes], comparisons: &[Comparison]) {
    for (pressure, comparison) in pressures.iter().zip(comparisons) {
        sums.add(&(*pressure - DualLanes::from_real(comparison.measured)).scale(comparison.weight));
    }
}

/// Adds residuals.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn add(sums: &mut LaneSums, residuals: &[DualLanes]) {
    for residual in residuals {
        sums.add(residual);
    }
}
