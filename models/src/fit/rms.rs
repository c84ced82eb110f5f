//! How far a rollout is from the measurements.

use crate::rollout::{Series, Start, System, simulate};

/// Residuals are in kPa.
const KPA_PER_PA: f64 = 1e-3;

/// Root mean square difference in kPa between a rollout and the usable measurements, and their number.
pub fn rollout_rms_kpa<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    parameters: &[f64],
    series: &Series<M>,
    start: Start<'_, M>,
    substeps: usize,
) -> (f64, usize) {
    let outputs = simulate(system, parameters, series, start, substeps);
    let (mut sum, mut count) = (0.0, 0_u32);
    for row in series.segments().iter().flat_map(Clone::clone) {
        let measured = series.measured()[row].iter().zip(&series.weights()[row]);
        for (simulated, (measured, _)) in outputs[row].iter().zip(measured).filter(|(_, (_, w))| **w > 0.0) {
            sum += ((simulated - measured) * KPA_PER_PA).powi(2);
            count += 1;
        }
    }
    ((sum / f64::from(count)).sqrt(), count as usize)
}
