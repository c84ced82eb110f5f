//! A series simulated from its inputs.

use super::Series;
use super::source::{Rows, Steps};
use super::system::System;

/// Where the pressures of a segment start.
#[derive(Debug, Clone, Copy, Default)]
pub enum Start<'a> {
    /// At the first usable measurement of the segment.
    #[default]
    Measured,
    /// At these absolute pressures in Pa, one per segment.
    Given(&'a [f64]),
}

impl Start<'_> {
    /// The absolute pressure in Pa at which a segment starts.
    #[must_use]
    pub fn pressure(&self, series: &Series, segment: usize) -> f64 {
        match self {
            Start::Measured => series.starts()[segment],
            Start::Given(starts) => starts[segment],
        }
    }
}

/// Simulates every segment from the inputs alone. Returns what is recorded (absolute, Pa) for each
/// row; NaN outside the segments. `parameters` in the order and units of [`System::parameters`].
#[must_use]
pub fn simulate(
    system: &dyn System,
    parameters: &[f64],
    series: &Series,
    start: Start<'_>,
    substeps: usize,
) -> Vec<f64> {
    let mut outputs = vec![f64::NAN; series.len()];
    let steps = Steps { ticks: system.ticks(series.interval_s()), substeps };
    for (segment, range) in series.segments().iter().enumerate() {
        let rows = Rows { inputs: series.inputs(range.clone()), width: series.width() };
        let pressure = start.pressure(series, segment);
        system.simulate(parameters, rows, pressure, steps, &mut outputs[range.clone()]);
    }
    outputs
}
