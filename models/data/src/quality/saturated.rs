//! Samples at a limit of the sensor say "at least" or "at most", not "equal".

use serde::{Deserialize, Serialize};

use super::finding::{Finding, FindingKind, counted, rows_text, spans_where};
use crate::{ChannelId, Flags};

/// What the pressure sensor and its converter can express.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SensorLimits {
    /// Pressure at the lowest code, kPa gauge.
    pub low_kpa: f64,
    /// Pressure at the highest code, kPa gauge.
    pub high_kpa: f64,
    /// One step of the converter, kPa.
    pub step_kpa: f64,
}

/// Marks the rows where `values` is within half a step of a limit.
pub(crate) fn mark_saturated(
    id: ChannelId,
    time_s: &[f64],
    line: &[u32],
    values: &[f32],
    limits: &SensorLimits,
    flags: &mut [Flags],
) -> Option<Finding> {
    let low = limits.low_kpa + 0.5 * limits.step_kpa;
    let high = limits.high_kpa - 0.5 * limits.step_kpa;
    let outside = |value: f32| f64::from(value) <= low || f64::from(value) >= high;
    let mut count = 0;
    for (flag, value) in flags.iter_mut().zip(values) {
        if outside(*value) {
            flag.insert(Flags::SATURATED);
            count += 1;
        }
    }
    if count == 0 {
        return None;
    }
    let spans = spans_where(time_s, line, |row| outside(values[row]));
    let sentence = format!(
        "{}: {} at or beyond the sensor's limits of {:.1} and {:.1} kPa ({}); nothing is compared with the simulation there.",
        id.pressure_column(),
        counted(count, "sample"),
        limits.low_kpa,
        limits.high_kpa,
        rows_text(&spans)
    );
    Some(Finding::new(FindingKind::Saturated, Some(id), count, spans, sentence))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_are_masked_and_nothing_between() {
        let limits = SensorLimits { low_kpa: 0.0, high_kpa: 100.0, step_kpa: 1.0 };
        let values = [0.0, 0.4, 0.6, 50.0, 99.4, 99.6, 100.0, 120.0, f32::NAN];
        let time: Vec<f64> = (0..9).map(f64::from).collect();
        let line: Vec<u32> = (2..11).collect();
        let mut flags = [Flags::NONE; 9];
        let id = ChannelId { board: 0, channel: 0 };
        let finding =
            mark_saturated(id, &time, &line, &values, &limits, &mut flags).expect("limits are touched");
        let masked: Vec<bool> = flags.iter().map(|f| !f.pressure_usable()).collect();
        assert_eq!(masked, [true, true, false, false, false, true, true, true, false]);
        assert_eq!(finding.count, 5);
    }
}
