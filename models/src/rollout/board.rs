//! The board's own pressure controller in front of a chamber.

use super::System;
use crate::model::{Drive, Model, Parameter, column};
use crate::numeric::{Real, Scalar};

/// Steps of the filter's weights: the board filters in integers with `weight / 256`.
const FILTER_ONE: f64 = 256.0;

/// The board's controller, in ADC counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// Loops per second.
    pub rate_hz: f64,
    /// Drive counts per count of error.
    pub kp: f64,
    /// Drive counts per count of change between two loops.
    pub kd: f64,
    /// Drive counts at full drive, positive.
    pub saturation: f64,
    /// Weight of the previous filtered sample, 0 to 1; the board rounds it to 256ths.
    pub filter: f64,
}

/// The board's pressure sensor and converter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Bits of the converter.
    pub bits: u32,
    /// Counts at ambient pressure.
    pub zero_counts: f64,
    /// Pressure of one count, kPa.
    pub kpa_per_count: f64,
}

/// A chamber behind the board's controller: driven by the command alone.
///
/// At each tick the board samples and rounds the pressure to counts, filters it in integers (rounding down), and computes the
/// spool's drive `kp (command - pressure) - kd (pressure - previous)`, clipped at the saturation. It reports what it
/// controls: the filtered pressure, or, without a filter, the pressure itself (the rounding of the reported value is left to
/// the measurement noise).
///
/// Rounding passes derivatives through unchanged; where the drive or the converter is clipped they are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Board<Q> {
    /// The model of the chamber.
    pub chamber: Q,
    /// The controller.
    pub controller: Controller,
    /// The sensor it controls by.
    pub sensor: Sensor,
    /// Ambient pressure, Pa, the zero of gauge pressures.
    pub ambient_pa: f64,
}

/// What the board remembers between loops, in counts.
#[derive(Debug, Clone, Copy)]
pub struct LoopMemory<S> {
    filtered: S,
}

impl<Q> Board<Q> {
    fn filters(&self) -> bool {
        self.controller.filter > 0.0
    }

    fn pa_per_count(&self) -> f64 {
        self.sensor.kpa_per_count * 1e3
    }

    /// Pressure in counts, not rounded.
    #[inline(always)]
    fn counts<S: Scalar>(&self, pressure: S) -> S {
        pressure.plus(-self.ambient_pa).times(1.0 / self.pa_per_count()).plus(self.sensor.zero_counts)
    }

    /// Rounded to a code of the converter.
    #[inline(always)]
    fn code<S: Scalar>(&self, counts: S) -> S {
        let largest = f64::from(self.sensor.bits).exp2() - 1.0;
        let rounded = counts.with_real(counts.real().round_half_up());
        rounded.max(S::zero()).min(S::constant(largest))
    }

    /// One loop of the controller: the spool's drive, -1 to 1.
    #[inline(always)]
    pub fn control<S: Scalar>(&self, command: S, pressure: S, memory: &mut LoopMemory<S>) -> S {
        let sample = self.code(self.counts(pressure));
        let previous = memory.filtered;
        memory.filtered = if self.filters() {
            let weight = (self.controller.filter * FILTER_ONE).round() / FILTER_ONE;
            let sum = previous.times(weight) + sample.times(1.0 - weight);
            sum.with_real(sum.real().floor())
        } else {
            sample
        };
        let error = self.code(self.counts(command)) - memory.filtered;
        let change = memory.filtered - previous;
        let drive = error.times(self.controller.kp) - change.times(self.controller.kd);
        let one = S::constant(1.0);
        drive.times(1.0 / self.controller.saturation).min(one).max(-one)
    }
}

impl<Q: Model> System<1, 1> for Board<Q> {
    type Coefficients<S: Scalar> = Q::Coefficients<S>;
    type Memory<S: Scalar> = LoopMemory<S>;
    type Held<S: Scalar> = Q::Held<S>;

    fn parameters(&self) -> Vec<Parameter> {
        self.chamber.parameters()
    }

    #[inline(always)]
    fn coefficients<S: Scalar>(&self, parameters: &[S]) -> Self::Coefficients<S> {
        self.chamber.coefficients(parameters)
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // rounded and at least one
    fn ticks(&self, interval_s: f64) -> usize {
        (interval_s * self.controller.rate_hz).round().max(1.0) as usize
    }

    #[inline(always)]
    fn start<S: Scalar>(
        &self,
        _: &Self::Coefficients<S>,
        _: &[S::Real],
        pressures: [S; 1],
    ) -> ([S; 1], LoopMemory<S>) {
        (pressures, LoopMemory { filtered: self.code(self.counts(pressures[0])) })
    }

    #[inline(always)]
    fn measure<S: Scalar>(
        &self,
        _: &Self::Coefficients<S>,
        _: &[S::Real],
        state: &[S; 1],
        memory: &mut LoopMemory<S>,
    ) -> [S; 1] {
        if !self.filters() {
            return *state;
        }
        let gauge = memory.filtered.plus(-self.sensor.zero_counts).times(self.pa_per_count());
        [gauge.plus(self.ambient_pa)]
    }

    #[inline(always)]
    fn hold<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        row: &[S::Real],
        _tick: usize,
        state: &[S; 1],
        memory: &mut LoopMemory<S>,
    ) -> Self::Held<S> {
        let drive = Drive::recorded(row);
        debug_assert!(row.len() >= column::COUNT, "a row has the standard columns");
        let spool = self.control(drive.command, state[0], memory);
        self.chamber.hold(coefficients, row, drive.with_spool(spool))
    }

    #[inline(always)]
    fn derivative<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        held: &Self::Held<S>,
        state: &[S; 1],
    ) -> [S; 1] {
        [self.chamber.rate(coefficients, held, state[0])]
    }
}
