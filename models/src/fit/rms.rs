//! How far a rollout is from the measurements.

use crate::rollout::{Series, Start, System, simulate};

/// Residuals are in kPa.
const KPA_PER_PA: f64 = 1e-3;

/// Root mean square difference in kPa between a rollout and the usable measurements, and their
/// number.
#[must_use]
pub fn rollout_rms_kpa(
    system: &dyn System,
    parameters: &[f64],
    series: &Series,
    start: Start<'_>,
    substeps: usize,
) -> (f64, usize) {
    let outputs = simulate(system, parameters, series, start, substeps);
    let (mut sum, mut count) = (0.0, 0_u32);
    for row in series.segments().iter().flat_map(Clone::clone) {
        if series.weights()[row] > 0.0 {
            sum += ((outputs[row] - series.measured()[row]) * KPA_PER_PA).powi(2);
            count += 1;
        }
    }
    ((sum / f64::from(count)).sqrt(), count as usize)
}
