//! One channel simulated with effects: the loop over rows and steps.

use super::catalogue::AnyEffect;
use super::chamber::{Chamber, Conditions};
use super::hook::{Areas, Hook, RegulatorLaw, Step, Stretch, Structure, ValveLaw};
use super::inputs::{ChannelInputs, DriveInput};
use super::plant::{BoardLoop, Kind, Plant};
use multiversion::multiversion;

use crate::model::smooth_corner;
use crate::numeric::Scalar;

/// What a simulation says about one row.
#[derive(Debug, Clone, Copy)]
pub struct Row<S> {
    /// Row number.
    pub row: usize,
    /// What the sensor is expected to report at the row's time, gauge, Pa.
    pub reading: S,
    /// Drive over the interval that starts here (mean), -1 to 1 (fill minus vent where there are two valves).
    pub drive: f64,
    /// Mass flow drawn from the supply over that interval (mean), mm^2 Pa.
    pub draw: f64,
}

/// Lets a caller add to a simulation what no effect describes: disturbances with known derivatives.
pub trait Disturbance<S> {
    /// The supply pressure over the interval that starts at `row`, Pa.
    fn supply(&self, _row: usize, supply: S) -> S {
        supply
    }

    /// The pressure in the chamber at the start of that interval, Pa.
    fn pressure(&self, _row: usize, pressure: S) -> S {
        pressure
    }
}

/// No disturbance.
#[derive(Debug, Clone, Copy)]
pub struct Undisturbed;

impl<S> Disturbance<S> for Undisturbed {}

/// Runs the channel through all rows and hands each row's outcome to `each`.
///
/// `base` are the base model's parameters in the order of [`Plant::parameters`].
pub fn simulate<S: Scalar<Real = f64>>(
    plant: &Plant,
    base: &[S],
    effects: &mut [AnyEffect<S>],
    inputs: &ChannelInputs,
    disturbance: &impl Disturbance<S>,
    mut each: impl FnMut(Row<S>),
) {
    roll(plant, base, effects, inputs, disturbance, &mut each);
}

/// One copy for each kind of number, whatever the disturbance: it takes long to compile.
#[multiversion(targets("x86_64+avx2"))]
fn roll<S: Scalar<Real = f64>>(
    plant: &Plant,
    base: &[S],
    effects: &mut [AnyEffect<S>],
    inputs: &ChannelInputs,
    disturbance: &dyn Disturbance<S>,
    each: &mut dyn FnMut(Row<S>),
) {
    let mut structure =
        Structure { flow_function: None, heat_time_constant_s: None, outlet: None, line: None };
    for effect in effects.iter() {
        effect.structure(&mut structure);
    }
    let mut run = Run {
        plant,
        base,
        inputs,
        chamber: Chamber::new(plant, structure),
        reading: S::zero(),
        before: S::zero(),
        filtered: S::zero(),
        supply: S::zero(),
    };
    let mut next_start = 0;
    for row in 0..inputs.rows() {
        if inputs.starts.get(next_start) == Some(&row) {
            next_start += 1;
            for effect in effects.iter_mut() {
                effect.reset();
            }
            run.start(row);
        }
        run.disturb(disturbance.pressure(row, run.chamber.pressure()));
        run.supply = disturbance.supply(row, S::constant(inputs.supply_pa[row]));
        let mut reading = run.report();
        for effect in effects.iter_mut() {
            reading = effect.sample(inputs, row, reading);
        }
        let (drive, draw) = run.interval(row, effects);
        each(Row { row, reading, drive, draw });
    }
}

struct Run<'a, S: Scalar> {
    plant: &'a Plant,
    base: &'a [S],
    inputs: &'a ChannelInputs,
    chamber: Chamber<S>,
    /// What the sensor delivers now, gauge, Pa.
    reading: S,
    /// What it delivered a step of the board before.
    before: S,
    /// The board's filtered sample, gauge, Pa.
    filtered: S,
    /// Supply pressure over this interval before effects, Pa.
    supply: S,
}

impl<S: Scalar<Real = f64>> Run<'_, S> {
    fn start(&mut self, row: usize) {
        let measured = self.inputs.measured_pa[row];
        self.chamber.start(S::constant(measured));
        self.reading = S::constant(measured - self.inputs.ambient_pa);
        self.before = self.reading;
        self.filtered = self.reading;
    }

    /// Moves the pressure, and what the sensor delivers with it.
    fn disturb(&mut self, pressure: S) {
        let change = pressure - self.chamber.pressure();
        self.chamber.shift(change);
        self.reading = self.reading + change;
        self.before = self.before + change;
    }

    /// What the board reports: the filtered pressure where it filters. The loop that samples this reading runs at the first step
    /// after the row.
    fn report(&self) -> S {
        match (&self.inputs.drive, &self.plant.board) {
            (DriveInput::Controlled, Some(board)) if board.filter > 0.0 => {
                self.filtered.times(board.filter) + self.reading.times(1.0 - board.filter)
            }
            _ => self.reading,
        }
    }

    /// The command that the board follows at step `k` of a row's interval, of `loops` of its loops, Pa gauge. The row's pressure is
    /// what the first of them sampled; that one ran before the exchange and still has the command of the row before.
    fn command(&self, row: usize, k: usize, loops: f64) -> f64 {
        let now = self.inputs.command_pa[row];
        let known = if k == 0 && self.inputs.starts.binary_search(&row).is_err() {
            now + (self.inputs.command_pa[row - 1] - now) / loops
        } else {
            now
        };
        known - self.inputs.ambient_pa
    }

    #[inline(always)]
    fn interval(&mut self, row: usize, effects: &mut [AnyEffect<S>]) -> (f64, f64) {
        let inputs = self.inputs;
        let interval = inputs.interval_s[row];
        let controlled = match &inputs.drive {
            DriveInput::Controlled => self.plant.board.as_ref(),
            _ => None,
        };
        // Steps of the board's loop, and of the integration within each.
        let (loops, parts) = match controlled {
            Some(board) => {
                let loops = board.steps(interval);
                (loops, self.plant.steps(interval / loops as f64))
            }
            None => (self.plant.steps(interval), 1),
        };
        let steps = loops * parts;
        let length_s = interval / steps as f64;
        let (mut mean_drive, mut mean_draw) = (0.0, 0.0);
        let mut held = S::zero();
        for k in 0..steps {
            let time_s = inputs.time_s[row] + (k as f64 + 0.5) * length_s;
            let step = Step { row, time_s, length_s, inputs };
            let (mut fill, mut vent) = match (&inputs.drive, controlled) {
                (DriveInput::Spool(u), _) => (S::constant(u[row]), S::constant(-u[row])),
                (DriveInput::Separate { fill, vent }, _) => (S::constant(fill[row]), S::constant(vent[row])),
                (DriveInput::Controlled, Some(board)) => {
                    if k % parts == 0 {
                        held = self.control(board, row, k / parts, interval / loops as f64);
                    }
                    (held, -held)
                }
                (DriveInput::Controlled | DriveInput::Command, _) => {
                    let u = (inputs.command_pa[row] - inputs.ambient_pa) / self.plant.command_range_pa;
                    (S::constant(u), S::constant(-u))
                }
            };
            let separate = matches!(inputs.drive, DriveInput::Separate { .. });
            mean_drive += if separate { fill.real() - vent.real() } else { fill.real() };
            for effect in effects.iter_mut() {
                fill = effect.drive(&step, 0, fill);
                if separate {
                    vent = effect.drive(&step, 1, vent);
                }
            }
            if !separate {
                vent = -fill;
            }
            let draw = match self.plant.kind {
                Kind::Nonlinear(_) => self.nonlinear_step(&step, fill, vent, effects),
                Kind::Linear => {
                    self.linear_step(&step, fill, effects);
                    0.0
                }
            };
            mean_draw += draw;
            let mut reading = self.chamber.port().plus(-inputs.ambient_pa);
            for effect in effects.iter_mut() {
                reading = effect.sense(&step, reading);
            }
            self.reading = reading;
        }
        (mean_drive / steps as f64, mean_draw / steps as f64)
    }

    /// A step of the board's controller, `length_s` long: one of its loops, or the mean of several. The sensor's noise, rounding
    /// included, is part of it: it shakes the drive, and with it whatever friction the spool has.
    #[inline(always)]
    fn control(&mut self, board: &BoardLoop, row: usize, k: usize, length_s: f64) -> S {
        let loops = (length_s * board.rate_hz).max(1.0);
        let command = self.command(row, k, loops).clamp(board.lowest_pa, board.highest_pa);
        let noise = self.inputs.noise_pa * dither(row, k);
        // The loops of a step sample on average this part of a step after its start.
        let ahead = 0.5 * (loops - 1.0) / loops;
        let sample = self.reading + (self.reading - self.before).times(ahead);
        self.before = self.reading;
        let sample = sample.plus(noise).max(S::constant(board.lowest_pa));
        let previous = self.filtered;
        let weight = if loops > 1.0 { board.filter.powf(loops) } else { board.filter };
        self.filtered = previous.times(weight) + sample.times(1.0 - weight);
        let error = -self.filtered.plus(-command);
        let change = (self.filtered - previous).times(1.0 / loops);
        let one = S::constant(1.0);
        (error.times(board.gain_per_pa) - change.times(board.damping_per_pa)).min(one).max(-one)
    }

    #[inline(always)]
    fn law(&self) -> ValveLaw<S> {
        let p = self.base;
        if self.plant.separate() {
            ValveLaw {
                leak_in: p[0],
                leak_out: p[1],
                gain_in: p[2],
                gain_out: p[3],
                threshold_in: p[4],
                threshold_out: p[5],
                corner: p[6],
            }
        } else {
            ValveLaw {
                leak_in: p[0],
                leak_out: p[1],
                gain_in: p[2],
                gain_out: p[2],
                threshold_in: p[3],
                threshold_out: -p[4],
                corner: p[5],
            }
        }
    }

    #[inline(always)]
    fn nonlinear_step(&mut self, step: &Step<'_>, fill: S, vent: S, effects: &mut [AnyEffect<S>]) -> f64 {
        let inputs = self.inputs;
        let mut law = self.law();
        for effect in effects.iter_mut() {
            effect.valve(step, &mut law);
        }
        let mut areas = Areas {
            fill: law.leak_in
                + smooth_corner(law.gain_in * (fill - law.threshold_in) - law.leak_in, law.corner),
            vent: law.leak_out
                + smooth_corner(law.gain_out * (vent - law.threshold_out) - law.leak_out, law.corner),
        };
        let pressure = self.chamber.pressure();
        let mut stretch = Stretch { factor: S::constant(1.0), rate: S::zero(), by_pressure: S::zero() };
        let mut supply = self.supply;
        for effect in effects.iter_mut() {
            effect.areas(step, &mut areas);
            supply = effect.supply(step, supply, &areas, pressure);
            effect.stretch(step, pressure, &mut stretch);
        }
        let volume = inputs.volume_m3[step.row];
        let weight = self.base[self.plant.volume_weight()];
        let conditions = Conditions {
            areas,
            supply,
            volume_m3: volume,
            open: Areas { fill: law.gain_in, vent: law.gain_out },
            expansion: weight.times(inputs.volume_rate_m3_s[step.row] / volume),
            stretch,
        };
        self.chamber.advance(step.length_s, &conditions)
    }

    fn linear_step(&mut self, step: &Step<'_>, drive: S, effects: &mut [AnyEffect<S>]) {
        let one = S::constant(1.0);
        let mut law = RegulatorLaw { rising: one, falling: one, offset_pa: S::zero(), slew_pa_s: None };
        for effect in effects.iter_mut() {
            effect.regulator(step, &mut law);
        }
        let (alpha, beta) = (self.base[0], self.base[1]);
        let gauge = self.chamber.pressure().plus(-self.inputs.ambient_pa);
        let driven = beta * (drive.times(self.plant.command_range_pa) + law.offset_pa);
        let speed = S::select(driven.less(gauge * alpha), law.falling, law.rising);
        let decay = (-(alpha * speed).times(step.length_s)).exp();
        let target = driven / alpha;
        let mut next = target + (gauge - target) * decay;
        if let Some(slew) = law.slew_pa_s {
            let most = slew.times(step.length_s);
            next = gauge + (next - gauge).min(most).max(-most);
        }
        self.chamber.set(next.plus(self.inputs.ambient_pa));
    }
}

/// A reproducible stand-in for the sensor's noise at a loop of the board: nearly normal with unit variance (sum of four
/// uniform numbers from the SplitMix64 hash).
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
    use crate::effects::Undisturbed as None;
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
        simulate(&plant, &base, &mut [], &inputs, &None, |row: Row<f64>| rows.push((row.reading, row.drive)));
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
    fn a_filtered_report_contains_the_sample_of_the_row() {
        // A ramp, filtered with weight one half, is reported one loop late.
        let (plain, filtered) = (after_a_jump(0.0), after_a_jump(0.5));
        let loop_pa = (plain[9].0 - plain[8].0) / 10.0;
        let late = (plain[9].0 - filtered[9].0) / loop_pa;
        assert!((late - 1.0).abs() < 0.05, "{late} loops late");
    }
}
