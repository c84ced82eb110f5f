//! The interval between two rows: the board's loops in it, and the steps of the gas.

use super::catalogue::AnyEffect;
use super::controller::Pace;
use super::hook::Step;
use super::inputs::DriveInput;
use super::run::Run;
use crate::numeric::Scalar;

impl<S: Scalar> Run<'_, S> {
    /// One interval: the mean drive, and the mean flow drawn from the supply.
    #[inline(always)]
    pub(super) fn interval(&mut self, row: usize, effects: &mut [AnyEffect<S>]) -> (S::Real, S::Real) {
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
        let pace = controlled.map(|board| Pace::new(board, interval / loops as f64, inputs.noise_pa));
        let steps = loops * parts;
        let length_s = interval / steps as f64;
        // Several loops of the board are simulated in front of one step of the gas.
        let several = pace.filter(|pace| pace.loops > 1);
        let gas_steps = if several.is_some() { 1 } else { parts };
        let gas_step_s = (parts / gas_steps) as f64 * length_s;
        let (mut mean_drive, mut mean_draw) = (S::Real::zero(), S::Real::zero());
        for tick in 0..loops {
            let time_s = inputs.time_s[row] + tick as f64 * parts as f64 * length_s;
            let lags = self.lags;
            let step = |part: f64, length_s: f64| Step {
                row,
                time_s: time_s + part * length_s,
                length_s,
                lags,
                inputs,
            };
            let mut held = [S::zero(); 2];
            if let (DriveInput::Controlled, None, Some(pace)) = (&inputs.drive, &several, &pace) {
                self.controller.begin(self.reading, self.chamber.port());
                let drive =
                    self.controller.drive(pace, inputs, (row, tick), self.reading, self.deviations.as_ref());
                held = [drive, -drive];
            } else if several.is_none() {
                held = self.recorded(row);
            }
            for part in 0..gas_steps {
                let step_of = step(part as f64 + 0.5, gas_step_s);
                let (drive, spool) = match &several {
                    Some(pace) => self.loops(pace, (row, tick), &step, gas_step_s, effects),
                    None => self.spool(&step_of, held, effects),
                };
                let draw = self.flow(&step_of, spool, effects);
                mean_drive = mean_drive + drive / S::Real::constant(gas_steps as f64);
                mean_draw = mean_draw + draw / S::Real::constant(gas_steps as f64);
            }
        }
        let loops = S::Real::constant(loops as f64);
        (mean_drive / loops, mean_draw / loops)
    }

    /// The drives of the fill and the vent port where no board is simulated: those recorded, or the
    /// command as one.
    #[inline(always)]
    fn recorded(&self, row: usize) -> [S; 2] {
        let inputs = self.inputs;
        let full = self.plant.command_range_pa;
        let held = match &inputs.drive {
            DriveInput::Spool(u) => [u[row], -u[row]],
            DriveInput::Separate { fill, vent } => [fill[row], vent[row]],
            DriveInput::Controlled | DriveInput::Command => {
                let u = (inputs.command_pa[row] - inputs.ambient_pa) / full;
                [u, -u]
            }
        };
        let held = held.map(S::constant);
        match (&self.deviations, &inputs.drive) {
            (None, _) => held,
            (Some(by), DriveInput::Separate { .. }) => [held[0] + by.drive[0], held[1] + by.drive[1]],
            (Some(by), DriveInput::Spool(_)) => [held[0] + by.drive[0], held[1] - by.drive[0]],
            (Some(by), DriveInput::Controlled | DriveInput::Command) => {
                let change = by.command.times(1.0 / full);
                [held[0] + change, held[1] - change]
            }
        }
    }

    /// Several loops of the board in front of one step of the gas: what moves the spool is
    /// simulated loop by loop (friction answers to every shake), the gas with its mean position.
    /// Returns the mean drive, and that position as seen by the two ports.
    #[inline(always)]
    fn loops<'b>(
        &mut self,
        pace: &Pace<'_>,
        (row, tick): (usize, usize),
        step: &impl Fn(f64, f64) -> Step<'b>,
        length_s: f64,
        effects: &mut [AnyEffect<S>],
    ) -> (S::Real, [S; 2]) {
        let share = 1.0 / pace.loops as f64;
        let change = self.controller.begin(self.reading, self.chamber.port()).times(share);
        let (mut held, mut spool, mut reading) = (S::Real::zero(), S::zero(), self.reading);
        for k in 0..pace.loops {
            let at = (row, tick * pace.loops + k);
            let mut drive = self.controller.drive(pace, self.inputs, at, reading, self.deviations.as_ref());
            held = held + drive.real();
            for effect in effects.iter_mut() {
                effect.drive(&step(k as f64 + 0.5, length_s * share), 0, &mut drive);
            }
            spool = spool + drive;
            reading = reading + change;
        }
        let spool = spool.times(share);
        (held.times(share), [spool, -spool])
    }

    /// What effects make of the drives of the fill and the vent port. Returns the drive before them
    /// and what reaches the ports.
    #[inline(always)]
    fn spool(&self, step: &Step<'_>, held: [S; 2], effects: &mut [AnyEffect<S>]) -> (S::Real, [S; 2]) {
        let separate = matches!(self.inputs.drive, DriveInput::Separate { .. });
        let mut ports = held;
        let valves = if separate { 2 } else { 1 };
        for effect in effects.iter_mut() {
            for (valve, port) in ports.iter_mut().enumerate().take(valves) {
                effect.drive(step, valve, port);
            }
        }
        let [fill, vent] = held.map(Scalar::real);
        if separate { (fill - vent, ports) } else { (fill, [ports[0], -ports[0]]) }
    }
}
