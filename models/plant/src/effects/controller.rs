//! The board's pressure controller in front of a channel that is simulated with effects.

use super::deviations::Deviations;
use super::dither::{QUANTILES, dither, quantiles};
use super::hook::Memory;
use super::inputs::ChannelInputs;
use super::plant::BoardLoop;
use crate::numeric::Scalar;

/// What the board's pulse width leaves out in the mean: 400 drive counts become 255 steps of pulse
/// width by 51/80, cut off towards zero, as in the original; the parts that are cut off are equally
/// likely multiples of 1/80 step.
const CUT_OFF: f64 = 79.0 / 160.0 / 255.0;

/// What the controller remembers between its loops.
#[derive(Debug, Clone, Copy)]
pub struct Controller<S> {
    /// What the sensor delivered a step before, gauge, and the pressure at it, Pa.
    before: (S, S),
    /// The filtered sample, gauge, Pa.
    filtered: S,
    quantiles: &'static [f64; QUANTILES],
}

/// A step of the simulation in front of which the controller stands: one of its loops or several.
#[derive(Debug, Clone, Copy)]
pub struct Pace<'a> {
    board: &'a BoardLoop,
    /// Loops in a step.
    pub loops: usize,
    /// Standard deviation of the sensor's noise as the loop sees it, Pa.
    noise_pa: f64,
}

/// Codes of the board's converter in one of those that it reports.
const FINER: f64 = 4.0;

impl<'a> Pace<'a> {
    /// For steps of this length, where what is reported has this noise, Pa.
    #[inline(always)]
    pub fn new(board: &'a BoardLoop, length_s: f64, noise_pa: f64) -> Self {
        let loops = board.ticks(length_s);
        let rounded = board.rounding_pa * board.rounding_pa;
        let own = rounded / (FINER * FINER);
        let noise_pa = (noise_pa * noise_pa - rounded + own).max(own).sqrt();
        Self { board, loops, noise_pa }
    }
}

impl<S: Scalar> Controller<S> {
    /// Not started yet.
    pub fn new() -> Self {
        Self { before: (S::zero(), S::zero()), filtered: S::zero(), quantiles: quantiles() }
    }

    /// Begins at rest where the sensor delivers `reading`, gauge, Pa, of this pressure, Pa.
    pub fn start(&mut self, reading: S, pressure: S) {
        (self.before, self.filtered) = ((reading, pressure), reading);
    }

    /// Shows what it remembers: the filtered sample, and the step before.
    pub fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        visit(Memory::Estimated, &mut self.filtered);
        visit(Memory::Known, &mut self.before.0);
        visit(Memory::Known, &mut self.before.1);
    }

    /// Follows a jump of the pressure, Pa.
    pub fn shift(&mut self, change: S) {
        self.before = (self.before.0 + change, self.before.1 + change);
    }

    /// What the board reports: the filtered pressure where it filters. The loop that samples this
    /// reading runs at the first step after the row.
    #[inline(always)]
    pub fn report(&self, board: &BoardLoop, reading: S) -> S {
        board.law.filtered(reading, self.filtered)
    }

    /// Begins a step in which the sensor delivers `reading`, gauge, Pa, of the pressure `pressure`,
    /// Pa; returns how far the reading will go in the step, if it goes on as it did. In a step of
    /// several loops that is what the later ones see. The reading of an old sample does not go on,
    /// and after it jumps only once: the chamber says how far it can have gone.
    #[inline(always)]
    pub fn begin(&mut self, reading: S, pressure: S) -> S {
        let (read, moved) = (reading - self.before.0, pressure - self.before.1);
        self.before = (reading, pressure);
        read.max(moved.min(S::zero())).min(moved.max(S::zero()))
    }

    /// The drive of loop `tick` of a row's interval, -1 to 1, where the sensor delivers `reading`.
    /// The sensor's noise is part of it: it shakes the drive, and with it whatever friction the
    /// spool has.
    #[inline(always)]
    pub fn drive(
        &mut self,
        pace: &Pace<'_>,
        inputs: &ChannelInputs,
        (row, tick): (usize, usize),
        reading: S,
        deviations: Option<&Deviations<S>>,
    ) -> S {
        let board = pace.board;
        let command = command(inputs, row, tick, deviations)
            .max(S::constant(board.lowest_pa))
            .min(S::constant(board.highest_pa));
        let noise_pa = pace.noise_pa * dither(self.quantiles, board.noise_draw, row, tick);
        let sample = reading.plus(noise_pa).max(S::constant(board.lowest_pa));
        let previous = self.filtered;
        self.filtered = board.law.filtered(sample, previous);
        cut_off(board.law.drive(command, self.filtered, previous))
    }
}

/// The mean drive at the coil for a drive that the board calculates: full drive at most, and below
/// it what cutting off leaves.
#[inline(always)]
fn cut_off<S: Scalar>(drive: S) -> S {
    let (one, lost) = (S::constant(1.0), S::constant(CUT_OFF));
    let below = drive - drive.min(lost).max(-lost);
    S::select(drive.real().abs().less(S::Real::constant(1.0)), below, drive.min(one).max(-one))
}

/// The command that the board follows at loop `tick` of a row's interval, Pa gauge. The row's
/// pressure is what the first of them sampled; that one ran before the exchange and still has the
/// command of the row before.
#[inline(always)]
fn command<S: Scalar>(
    inputs: &ChannelInputs,
    row: usize,
    tick: usize,
    deviations: Option<&Deviations<S>>,
) -> S {
    let late = tick == 0 && inputs.starts.binary_search(&row).is_err();
    let command = S::constant(inputs.command_pa[if late { row - 1 } else { row }] - inputs.ambient_pa);
    match deviations {
        Some(deviations) => command + if late { deviations.command_before } else { deviations.command },
        None => command,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Law;
    use crate::effects::catalogue::{AnyEffect, index_of};
    use crate::effects::simulate::{Row, Undisturbed, simulate};
    use crate::effects::{DriveInput, Plant, Series};
    use crate::model::{ATMOSPHERE_PA, BaseModel, Nonlinear};

    /// A valve of one square millimetre at full drive on 0.1 l behind a board with 1000 loops a
    /// second, so many of them in a step of the simulation; the command jumps at row 5. Readings
    /// (Pa gauge) and mean drives.
    fn after_a_jump(filter: f64, loops_per_step: usize) -> Vec<(f64, f64)> {
        after_a_jump_with(filter, loops_per_step, &mut [], |_| {})
    }

    /// The same with effects and something else measured.
    fn after_a_jump_with(
        filter: f64,
        loops_per_step: usize,
        effects: &mut [AnyEffect<f64>],
        change: impl Fn(&mut ChannelInputs),
    ) -> Vec<(f64, f64)> {
        const ROWS: usize = 60;
        let ambient_pa = ATMOSPHERE_PA;
        let plant = Plant {
            model: BaseModel::Nonlinear(Nonlinear::default()),
            board: Some(BoardLoop {
                rate_hz: 1000.0,
                law: Law { gain: 1e-3, damping: 0.0, weight: filter },
                lowest_pa: 0.0,
                rounding_pa: 0.0,
                noise_draw: 0,
                loops_per_step,
                highest_pa: 7e5,
            }),
            longest_step_s: 0.005,
            command_range_pa: 3e5,
        };
        let command = |row: usize| if row < 5 { 1e5 } else { 3e5 } + ambient_pa;
        let every = |value: f64| -> Series { vec![value; ROWS].into() };
        let mut inputs = ChannelInputs {
            time_s: (0..ROWS).map(|k| 0.01 * k as f64).collect(),
            interval_s: every(0.01),
            duration_s: 0.01 * (ROWS - 1) as f64,
            starts: [0].into(),
            anchors: [].into(),
            drive: DriveInput::Controlled,
            command_pa: (0..ROWS).map(command).collect(),
            supply_pa: every(650e3),
            volume_m3: every(1e-4),
            volume_rate_m3_s: every(0.0),
            measured_pa: every(command(0)),
            usable: vec![true; ROWS].into(),
            opposite_pa: Series::default(),
            sampled_before_pa: Series::default(),
            neighbour_drive: Series::default(),
            others_draw: every(0.0),
            noise_pa: 0.0,
            ambient_pa,
        };
        change(&mut inputs);
        // Tight: nothing flows at rest.
        let base = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let mut rows = Vec::new();
        simulate(&plant, &base, effects, &inputs, &Undisturbed, |row: Row<f64>| {
            rows.push((row.reading, row.drive))
        });
        rows
    }

    #[test]
    fn the_loop_that_a_row_reports_has_the_command_of_the_row_before() {
        let rows = after_a_jump(0.0, 1);
        assert_eq!(rows[4].1, 0.0);
        // Nine of the ten loops after row 5 know its command and drive fully.
        assert!((rows[5].1 - 0.9).abs() < 1e-12, "{rows:?}");
        assert!((rows[6].1 - 1.0).abs() < 1e-12, "{rows:?}");
    }

    /// Only the gas sees the mean of a step.
    #[test]
    fn several_loops_in_a_step_drive_as_they_do_one_by_one() {
        for filter in [0.0, 0.5] {
            let (one, five) = (after_a_jump(filter, 1), after_a_jump(filter, 5));
            // As long as it is on its way.
            for ((_, drive), (_, coarse)) in one.iter().zip(&five).take(15) {
                assert!((drive - coarse).abs() < 1e-12, "{drive} and {coarse}");
            }
        }
    }

    fn effect(id: &str, value: f64) -> AnyEffect<f64> {
        AnyEffect::install(index_of(id).unwrap(), &[value]).unwrap()
    }

    #[test]
    fn the_loop_follows_what_crosstalk_leaves_of_the_reading() {
        // A tenth of what the channel before has, which is at 1.5 bar: the reading arrives at the
        // command all the same.
        let with = |share| {
            after_a_jump_with(0.0, 1, &mut [effect("sensor_crosstalk", share)], |inputs| {
                inputs.sampled_before_pa = vec![1.5e5; inputs.rows()].into();
            })
        };
        let (without, with) = (with(0.0), with(0.1));
        let last = with.len() - 1;
        assert!((without[last].0 - 3e5).abs() < 1e3 && (with[last].0 - 3e5).abs() < 1e3, "{:?}", with[last]);
        // The chamber goes further for that, and the valve is open longer.
        let opened = |rows: &[(f64, f64)]| rows[5..].iter().map(|row| row.1).sum::<f64>();
        assert!(opened(&with) > 1.05 * opened(&without), "{} {}", opened(&with), opened(&without));
    }

    #[test]
    fn the_loop_follows_an_old_sample() {
        // Rows 14 to 18 repeat each other: held from the middle of the interval before to the
        // middle of the one after.
        let held = |share| {
            after_a_jump_with(0.0, 1, &mut [effect("stale_samples", share)], |inputs| {
                let held = |row: usize| if (14..=18).contains(&row) { 14.0 } else { row as f64 };
                inputs.measured_pa =
                    inputs.measured_pa.iter().enumerate().map(|(k, p)| p + held(k)).collect();
            })
        };
        let (fresh, old) = (held(0.0), held(1.0));
        assert_eq!(fresh[..14], old[..14]);
        let reading = old[14].0;
        assert!(
            reading < fresh[14].0 && old[15..=18].iter().all(|row| row.0 == reading),
            "{:?}",
            &old[13..20]
        );
        // It goes on driving fully, and too far.
        assert!(
            old[17].1 > 0.999 && old[19].0 > 3.1e5 && fresh[19].0 < 3.01e5,
            "{:?} {:?}",
            old[19],
            fresh[19]
        );
    }

    #[test]
    fn a_reading_goes_on_as_its_chamber_does() {
        let mut controller = Controller::<f64>::new();
        controller.start(100.0, 1000.0);
        // As fast as both, as the slower of the two, not at all where they differ.
        let readings = [(102.0, 1002.0), (103.0, 1004.0), (113.0, 1006.0), (103.0, 1008.0), (103.0, 1010.0)];
        let gone = readings.map(|(reading, pressure)| controller.begin(reading, pressure));
        assert_eq!(gone, [2.0, 1.0, 2.0, 0.0, 0.0]);
        assert_eq!([controller.begin(101.0, 1009.0), controller.begin(100.5, 1005.0)], [-1.0, -0.5]);
    }

    #[test]
    fn the_mean_drive_is_that_of_the_boards_integers() {
        // Eighty drive counts in a row have every part of a step of pulse width that can be cut
        // off.
        for first in [8, 100, 319] {
            let counts = first..first + 80;
            let coil = counts.clone().map(|count| f64::from(51 * count / 80) / 255.0).sum::<f64>() / 80.0;
            let asked = counts.map(|count| f64::from(count) / 400.0).sum::<f64>() / 80.0;
            assert!((cut_off(asked) - coil).abs() < 1e-12 && (cut_off(-asked) + coil).abs() < 1e-12);
        }
        assert_eq!([cut_off(1.2), cut_off(-1.0), cut_off(0.001)], [1.0, -1.0, 0.0]);
    }

    #[test]
    fn a_filtered_report_contains_the_sample_of_the_row() {
        // A ramp, filtered with weight one half, is reported one loop late.
        let (plain, filtered) = (after_a_jump(0.0, 1), after_a_jump(0.5, 1));
        let loop_pa = (plain[9].0 - plain[8].0) / 10.0;
        let late = (plain[9].0 - filtered[9].0) / loop_pa;
        assert!((late - 1.0).abs() < 0.05, "{late} loops late");
    }
}
