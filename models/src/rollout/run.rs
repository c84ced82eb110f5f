//! Fixed-step Runge-Kutta rollouts.

use super::{Series, System};
use crate::model::column;
use crate::numeric::{Scalar, filled};

/// Where the pressures of a segment start.
#[derive(Debug, Clone, Copy, Default)]
pub enum Start<'a, const M: usize> {
    /// At the first usable measurement of the segment.
    #[default]
    Measured,
    /// At these absolute pressures in Pa, one entry per segment.
    Given(&'a [[f64; M]]),
}

impl<const M: usize> Start<'_, M> {
    /// The absolute pressures in Pa at which a segment starts.
    #[must_use]
    pub fn pressures(&self, series: &Series<M>, segment: usize) -> [f64; M] {
        match self {
            Start::Measured => series.starts()[segment],
            Start::Given(starts) => starts[segment],
        }
    }
}

/// One classical fourth-order Runge-Kutta step of length `h` (s).
#[inline(always)]
pub(super) fn rk4_step<S: Scalar, Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    coefficients: &Y::Coefficients<S>,
    held: &Y::Held<S>,
    state: [S; N],
    h: S::Real,
) -> [S; N] {
    let half = h.times(0.5);
    let k1 = system.derivative(coefficients, held, &state);
    let k2 = system.derivative(coefficients, held, &ahead(&state, &k1, half));
    let k3 = system.derivative(coefficients, held, &ahead(&state, &k2, half));
    let k4 = system.derivative(coefficients, held, &ahead(&state, &k3, h));
    let sum = filled(
        S::zero(),
        #[inline(always)]
        |i| (k1[i] + k4[i]) + (k2[i] + k3[i]).times(2.0),
    );
    ahead(&state, &sum, h.times(1.0 / 6.0))
}

/// `state + h slope`.
#[inline(always)]
fn ahead<S: Scalar, const N: usize>(state: &[S; N], slope: &[S; N], h: S::Real) -> [S; N] {
    filled(
        S::zero(),
        #[inline(always)]
        |i| state[i] + slope[i].scale(h),
    )
}

/// Where a rollout gets its rows of inputs from.
pub trait RowSource<R> {
    /// The inputs of row `k`; rows are asked for in order.
    fn row(&mut self, k: usize) -> &[R];
}

/// Consecutive rows of plain numbers, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    /// The values.
    pub inputs: &'a [f64],
    /// Columns in a row.
    pub width: usize,
}

impl RowSource<f64> for Rows<'_> {
    #[inline(always)]
    fn row(&mut self, k: usize) -> &[f64] {
        &self.inputs[k * self.width..][..self.width]
    }
}

/// How a sample interval is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Ticks per interval, as the system asks for.
    pub ticks: usize,
    /// Runge-Kutta steps per tick.
    pub substeps: usize,
}

/// Rolls `system` out over `count` rows, starting from `pressures` (absolute, Pa); `sink` gets each row's number and what
/// the sensors read there.
///
/// This is the one loop behind every simulation and fit; the others choose the numbers it runs over.
#[inline(always)]
pub fn rollout<S: Scalar, Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    coefficients: &Y::Coefficients<S>,
    (mut source, count): (impl RowSource<S::Real>, usize),
    pressures: [S; M],
    steps: Steps,
    mut sink: impl FnMut(usize, &[S; M]),
) {
    if count == 0 {
        return;
    }
    #[allow(clippy::cast_precision_loss)] // a handful of steps
    let share = 1.0 / (steps.ticks * steps.substeps) as f64;
    let (mut state, mut memory) = system.start(coefficients, source.row(0), pressures);
    for k in 0..count {
        let row = source.row(k);
        sink(k, &system.measure(coefficients, row, &state, &mut memory));
        if k + 1 == count {
            break;
        }
        let h = row[column::INTERVAL_S].times(share);
        for tick in 0..steps.ticks {
            let held = system.hold(coefficients, row, tick, &state, &mut memory);
            for _ in 0..steps.substeps {
                state = rk4_step(system, coefficients, &held, state, h);
            }
        }
    }
}

/// Simulates every segment from the inputs alone. Returns the sensors' readings (absolute, Pa) for each row; NaN outside
/// the segments. `parameters` in the order and units of [`System::parameters`].
pub fn simulate<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    parameters: &[f64],
    series: &Series<M>,
    start: Start<'_, M>,
    substeps: usize,
) -> Vec<[f64; M]> {
    let mut outputs = vec![[f64::NAN; M]; series.len()];
    for (segment, range) in series.segments().iter().enumerate() {
        let rows = Rows { inputs: series.inputs(range.clone()), width: series.width() };
        let pressures = start.pressures(series, segment);
        let steps = Steps { ticks: system.ticks(series.interval_s()), substeps };
        simulate_rows(system, parameters, rows, pressures, steps, &mut outputs[range.clone()]);
    }
    outputs
}

/// Simulates consecutive rows of inputs; `outputs` has one entry per row.
fn simulate_rows<Y: System<N, M>, const N: usize, const M: usize>(
    system: &Y,
    parameters: &[f64],
    rows: Rows<'_>,
    pressures: [f64; M],
    steps: Steps,
    outputs: &mut [[f64; M]],
) {
    let coefficients = system.coefficients(parameters);
    rollout(
        system,
        &coefficients,
        (rows, outputs.len()),
        pressures,
        steps,
        #[inline(always)]
        |k, y| outputs[k] = *y,
    );
}
