//! One channel simulated with effects: the loop over rows and steps.

use super::catalogue::AnyEffect;
use super::chamber::{Chamber, Conditions};
use super::controller::{Controller, Pace};
use super::deviations::Deviations;
use super::hook::{Hook, Memory, RegulatorLaw, Step, Stretch, Structure};
use super::inputs::{ChannelInputs, DriveInput};
use super::plant::Plant;
use super::state::StepperState;
use multiversion::multiversion;

use crate::model::{BaseCoefficients, LinearCoefficients, NonlinearCoefficients};
use crate::numeric::Scalar;

/// What a simulation says about one row.
#[derive(Debug, Clone, Copy)]
pub struct Row<S: Scalar> {
    /// Row number.
    pub row: usize,
    /// What the sensor is expected to report at the row's time, gauge, Pa.
    pub reading: S,
    /// Drive over the interval that starts here (mean), -1 to 1 (fill minus vent where there are two valves).
    pub drive: S::Real,
    /// Mass flow drawn from the supply over that interval (mean), mm^2 Pa.
    pub draw: S::Real,
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
pub fn simulate<S: Scalar>(
    plant: &Plant,
    base: &[S],
    effects: &mut [AnyEffect<S>],
    inputs: &ChannelInputs,
    disturbance: &impl Disturbance<S>,
    mut each: impl FnMut(Row<S>),
) {
    let mut run = Stepper::new(plant, base, effects, inputs);
    let mut next_start = 0;
    for row in 0..inputs.rows() {
        if inputs.starts.get(next_start) == Some(&row) {
            next_start += 1;
            run.start(row);
        }
        run.set_pressure(disturbance.pressure(row, run.pressure()));
        run.set_supply(disturbance.supply(row, S::constant(inputs.supply_pa[row])));
        let reading = run.reading(row);
        let (drive, draw) = run.interval(row);
        each(Row { row, reading, drive, draw });
    }
}

/// One interval. One copy for each kind of number, whoever simulates: it takes long to compile. Vectors of plain numbers or of derivatives
/// have another for processors with wider registers.
#[inline(never)]
fn interval<S: Scalar>(run: &mut Run<'_, S>, row: usize, effects: &mut [AnyEffect<S>]) -> (S::Real, S::Real) {
    if S::WIDE { wide_interval(run, row, effects) } else { run.interval(row, effects) }
}

#[multiversion(targets("x86_64+avx2"))]
fn wide_interval<S: Scalar>(
    run: &mut Run<'_, S>,
    row: usize,
    effects: &mut [AnyEffect<S>],
) -> (S::Real, S::Real) {
    run.interval(row, effects)
}

/// A channel simulated row by row, for callers that look at its state or change it in between.
pub struct Stepper<'a, S: Scalar> {
    run: Run<'a, S>,
    effects: &'a mut [AnyEffect<S>],
}

impl<'a, S: Scalar> Stepper<'a, S> {
    /// A channel with effects, before its first row; arguments as of [`simulate`].
    pub fn new(
        plant: &'a Plant,
        base: &[S],
        effects: &'a mut [AnyEffect<S>],
        inputs: &'a ChannelInputs,
    ) -> Self {
        let mut structure =
            Structure { flow_function: None, heat_time_constant_s: None, outlet: None, line: None };
        for effect in effects.iter() {
            effect.structure(&mut structure);
        }
        let run = Run {
            plant,
            inputs,
            chamber: Chamber::new(&plant.model, structure),
            reading: S::zero(),
            controller: Controller::new(),
            base: plant.model.coefficients(base),
            supply: S::zero(),
            deviations: None,
            spool: [S::zero(); 2],
        };
        Self { run, effects }
    }

    /// What it remembers beside its effects, for [`resume`](Self::resume).
    pub fn state(&self) -> StepperState<S> {
        let Run { chamber, reading, controller, spool, .. } = &self.run;
        StepperState { chamber: *chamber, reading: *reading, controller: *controller, spool: *spool }
    }

    /// Goes on where another stepper of the same channel and the same effects stood: its inputs may be others.
    pub fn resume(&mut self, state: StepperState<S>) {
        let StepperState { chamber, reading, controller, spool } = state;
        (self.run.chamber, self.run.reading, self.run.controller) = (chamber, reading, controller);
        self.run.spool = spool;
    }

    /// Begins at rest at the pressure measured in a row.
    pub fn start(&mut self, row: usize) {
        for effect in self.effects.iter_mut() {
            effect.reset();
        }
        self.run.start(row);
    }

    /// Is there a tube between valve and chamber?
    pub fn has_tube(&self) -> bool {
        self.run.chamber.has_tube()
    }

    /// Pressure in the chamber, absolute, Pa.
    pub fn pressure(&self) -> S {
        self.run.chamber.pressure()
    }

    /// Sets the pressure in the chamber, absolute, Pa; what the sensor delivers moves with it.
    pub fn set_pressure(&mut self, pressure: S) {
        self.run.disturb(pressure);
    }

    /// Sets the supply pressure of the interval to come, before effects, absolute, Pa.
    pub fn set_supply(&mut self, supply: S) {
        self.run.supply = supply;
    }

    /// Makes variables of the inputs of the intervals to come.
    pub fn set_deviations(&mut self, deviations: Deviations<S>) {
        self.run.deviations = Some(deviations);
    }

    /// What is recorded in a row, gauge, Pa. Once a row, before its interval.
    pub fn reading(&mut self, row: usize) -> S {
        let mut reading = self.run.report();
        for effect in self.effects.iter_mut() {
            reading = effect.sample(self.run.inputs, row, reading);
        }
        reading
    }

    /// Advances over the interval that starts at a row. Returns the mean drive, -1 to 1, and the mean flow drawn from the supply, mm^2 Pa.
    pub fn interval(&mut self, row: usize) -> (S::Real, S::Real) {
        interval(&mut self.run, row, self.effects)
    }

    /// Shows everything that is remembered from row to row, in an order that stays: first the pressure in the chamber (absolute, Pa)
    /// and, if there is a tube, at its other end.
    pub fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.run.chamber.memory(visit);
        if self.run.in_loop() {
            visit(Memory::Estimated, &mut self.run.reading);
            self.run.controller.memory(visit);
        }
        for effect in self.effects.iter_mut() {
            effect.memory(visit);
        }
    }
}

struct Run<'a, S: Scalar> {
    plant: &'a Plant,
    inputs: &'a ChannelInputs,
    chamber: Chamber<S>,
    /// What the sensor delivers now, gauge, Pa.
    reading: S,
    /// The board's controller, where it is part of the simulation.
    controller: Controller<S>,
    /// The base model before effects.
    base: BaseCoefficients<S>,
    /// Supply pressure over this interval before effects, Pa.
    supply: S,
    /// What else is a variable.
    deviations: Option<Deviations<S>>,
    /// Where the effects have left the fill and the vent port's drive in the last step.
    spool: [S; 2],
}

impl<S: Scalar> Run<'_, S> {
    fn start(&mut self, row: usize) {
        let measured = self.inputs.measured_pa[row];
        self.chamber.start(S::constant(measured));
        self.reading = S::constant(measured - self.inputs.ambient_pa);
        self.controller.start(self.reading, self.chamber.port());
    }

    /// Moves the pressure, and what the sensor delivers with it.
    fn disturb(&mut self, pressure: S) {
        let change = pressure - self.chamber.pressure();
        self.chamber.shift(change);
        self.reading = self.reading + change;
        self.controller.shift(change);
    }

    /// Is the board's loop part of the simulation?
    fn in_loop(&self) -> bool {
        self.inputs.in_loop() && self.plant.board.is_some()
    }

    /// What is reported: by a board, what its loop makes of the reading.
    fn report(&self) -> S {
        match (&self.inputs.drive, &self.plant.board) {
            (DriveInput::Controlled, Some(board)) => self.controller.report(board, self.reading),
            _ => self.reading,
        }
    }

    #[inline(always)]
    fn interval(&mut self, row: usize, effects: &mut [AnyEffect<S>]) -> (S::Real, S::Real) {
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
            let step =
                |part: f64, length_s: f64| Step { row, time_s: time_s + part * length_s, length_s, inputs };
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

    /// The drives of the fill and the vent port where no board is simulated: those recorded, or the command as one.
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

    /// Several loops of the board in front of one step of the gas: what moves the spool is simulated loop by loop (friction answers to
    /// every shake), the gas with its mean position. Returns the mean drive, and that position as seen by the two ports.
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
                drive = effect.drive(&step(k as f64 + 0.5, length_s * share), 0, drive);
            }
            spool = spool + drive;
            reading = reading + change;
        }
        let spool = spool.times(share);
        (held.times(share), [spool, -spool])
    }

    /// What effects make of the drives of the fill and the vent port. Returns the drive before them and what reaches the ports.
    #[inline(always)]
    fn spool(&self, step: &Step<'_>, held: [S; 2], effects: &mut [AnyEffect<S>]) -> (S::Real, [S; 2]) {
        let separate = matches!(self.inputs.drive, DriveInput::Separate { .. });
        let mut ports = held;
        let valves = if separate { 2 } else { 1 };
        for effect in effects.iter_mut() {
            for (valve, port) in ports.iter_mut().enumerate().take(valves) {
                *port = effect.drive(step, valve, *port);
            }
        }
        let [fill, vent] = held.map(Scalar::real);
        if separate { (fill - vent, ports) } else { (fill, [ports[0], -ports[0]]) }
    }

    /// One step with these positions of the spools at the fill and the vent port. Returns the flow drawn.
    #[inline(always)]
    fn flow(&mut self, step: &Step<'_>, [fill, vent]: [S; 2], effects: &mut [AnyEffect<S>]) -> S::Real {
        self.spool = [fill, vent];
        let draw = match self.base {
            BaseCoefficients::Nonlinear(base) => self.nonlinear_step(step, &base, [fill, vent], effects),
            BaseCoefficients::Linear(base) => {
                self.linear_step(step, &base, fill, effects);
                S::Real::zero()
            }
        };
        let mut reading = self.chamber.port().plus(-self.inputs.ambient_pa);
        for effect in effects.iter_mut() {
            reading = effect.sense(step, reading);
        }
        self.reading = reading;
        draw
    }

    #[inline(always)]
    fn nonlinear_step(
        &mut self,
        step: &Step<'_>,
        base: &NonlinearCoefficients<S>,
        [fill, vent]: [S; 2],
        effects: &mut [AnyEffect<S>],
    ) -> S::Real {
        let inputs = self.inputs;
        let mut law = base.valve;
        for effect in effects.iter_mut() {
            effect.valve(step, &mut law);
        }
        let mut areas = law.areas(fill, vent);
        let pressure = self.chamber.pressure();
        let mut stretch = Stretch { factor: S::constant(1.0), rate: S::zero(), by_pressure: S::zero() };
        let mut supply = self.supply;
        for effect in effects.iter_mut() {
            effect.areas(step, &mut areas);
            supply = effect.supply(step, supply, &areas, pressure);
            effect.stretch(step, pressure, &mut stretch);
        }
        let volume = inputs.volume_m3[step.row];
        let mut open = law.open();
        let mut expansion = base.volume_weight.times(inputs.volume_rate_m3_s[step.row] / volume);
        if let Some(by) = &self.deviations {
            // All rates are areas and rates of the volume over the volume.
            let share = by.volume.times(1.0 / volume).plus(1.0).recip();
            expansion = (expansion + base.volume_weight * by.volume_rate.times(1.0 / volume)) * share;
            for area in [&mut areas.fill, &mut areas.vent, &mut open.fill, &mut open.vent] {
                *area = *area * share;
            }
        }
        let conditions = Conditions { areas, supply, volume_m3: volume, open, expansion, stretch };
        self.chamber.advance(step.length_s, &conditions)
    }

    fn linear_step(
        &mut self,
        step: &Step<'_>,
        &LinearCoefficients { alpha, beta }: &LinearCoefficients<S>,
        drive: S,
        effects: &mut [AnyEffect<S>],
    ) {
        let one = S::constant(1.0);
        let mut law = RegulatorLaw { rising: one, falling: one, offset_pa: S::zero(), slew_pa_s: None };
        for effect in effects.iter_mut() {
            effect.regulator(step, &mut law);
        }
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
