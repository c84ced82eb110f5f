//! What disturbances do to the readings: derivatives by what no parameter describes.

use super::limit_cycle::at_rest;
use crate::diagnosis::channel::{Block, ChannelData, Extended, HATS};
use crate::effects::{ChannelInputs, Disturbance, NARROW, NarrowSensitive, SENSITIVITIES, Sensitive};
use crate::numeric::{Dual, Scalar};

/// Disturbances of every block: the start pressure, the supply's level and slope, and [`FLOWS`].
pub const DISTURBANCES: usize = 3 + FLOWS;
/// Deviations of the flow.
pub const FLOWS: usize = 5;
/// Sines differentiated at a time.
pub const SINES: usize = SENSITIVITIES / 2;

impl ChannelData {
    /// Readings' derivatives by the disturbances that are free in every block: its start pressure
    /// (per kPa), the supply's level and slope (per part of its gauge pressure), and deviations of
    /// the flow (per part of it). Of a loop that hunts, those of the loop at rest: the others grow
    /// without bound.
    #[must_use]
    pub fn disturbances(&self, model: &Extended) -> Vec<[f64; DISTURBANCES]> {
        let model = &at_rest(self, model);
        let values = constants(model);
        let shape = BlockDisturbance::new(&self.inputs, &self.blocks, flow_deviations(self, model));
        self.run(model, &values, &shape).iter().map(first).collect()
    }

    /// Readings' derivatives by the amplitudes of a cosine and a sine in the supply (per part of
    /// its gauge pressure) at up to `SINES` frequencies in Hz.
    #[must_use]
    pub fn sine_derivatives(&self, model: &Extended, frequencies_hz: &[f64]) -> Vec<[f64; 2 * SINES]> {
        let values = constants(model);
        let shape = SineDisturbance { inputs: &self.inputs, frequencies_hz };
        self.rough().run(model, &values, &shape).iter().map(first).collect()
    }

    /// Readings' derivatives by the heights of functions that are added to the pressure's rate
    /// (kPa/s), given by their values at every row.
    #[must_use]
    pub fn rate_derivatives(&self, model: &Extended, functions: &[[f64; HATS]]) -> Vec<[f64; HATS]> {
        let values = constants(model);
        let shape = RateDisturbance { interval_s: &self.inputs.interval_s, functions };
        self.run(model, &values, &shape).iter().map(first).collect()
    }
}

/// A model's values, of which no derivatives are wanted.
fn constants<S: Scalar>(model: &Extended) -> Vec<S> {
    model.values.iter().map(|&value| S::constant(value)).collect()
}

/// The first derivatives of a reading.
fn first<const N: usize, const OF: usize>(reading: &Dual<f64, OF, f32>) -> [f64; N] {
    const { assert!(N <= OF) };
    std::array::from_fn(|k| f64::from(reading.gradient[k]))
}

/// Ratio of heat capacities that the work of a moving joint is counted with, between isothermal and
/// adiabatic.
const WORK_EXPONENT: f64 = 1.3;

/// What deviations of the flow add to the pressure's rate in every row's interval, kPa/s: the
/// inflow's and the outflow's slope over the valve's opening and over the pressure ratio, and the
/// outflow's level. The inflow's level does what the supply's does.
///
/// Only where the drive of a spool is recorded: a regulator has no flow that the model knows,
/// behind the board's loop they would hide what little of an effect is left there, and two valves
/// that are driven apart name worse with them.
fn flow_deviations(data: &ChannelData, model: &Extended) -> Vec<[f64; FLOWS]> {
    if !data.inputs.spool_is_recorded() {
        return Vec::new();
    }
    let (inputs, trace) = (&data.inputs, data.rough().trace(model));
    // Unit root mean square over 0 to 1.
    let slope = |x: f64| 3.0_f64.sqrt() * (2.0 * x.clamp(0.0, 1.0) - 1.0);
    let ambient = inputs.ambient_pa * 1e-3;
    let row = |k: usize| {
        let [reading, drive, ..] = trace[k];
        let next = trace[(k + 1).min(trace.len() - 1)][0];
        let pressure = (reading + ambient).max(0.1 * ambient);
        let work = WORK_EXPONENT * pressure * inputs.volume_rate_m3_s[k] / inputs.volume_m3[k];
        let rate = (next - reading) / inputs.interval_s[k] + work;
        let opening = slope(drive.abs());
        if rate > 0.0 {
            [rate * opening, rate * slope(pressure * 1e3 / inputs.supply_pa[k]), 0.0, 0.0, 0.0]
        } else {
            [0.0, 0.0, rate, rate * opening, rate * slope(ambient / pressure)]
        }
    };
    (0..inputs.rows()).map(row).collect()
}

/// As a [`Sensitive`] number has its slopes.
#[allow(clippy::cast_possible_truncation)] // that is what it is for
fn single(slope: f64) -> f32 {
    slope as f32
}

/// Derivatives of start pressure, supply level, supply slope and deviations of the flow, block by
/// block.
struct BlockDisturbance<'a> {
    /// Rows at which a block starts.
    starts: Vec<bool>,
    /// Gauge supply pressure (Pa) times 1 and times -1 to 1 over the block.
    supply: Vec<[f64; 2]>,
    interval_s: &'a [f64],
    /// [`flow_deviations`], or nothing.
    flows: Vec<[f64; FLOWS]>,
}

impl<'a> BlockDisturbance<'a> {
    fn new(inputs: &'a ChannelInputs, blocks: &[Block], flows: Vec<[f64; FLOWS]>) -> Self {
        let rows = inputs.rows();
        let (mut starts, mut supply) = (vec![false; rows], vec![[0.0; 2]; rows]);
        for block in blocks {
            starts[block.start] = true;
            let middle = 0.5 * (inputs.time_s[block.start] + inputs.time_s[block.end - 1]);
            let half = (inputs.time_s[block.end - 1] - middle).max(1e-9);
            for row in block.start..block.end {
                let gauge = inputs.supply_pa[row] - inputs.ambient_pa;
                supply[row] = [gauge, gauge * (inputs.time_s[row] - middle) / half];
            }
        }
        Self { starts, supply, interval_s: &inputs.interval_s, flows }
    }
}

impl Disturbance<NarrowSensitive> for BlockDisturbance<'_> {
    #[inline]
    fn supply(&self, row: usize, supply: NarrowSensitive) -> NarrowSensitive {
        let [level, slope] = self.supply[row];
        let mut disturbed = supply;
        (disturbed.gradient[1], disturbed.gradient[2]) = (single(level), single(slope));
        disturbed
    }

    #[inline]
    fn pressure(&self, row: usize, pressure: NarrowSensitive) -> NarrowSensitive {
        let mut disturbed = pressure;
        if self.starts[row] {
            disturbed.gradient = [0.0; NARROW];
            disturbed.gradient[0] = 1e3;
        } else if let Some(before) = row.checked_sub(1)
            && let Some(flows) = self.flows.get(before)
        {
            for k in 0..FLOWS {
                disturbed.gradient[DISTURBANCES - FLOWS + k] +=
                    single(1e3 * flows[k] * self.interval_s[before]);
            }
        }
        disturbed
    }
}

/// Derivatives of terms added to the pressure's rate, whose values are given at every row.
struct RateDisturbance<'a> {
    interval_s: &'a [f64],
    functions: &'a [[f64; HATS]],
}

impl Disturbance<NarrowSensitive> for RateDisturbance<'_> {
    #[inline]
    fn pressure(&self, row: usize, pressure: NarrowSensitive) -> NarrowSensitive {
        let mut disturbed = pressure;
        if let Some(before) = row.checked_sub(1) {
            for k in 0..HATS {
                disturbed.gradient[k] += single(1e3 * self.functions[before][k] * self.interval_s[before]);
            }
        }
        disturbed
    }
}

/// Derivatives of sines in the supply.
struct SineDisturbance<'a> {
    inputs: &'a ChannelInputs,
    frequencies_hz: &'a [f64],
}

impl Disturbance<Sensitive> for SineDisturbance<'_> {
    #[inline]
    fn supply(&self, row: usize, supply: Sensitive) -> Sensitive {
        let gauge = self.inputs.supply_pa[row] - self.inputs.ambient_pa;
        let middle = self.inputs.time_s[row] + 0.5 * self.inputs.interval_s[row];
        let mut disturbed = supply;
        for (k, frequency) in self.frequencies_hz.iter().enumerate() {
            let (sine, cosine) = (std::f64::consts::TAU * frequency * middle).sin_cos();
            (disturbed.gradient[2 * k], disturbed.gradient[2 * k + 1]) =
                (single(gauge * cosine), single(gauge * sine));
        }
        disturbed
    }
}
