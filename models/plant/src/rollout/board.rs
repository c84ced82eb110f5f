//! The board's own pressure controller in front of a chamber, in counts.
//!
//! At each tick the board samples the pressure, rounds it, filters it, and computes the spool's
//! drive by its [`Law`], clipped at the saturation; the command is a whole count. It reports what
//! it controls: the filtered pressure of its last loop, or, without a filter, the pressure itself.
//! The rounding of the reported value is left to the measurement noise.
//!
//! A row is an exchange: its pressure is what the board's last loop before it sampled, and that
//! loop still had the command of the row before. On this grid of loops the interval of a row
//! therefore begins with the loop that is reported, under the old command, and the row's own
//! command is in force from the next loop on, wherever between the two loops the exchange falls.
//!
//! Rounding passes derivatives through unchanged; where the drive or the converter is clipped they
//! are zero.

use crate::board::{Arithmetic, Board, Law};
use crate::model::column;
use crate::numeric::{Real, Scalar};

/// Steps of the filter's weights: boards filter in integers with `weight / 256`.
const FILTER_ONE: f64 = 256.0;

/// Fractions of a count this project's boards calculate with.
const FINE: f64 = 256.0;

/// What the board remembers between loops, in counts.
#[derive(Debug, Clone, Copy)]
pub struct LoopMemory<S: Scalar> {
    filtered: S,
    /// The command of the row before.
    command: S::Real,
    /// The drive of the last loop, -1 to 1.
    drive: S,
}

impl LoopMemory<f64> {
    /// Shows every number of it, in an order that stays; the last is the drive.
    pub fn values(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        [&mut self.filtered, &mut self.command, &mut self.drive].into_iter().for_each(visit);
    }
}

impl<S: Scalar<Real = S>> LoopMemory<S> {
    /// The filtered sample in counts, and the command of the row before.
    #[inline(always)]
    pub(super) fn state(&self) -> [S; 2] {
        [self.filtered, self.command]
    }
}

impl<S: Scalar> LoopMemory<S> {
    /// Where there is no board.
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self { filtered: S::zero(), command: S::Real::zero(), drive: S::zero() }
    }

    /// In the middle of a segment. The drive of the last loop has no effect.
    #[inline(always)]
    pub(super) fn resumed(filtered: S, command: S::Real) -> Self {
        Self { filtered, command, drive: S::zero() }
    }
}

impl Board {
    fn filters(&self) -> bool {
        self.controller.filter > 0.0
    }

    /// The controller's law, drive counts from pressure counts; the weight is one that the board
    /// calculates with.
    #[inline(always)]
    fn law(&self) -> Law {
        let weight = (self.controller.filter * FILTER_ONE).round() / FILTER_ONE;
        Law { gain: self.controller.kp, damping: self.controller.kd, weight }
    }

    /// Pressure in counts, not rounded.
    #[inline(always)]
    fn counts<S: Scalar>(&self, pressure: S) -> S {
        let gauge = pressure.plus(-self.ambient_pa);
        gauge.times(1.0 / self.sensor.pa_per_count()).plus(self.sensor.zero_counts)
    }

    /// Clipped to the converter's range and rounded to fractions of a count.
    #[inline(always)]
    fn code<S: Scalar>(&self, counts: S, fractions: f64) -> S {
        let rounded = counts.real().times(fractions).round_half_up().times(1.0 / fractions);
        counts.with_real(rounded).max(S::zero()).min(S::constant(self.sensor.full_scale_counts()))
    }

    /// A sample as the board's arithmetic sees it.
    #[inline(always)]
    fn sample<S: Scalar>(&self, pressure: S) -> S {
        match self.arithmetic {
            Arithmetic::Fine => self.code(self.counts(pressure), FINE),
            Arithmetic::Whole => self.code(self.counts(pressure), 1.0),
        }
    }

    /// The filtered pressure after one more sample.
    #[inline(always)]
    fn filter<S: Scalar>(&self, pressure: S, previous: S) -> S {
        let sample = self.sample(pressure);
        if !self.filters() {
            return sample;
        }
        let sum = self.law().filtered(sample, previous);
        match self.arithmetic {
            Arithmetic::Fine => sum,
            Arithmetic::Whole => sum.with_real(sum.real().floor()),
        }
    }

    /// One loop of the controller: the spool's drive, -1 to 1.
    #[inline(always)]
    pub fn control<S: Scalar>(&self, command: S, pressure: S, memory: &mut LoopMemory<S>) -> S {
        let previous = memory.filtered;
        memory.filtered = self.filter(pressure, previous);
        let drive = self.law().drive(self.code(self.counts(command), 1.0), memory.filtered, previous);
        let one = S::constant(1.0);
        drive.times(1.0 / self.controller.saturation).min(one).max(-one)
    }

    /// What it remembers at the start of a segment.
    #[inline(always)]
    pub(super) fn start<S: Scalar>(&self, row: &[S::Real], pressure: S) -> LoopMemory<S> {
        // What was commanded before the segment is not known: the command that it begins with.
        LoopMemory { filtered: self.sample(pressure), command: row[column::COMMAND_PA], drive: S::zero() }
    }

    /// What it reports, absolute, Pa.
    #[inline(always)]
    pub(super) fn report<S: Scalar>(&self, pressure: S, memory: &LoopMemory<S>) -> S {
        if !self.filters() {
            return pressure;
        }
        // The loop that samples this state runs at the first tick after the row.
        let filtered = self.filter(pressure, memory.filtered);
        filtered.plus(-self.sensor.zero_counts).times(self.sensor.pa_per_count()).plus(self.ambient_pa)
    }

    /// The spool's drive in loop number `tick` of a row's interval.
    #[inline(always)]
    pub(super) fn drive<S: Scalar>(
        &self,
        row: &[S::Real],
        tick: usize,
        pressure: S,
        memory: &mut LoopMemory<S>,
    ) -> S {
        let new = row[column::COMMAND_PA];
        let command = if tick == 0 { std::mem::replace(&mut memory.command, new) } else { new };
        memory.drive = self.control(S::from_real(command), pressure, memory);
        memory.drive
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::{Controller, Sensor};
    use crate::model::{Drive, Model, Parameter};
    use crate::rollout::{Chamber, Rows, Steps, rollout};

    /// The original's numbers: 0.5 to 4.5 V over 689.4757 kPa, filter (210 old + 46 new) / 256,
    /// gains 10 and 20, full drive 400.
    fn original(filter: f64, arithmetic: Arithmetic) -> Board {
        Board {
            controller: Controller { rate_hz: 1000.0, kp: 10.0, kd: 20.0, saturation: 400.0, filter },
            arithmetic,
            sensor: Sensor { bits: 10, zero_counts: 102.4, kpa_per_count: 0.841_645 },
            ambient_pa: 101_325.0,
        }
    }

    fn pressure_at(counts: f64) -> f64 {
        101_325.0 + (counts - 102.4) * 841.645
    }

    /// Rises at 1e5 Pa/s per unit of drive.
    struct Integrator;

    impl Model for Integrator {
        type Coefficients<S: Scalar> = ();
        type Held<S: Scalar> = S;

        fn name(&self) -> &'static str {
            "integrator"
        }

        fn parameters(&self) -> Vec<Parameter> {
            Vec::new()
        }

        fn coefficients<S: Scalar>(&self, _: &[S]) {}

        fn hold<S: Scalar>(&self, (): &(), _: &[S::Real], drive: Drive<S>) -> S {
            drive.fill
        }

        fn rate<S: Scalar>(&self, (): &(), held: &S, _: S) -> S {
            held.times(1e5)
        }
    }

    /// The pressures at rows 10 ms apart when the command jumps far up at row 2, Pa above the
    /// start.
    fn after_a_jump(filter: f64) -> Vec<f64> {
        const START: f64 = 201_325.0;
        let mut board = original(filter, Arithmetic::Fine);
        board.controller.kd = 0.0;
        let chamber = Chamber::behind(Integrator, board);
        let mut inputs = vec![0.0; 5 * column::COUNT];
        for (k, row) in inputs.chunks_mut(column::COUNT).enumerate() {
            row[column::INTERVAL_S] = 0.01;
            // The whole count next to the start, so that the drive is nearly nothing before the
            // jump.
            row[column::COMMAND_PA] = if k < 2 { pressure_at(221.0) } else { START + 1e5 };
        }
        let start = pressure_at(221.0);
        let mut pressures = Vec::new();
        let rows = (Rows { inputs: &inputs, width: column::COUNT }, 5);
        let steps = Steps { ticks: chamber.ticks(0.01), substeps: 1 };
        rollout(&chamber, &(), rows, start, steps, |_, y| pressures.push(y - start));
        pressures
    }

    #[test]
    fn the_loop_that_a_row_reports_has_the_command_of_the_row_before() {
        let pressures = after_a_jump(0.0);
        // Nine of the ten loops after row 2 know its command and drive fully: 100 Pa each.
        assert!(pressures[2].abs() < 1e-6, "{pressures:?}");
        assert!((pressures[3] - 900.0).abs() < 1e-6, "{pressures:?}");
        assert!((pressures[4] - 1900.0).abs() < 1e-6, "{pressures:?}");
    }

    #[test]
    fn the_reported_filtered_pressure_contains_the_sample_of_the_row() {
        // A ramp of 100 Pa a loop, filtered with weight w, settles w / (1 - w) loops behind: 1 loop
        // for one half.
        let pressures = after_a_jump(0.5);
        assert!((pressures[4] - (1900.0 - 100.0)).abs() < 4.0, "{pressures:?}");
    }

    #[test]
    fn the_originals_filter_settles_five_counts_low_and_ours_does_not() {
        for (arithmetic, settled) in [(Arithmetic::Whole, 495.0), (Arithmetic::Fine, 500.0)] {
            let board = original(210.0 / 256.0, arithmetic);
            let mut memory = LoopMemory { filtered: 102.0, command: 0.0, drive: 0.0 };
            for _ in 0..200 {
                board.control(pressure_at(500.0), pressure_at(500.0), &mut memory);
            }
            assert!((memory.filtered - settled).abs() < 1e-9, "{arithmetic:?}: {}", memory.filtered);
        }
    }

    #[test]
    fn the_drive_is_the_originals() {
        // (command, pressure, previous) -> 10 (command - pressure) - 20 (pressure - previous),
        // clipped at 400
        let table = [
            ((500.0, 500.0, 500.0), 0.0),
            ((539.0, 500.0, 500.0), 390.0),
            ((560.0, 500.0, 500.0), 400.0),
            ((520.0, 500.0, 495.0), 100.0),
            ((520.0, 500.0, 470.0), -400.0),
        ];
        let board = original(0.0, Arithmetic::Whole);
        for ((command, pressure, previous), drive) in table {
            let mut memory = LoopMemory { filtered: previous, command: 0.0, drive: 0.0 };
            let got = board.control(pressure_at(command), pressure_at(pressure), &mut memory) * 400.0;
            assert!((got - drive).abs() < 1e-9, "command {command}, pressure {pressure}: {got}, not {drive}");
        }
    }
}
