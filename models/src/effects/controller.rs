//! The board's pressure controller in front of a channel that is simulated with effects.

use super::inputs::ChannelInputs;
use super::plant::BoardLoop;
use crate::numeric::Scalar;

/// What the board's pulse width leaves out in the mean: 400 drive counts become 255 steps of pulse width by 51/80, cut off towards
/// zero, as in the original; the parts that are cut off are equally likely multiples of 1/80 step.
const CUT_OFF: f64 = 79.0 / 160.0 / 255.0;

/// What the controller remembers between its loops.
#[derive(Debug, Clone, Copy)]
pub struct Controller<S> {
    /// What the sensor delivered a step before, gauge, Pa.
    before: S,
    /// The filtered sample, gauge, Pa.
    filtered: S,
}

/// A step of the controller: one of its loops, or several that are simulated as one at the pressure they see on average.
#[derive(Debug, Clone, Copy)]
pub struct Pace<'a> {
    board: &'a BoardLoop,
    /// Loops in a step.
    loops: f64,
    /// Weight of what was filtered before the step.
    weight: f64,
    /// The step's loops sample on average this part of it after its start.
    ahead: f64,
    /// Standard deviation of the sensor's noise as the loop sees it, Pa.
    noise_pa: f64,
}

/// Codes of the board's converter in one of those that it reports.
const FINER: f64 = 4.0;

impl<'a> Pace<'a> {
    /// For steps of this length, where what is reported has this noise, Pa.
    #[inline(always)]
    pub fn new(board: &'a BoardLoop, length_s: f64, noise_pa: f64) -> Self {
        let loops = (length_s * board.rate_hz).max(1.0);
        let weight = if loops > 1.0 { board.filter.powf(loops) } else { board.filter };
        let rounded = board.rounding_pa * board.rounding_pa;
        let own = rounded / (FINER * FINER);
        let noise_pa = (noise_pa * noise_pa - rounded + own).max(own).sqrt();
        Self { board, loops, weight, ahead: 0.5 * (loops - 1.0) / loops, noise_pa }
    }
}

impl<S: Scalar<Real = f64>> Controller<S> {
    /// Not started yet.
    pub fn new() -> Self {
        Self { before: S::zero(), filtered: S::zero() }
    }

    /// Begins at rest where the sensor delivers `reading`, gauge, Pa.
    pub fn start(&mut self, reading: S) {
        (self.before, self.filtered) = (reading, reading);
    }

    /// Follows a jump of the pressure, Pa.
    pub fn shift(&mut self, change: S) {
        self.before = self.before + change;
    }

    /// What the board reports: the filtered pressure where it filters. The loop that samples this reading runs at the first step
    /// after the row.
    #[inline(always)]
    pub fn report(&self, board: &BoardLoop, reading: S) -> S {
        if board.filter > 0.0 {
            self.filtered.times(board.filter) + reading.times(1.0 - board.filter)
        } else {
            reading
        }
    }

    /// The drive of step `tick` of a row's interval, -1 to 1, where the sensor delivers `reading`. The sensor's noise, rounding
    /// included, is part of it: it shakes the drive, and with it whatever friction the spool has.
    #[inline(always)]
    pub fn drive(
        &mut self,
        pace: &Pace<'_>,
        inputs: &ChannelInputs,
        (row, tick): (usize, usize),
        reading: S,
    ) -> S {
        let board = pace.board;
        let command = command(inputs, row, tick, pace.loops).clamp(board.lowest_pa, board.highest_pa);
        let noise = pace.noise_pa * dither(row, tick);
        let sample = reading + (reading - self.before).times(pace.ahead);
        self.before = reading;
        let sample = sample.plus(noise).max(S::constant(board.lowest_pa));
        let previous = self.filtered;
        self.filtered = previous.times(pace.weight) + sample.times(1.0 - pace.weight);
        let error = -self.filtered.plus(-command);
        let change = (self.filtered - previous).times(1.0 / pace.loops);
        let drive = error.times(board.gain_per_pa) - change.times(board.damping_per_pa);
        cut_off(drive)
    }
}

/// The mean drive at the coil for a drive that the board calculates: full drive at most, and below it what cutting off leaves.
#[inline(always)]
fn cut_off<S: Scalar<Real = f64>>(drive: S) -> S {
    let (one, lost) = (S::constant(1.0), S::constant(CUT_OFF));
    let below = drive - drive.min(lost).max(-lost);
    S::select(drive.real().abs() < 1.0, below, drive.min(one).max(-one))
}

/// The command that the board follows at step `tick` of a row's interval, of `loops` of its loops, Pa gauge. The row's pressure is
/// what the first of them sampled; that one ran before the exchange and still has the command of the row before.
#[inline(always)]
fn command(inputs: &ChannelInputs, row: usize, tick: usize, loops: f64) -> f64 {
    let now = inputs.command_pa[row];
    let known = if tick == 0 && inputs.starts.binary_search(&row).is_err() {
        now + (inputs.command_pa[row - 1] - now) / loops
    } else {
        now
    };
    known - inputs.ambient_pa
}

/// A reproducible stand-in for the sensor's noise at a loop of the board: nearly normal with unit variance (sum of four
/// uniform numbers from the SplitMix64 hash).
#[inline(always)]
fn dither(row: usize, tick: usize) -> f64 {
    let mut z =
        (row as u64).wrapping_mul(1 << 20).wrapping_add(tick as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    let sum: u64 = (0..4).map(|k| (z >> (16 * k)) & 0xffff).sum();
    // Mean 2, variance 4/12 in units of 65536.
    (sum as f64 / 65_536.0 - 2.0) * 3.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::simulate::{Row, Undisturbed, simulate};
    use crate::effects::{DriveInput, Kind, Plant};
    use crate::model::{FlowForm, FlowFunction, Gas, ValveDrive};

    /// A valve of one square millimetre at full drive on 0.1 l behind a board with 1000 loops a second; the command jumps at row 5.
    fn after_a_jump(filter: f64) -> Vec<(f64, f64)> {
        const ROWS: usize = 10;
        let ambient_pa = 101_325.0;
        let plant = Plant {
            kind: Kind::Nonlinear(ValveDrive::Spool),
            gas: Gas { ambient_pa, ..Gas::default() },
            flow: FlowFunction::new(0.3, FlowForm::Iso6358),
            critical_ratio: 0.3,
            discharge_coefficient: 1.0,
            board: Some(BoardLoop {
                rate_hz: 1000.0,
                gain_per_pa: 1e-3,
                damping_per_pa: 0.0,
                filter,
                lowest_pa: 0.0,
                rounding_pa: 0.0,
                loops_per_step: 1,
                highest_pa: 7e5,
            }),
            longest_step_s: 0.005,
            command_range_pa: 3e5,
        };
        let command = |row: usize| if row < 5 { 1e5 } else { 3e5 } + ambient_pa;
        let inputs = ChannelInputs {
            time_s: (0..ROWS).map(|k| 0.01 * k as f64).collect(),
            interval_s: vec![0.01; ROWS],
            duration_s: 0.09,
            starts: vec![0],
            drive: DriveInput::Controlled,
            command_pa: (0..ROWS).map(command).collect(),
            supply_pa: vec![650e3; ROWS],
            volume_m3: vec![1e-4; ROWS],
            volume_rate_m3_s: vec![0.0; ROWS],
            measured_pa: vec![command(0); ROWS],
            usable: vec![true; ROWS],
            opposite_pa: vec![],
            sampled_before_pa: vec![],
            others_draw: vec![0.0; ROWS],
            noise_pa: 0.0,
            ambient_pa,
        };
        // Tight: nothing flows at rest.
        let base = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let mut rows = Vec::new();
        simulate(&plant, &base, &mut [], &inputs, &Undisturbed, |row: Row<f64>| {
            rows.push((row.reading, row.drive))
        });
        rows
    }

    #[test]
    fn the_loop_that_a_row_reports_has_the_command_of_the_row_before() {
        let rows = after_a_jump(0.0);
        assert_eq!(rows[4].1, 0.0);
        // Nine of the ten loops after row 5 know its command and drive fully.
        assert!((rows[5].1 - 0.9).abs() < 1e-12, "{rows:?}");
        assert!((rows[6].1 - 1.0).abs() < 1e-12, "{rows:?}");
    }

    #[test]
    fn the_mean_drive_is_that_of_the_boards_integers() {
        // Eighty drive counts in a row have every part of a step of pulse width that can be cut off.
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
        let (plain, filtered) = (after_a_jump(0.0), after_a_jump(0.5));
        let loop_pa = (plain[9].0 - plain[8].0) / 10.0;
        let late = (plain[9].0 - filtered[9].0) / loop_pa;
        assert!((late - 1.0).abs() < 0.05, "{late} loops late");
    }
}
