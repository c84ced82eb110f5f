//! One simulation of a channel, led by the measured pressure.

use super::window::{NEXT, NOW, Window};
use crate::diagnosis::Extended;
use crate::effects::catalogue::AnyEffect;
use crate::effects::{Plant, Stepper, StepperState, install};

/// The observer: a simulation between two steps.
#[derive(Clone)]
pub struct Observer {
    base: Vec<f64>,
    effects: Vec<AnyEffect<f64>>,
    state: StepperState<f64>,
    /// What the last innovation adds to the pressure, Pa.
    correction_pa: f64,
}

impl Observer {
    /// Of a channel with this model, not started yet.
    pub fn new(plant: &Plant, model: &Extended, window: &Window) -> Self {
        let count = plant.parameters().len();
        let mut effects = install(plant, &model.effects, &model.values);
        let base = model.values[..count].to_vec();
        let state = Stepper::new(plant, &base, &mut effects, &window.inputs).state();
        Self { base, effects, state, correction_pa: 0.0 }
    }

    /// Begins at rest at the pressure measured at the start of the step.
    pub fn start(&mut self, plant: &Plant, window: &Window) {
        let mut stepper = Stepper::new(plant, &self.base, &mut self.effects, &window.inputs);
        stepper.start(NOW);
        self.state = stepper.state();
        self.correction_pa = 0.0;
    }

    /// Over the step. Returns what is to be measured at its end (gauge, Pa), and the flow drawn
    /// from the supply (mm^2 Pa).
    pub fn advance(&mut self, plant: &Plant, window: &Window) -> (f64, f64) {
        let mut stepper = Stepper::new(plant, &self.base, &mut self.effects, &window.inputs);
        stepper.resume(self.state);
        stepper.set_pressure(stepper.pressure() + self.correction_pa);
        stepper.set_supply(window.inputs.supply_pa[NOW]);
        let (_, draw) = stepper.interval(NOW);
        let reading = stepper.reading(NEXT);
        self.state = stepper.state();
        self.correction_pa = 0.0;
        (reading, draw)
    }

    /// Goes on from a pressure that is so much higher, Pa.
    pub fn lead(&mut self, correction_pa: f64) {
        self.correction_pa = correction_pa;
    }

    /// Did it stay finite?
    pub fn is_finite(&self) -> bool {
        self.state.pressure().is_finite()
    }
}
