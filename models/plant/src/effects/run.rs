//! What a simulated channel remembers, and one step of it.

use super::catalogue::AnyEffect;
use super::chamber::{Chamber, Conditions};
use super::controller::Controller;
use super::deviations::Deviations;
use super::hook::{Facing, Memory, RegulatorLaw, Step, Stretch, Structure};
use super::inputs::{ChannelInputs, DriveInput};
use super::plant::Plant;
use crate::model::{BaseCoefficients, LinearCoefficients, NonlinearCoefficients};
use crate::numeric::Scalar;

/// A channel between two intervals.
pub struct Run<'a, S: Scalar> {
    pub(super) plant: &'a Plant,
    pub(super) inputs: &'a ChannelInputs,
    pub(super) chamber: Chamber<S>,
    /// What the sensor delivers now, gauge, Pa.
    pub(super) reading: S,
    /// The board's controller, where it is part of the simulation.
    pub(super) controller: Controller<S>,
    /// Does the force on the spool follow the drive?
    pub(super) lags: bool,
    /// Does the chamber opposite change the volume?
    faces: bool,
    /// The base model before effects.
    pub(super) base: BaseCoefficients<S>,
    /// Supply pressure over this interval before effects, Pa.
    pub(super) supply: S,
    /// What else is a variable.
    pub(super) deviations: Option<Deviations<S>>,
    /// Where the effects have left the fill and the vent port's drive in the last step.
    pub(super) spool: [S; 2],
}

impl<'a, S: Scalar> Run<'a, S> {
    /// Before the first row.
    pub(super) fn new(
        plant: &'a Plant,
        base: &[S],
        effects: &[AnyEffect<S>],
        inputs: &'a ChannelInputs,
    ) -> Self {
        let mut structure = Structure {
            flow_function: None,
            stretches: false,
            faces: false,
            heat_time_constant_s: None,
            outlet: None,
            line: None,
            lags: false,
        };
        for effect in effects {
            effect.structure(&mut structure);
        }
        Self {
            plant,
            inputs,
            lags: structure.lags,
            faces: structure.faces,
            chamber: Chamber::new(&plant.model, structure),
            reading: S::zero(),
            controller: Controller::new(),
            base: plant.model.coefficients(base),
            supply: S::zero(),
            deviations: None,
            spool: [S::zero(); 2],
        }
    }
}

impl<S: Scalar> Run<'_, S> {
    pub(super) fn start(&mut self, row: usize) {
        let measured = self.inputs.measured_pa[row];
        self.chamber.start(S::constant(measured));
        self.reading = S::constant(measured - self.inputs.ambient_pa);
        self.controller.start(self.reading, self.chamber.port());
    }

    /// Moves the pressure, and what the sensor delivers with it.
    pub(super) fn disturb(&mut self, pressure: S) {
        let change = pressure - self.chamber.pressure();
        self.chamber.shift(change);
        self.reading = self.reading + change;
        self.controller.shift(change);
    }

    /// Is the board's loop part of the simulation?
    pub(super) fn in_loop(&self) -> bool {
        self.inputs.in_loop() && self.plant.board.is_some()
    }

    /// Shows what it remembers beside its effects.
    pub(super) fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.chamber.memory(visit);
        if self.in_loop() {
            visit(Memory::Estimated, &mut self.reading);
            self.controller.memory(visit);
        }
    }

    /// What is reported: by a board, what its loop makes of the reading.
    pub(super) fn report(&self) -> S {
        match (&self.inputs.drive, &self.plant.board) {
            (DriveInput::Controlled, Some(board)) => self.controller.report(board, self.reading),
            _ => self.reading,
        }
    }

    /// One step with these positions of the spools at the fill and the vent port. Returns the flow
    /// drawn.
    #[inline(always)]
    pub(super) fn flow(
        &mut self,
        step: &Step<'_>,
        [fill, vent]: [S; 2],
        effects: &mut [AnyEffect<S>],
    ) -> S::Real {
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
            effect.sense(step, &mut reading);
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
            effect.supply(step, &mut supply, &areas, pressure);
        }
        if self.chamber.stretches() {
            let pressures = Facing { own: pressure, opposite: self.opposite(step, effects) };
            for effect in effects.iter_mut() {
                effect.stretch(step, &pressures, &mut stretch);
            }
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

    /// Pressure in the chamber opposite, absolute, Pa, where an effect asks for it and it is known.
    #[inline(always)]
    fn opposite(&self, step: &Step<'_>, effects: &[AnyEffect<S>]) -> Option<S> {
        let inputs = self.inputs;
        let here = *inputs.opposite_pa.get(step.row).filter(|_| self.faces)?;
        let next = inputs.opposite_pa.get(step.row + 1).copied().unwrap_or(here);
        let share = (step.time_s - inputs.time_s[step.row]) / inputs.interval_s[step.row];
        let reading = S::constant(here + share * (next - here));
        let shown = effects.iter().fold(reading, |reading, effect| effect.shown(reading));
        Some(shown.plus(inputs.ambient_pa))
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
