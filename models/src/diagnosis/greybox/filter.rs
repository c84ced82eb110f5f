//! The extended Kalman filter over a channel with effects.
//!
//! The simulation's own memory is the state: it is run over numbers that carry their derivatives by
//! the state at the row before, so that every effect is linearised as it is simulated. What is
//! recorded enters as the filter's measurements; the drive is an input.

use super::kalman::{learn, propagate};
use super::uncertainty::Uncertainty;
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::{Memory, Simulated, Stepper, install};
use crate::numeric::{Dual, Scalar};

/// Where there is a tube, the pressure behind it differs from the measured one by so much at a
/// start, Pa.
const BEHIND_PA: f64 = 3e3;

/// One-step prediction errors of the counted rows, and the variances that the filter expects of
/// them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Innovations {
    /// Measured minus predicted, Pa.
    pub errors: Vec<f64>,
    /// Expected variances, Pa^2.
    pub variances: Vec<f64>,
}

/// How the filter followed the measurements, row by row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gains {
    /// Numbers in the state.
    pub state: usize,
    /// By how much a prediction error moves each of them, `state` to a row: 0 where nothing was
    /// measured.
    pub by_error: Vec<f64>,
    /// Largest error that moves the state as much as it is, Pa.
    pub most_pa: Vec<f64>,
}

/// Runs the filter through a channel's blocks, from every start on. Rows outside `counted` steer it
/// too. Where the simulation runs away, the last error is not a number.
#[must_use]
pub fn innovations(
    data: &ChannelData,
    model: &Extended,
    uncertainty: &Uncertainty,
    counted: &[bool],
) -> Innovations {
    filtered(data, model, uncertainty, counted).0
}

/// The same with the gains that it took.
#[must_use]
pub fn filtered(
    data: &ChannelData,
    model: &Extended,
    uncertainty: &Uncertainty,
    counted: &[bool],
) -> (Innovations, Gains) {
    match estimated(data, model) + SLOW {
        ..=4 => run::<4>(data, model, uncertainty, counted),
        _ => run::<8>(data, model, uncertainty, counted),
    }
}

/// States that stand for what is not modelled: supply and reading.
pub const SLOW: usize = 2;

/// Parts of them that are left after an interval.
pub fn kept(interval_s: f64) -> [f64; SLOW] {
    [SETTINGS.greybox_supply_s, SETTINGS.greybox_discrepancy_s]
        .map(|time_constant_s| (-interval_s / time_constant_s).exp())
}

/// Numbers that a simulation remembers and the filter estimates.
fn estimated(data: &ChannelData, model: &Extended) -> usize {
    let mut effects = install(&data.plant, &model.effects, &model.values);
    let mut simulation = Stepper::new(&data.plant, &model.values, &mut effects, &data.inputs);
    simulation.start(0);
    simulation.set_supply(data.inputs.supply_pa[0]);
    // Some remember nothing before their first step.
    simulation.interval(0);
    let mut count = 0;
    simulation.memory(&mut |memory, _| count += usize::from(memory == Memory::Estimated));
    count
}

/// Mean and covariance of the state, of which the first `n` numbers are in use: the simulation's
/// memory, supply, reading.
struct State<const N: usize> {
    mean: [f64; N],
    covariance: [[f64; N]; N],
    n: usize,
}

fn run<const N: usize>(
    data: &ChannelData,
    model: &Extended,
    uncertainty: &Uncertainty,
    counted: &[bool],
) -> (Innovations, Gains)
where
    Dual<f64, N>: Simulated<Real = f64>,
{
    let inputs = &data.inputs;
    let values: Vec<Dual<f64, N>> = model.values.iter().map(|v| Dual::from_real(*v)).collect();
    let mut effects = install(&data.plant, &model.effects, &values);
    let mut simulation = Stepper::new(&data.plant, &values, &mut effects, inputs);
    let (mut found, mut gains) = (Innovations::default(), Gains::default());
    let last = data.blocks.last().map_or(0, |block| block.end);
    let mut state = State::<N> { mean: [0.0; N], covariance: [[0.0; N]; N], n: 0 };
    // Relative deviation of the supply, and the reading's, Pa.
    let mut slow = [Dual::<f64, N>::from_real(0.0); SLOW];
    let mut next_start = inputs.starts.iter().peekable();
    for row in 0..last {
        if next_start.next_if_eq(&&row).is_some() {
            simulation.start(row);
            state.begin(&mut simulation, uncertainty);
            gains.state = state.n;
            gains.still();
        } else {
            let reading = simulation.reading(row) + slow[1];
            let variance = state.predict(&mut simulation, &slow, reading, uncertainty);
            if inputs.usable[row] {
                let error = inputs.measured_pa[row] - inputs.ambient_pa - reading.value;
                if counted[row] {
                    found.errors.push(error);
                    found.variances.push(variance.total);
                }
                if !(error.is_finite() && variance.total > 0.0) {
                    found.errors.push(f64::NAN);
                    found.variances.push(f64::NAN);
                    return (found, gains);
                }
                let most = SETTINGS.greybox_outlier * variance.total.sqrt();
                state.update(&variance, error.clamp(-most, most));
                gains.by_error.extend(variance.with_state[..state.n].iter().map(|c| c / variance.total));
                gains.most_pa.push(most);
            } else {
                gains.still();
            }
        }
        slow = state.seed(&mut simulation);
        simulation.set_supply(slow[0].plus(1.0).times(inputs.supply_pa[row]));
        simulation.interval(row);
        state.wander(&mut slow, inputs.interval_s[row], uncertainty);
    }
    (found, gains)
}

impl Gains {
    /// Of a row that does not move the state.
    fn still(&mut self) {
        self.by_error.resize(self.by_error.len() + self.state, 0.0);
        self.most_pa.push(0.0);
    }
}

/// Variance of a predicted reading, and its covariances with the state.
struct Predicted<const N: usize> {
    total: f64,
    with_state: [f64; N],
}

impl<const N: usize> State<N>
where
    Dual<f64, N>: Simulated<Real = f64>,
{
    /// At a start, where the pressure has just been measured.
    fn begin(&mut self, simulation: &mut Stepper<'_, Dual<f64, N>>, uncertainty: &Uncertainty) {
        self.read(simulation, &[Dual::from_real(0.0); SLOW]);
        self.covariance = [[0.0; N]; N];
        let noise = uncertainty.noise_pa.powi(2);
        let tube = simulation.has_tube();
        self.covariance[0][0] = if tube { BEHIND_PA.powi(2) } else { noise };
        if tube {
            self.covariance[1][1] = noise;
        }
        self.covariance[self.n - 2][self.n - 2] = uncertainty.supply.powi(2);
        self.covariance[self.n - 1][self.n - 1] = uncertainty.discrepancy_pa.powi(2);
    }

    /// Takes over the simulation's memory. Returns its derivatives by the state at the row before.
    fn read(
        &mut self,
        simulation: &mut Stepper<'_, Dual<f64, N>>,
        slow: &[Dual<f64, N>; SLOW],
    ) -> [[f64; N]; N] {
        let mut transition = [[0.0; N]; N];
        let (mean, mut n) = (&mut self.mean, 0);
        let mut take = |value: &Dual<f64, N>| {
            (mean[n], transition[n]) = (value.value, value.gradient);
            n += 1;
        };
        let mut room = N - SLOW;
        simulation.memory(&mut |memory, value| {
            if memory == Memory::Estimated && room > 0 {
                room -= 1;
                take(value);
            }
        });
        slow.iter().for_each(take);
        self.n = N - room;
        transition
    }

    /// From the row before to this one, before its measurement.
    fn predict(
        &mut self,
        simulation: &mut Stepper<'_, Dual<f64, N>>,
        slow: &[Dual<f64, N>; SLOW],
        reading: Dual<f64, N>,
        uncertainty: &Uncertainty,
    ) -> Predicted<N> {
        let transition = self.read(simulation, slow);
        let (with_state, of_state) = propagate(&mut self.covariance, &transition, &reading.gradient, self.n);
        Predicted { total: uncertainty.noise_pa.powi(2) + of_state, with_state }
    }

    /// Learns from a prediction error.
    fn update(&mut self, predicted: &Predicted<N>, error: f64) {
        let pull = error / predicted.total;
        for i in 0..self.n {
            self.mean[i] += predicted.with_state[i] * pull;
        }
        learn(&mut self.covariance, &predicted.with_state, predicted.total, self.n);
    }

    /// Hands the state back to the simulation, each of its numbers with a derivative of one by
    /// itself.
    fn seed(&self, simulation: &mut Stepper<'_, Dual<f64, N>>) -> [Dual<f64, N>; SLOW] {
        let mut k = 0;
        simulation.memory(&mut |memory, value| {
            value.gradient = [0.0; N];
            if memory == Memory::Estimated && k + SLOW < self.n {
                *value = Dual::variable(self.mean[k], k);
                k += 1;
            }
        });
        let variable = |k: usize| Dual::variable(self.mean[k], k);
        [variable(self.n - 2), variable(self.n - 1)]
    }

    /// The slow deviations fall back towards nothing, and are pushed anew, over an interval.
    fn wander(&mut self, slow: &mut [Dual<f64, N>; SLOW], interval_s: f64, uncertainty: &Uncertainty) {
        let (keep, sizes) = (kept(interval_s), [uncertainty.supply, uncertainty.discrepancy_pa]);
        for (k, value) in slow.iter_mut().enumerate() {
            let (keep, size) = (keep[k], sizes[k]);
            *value = value.times(keep);
            // Before the interval, and kept through it like the deviation itself.
            let at = self.n - SLOW + k;
            self.covariance[at][at] += size * size * ((keep * keep).recip() - 1.0);
        }
    }
}
