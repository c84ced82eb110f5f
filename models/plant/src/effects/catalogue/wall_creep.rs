//! `wall_creep`: chamber creeps under pressure.

use crate::effects::{Domain, EffectInfo, EffectParameter, Facing, Hook, Memory, Step, Stretch, Question, Reach, Structure};
use crate::effects::remembered::Remembered;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "wall_creep",
    title: "Chamber creeps under pressure",
    physics: "The wall is viscoelastic: after a pressure step the chamber goes on growing for seconds to minutes.",
    equation: "time_constant dx/dt = compliance (p - p_ambient) - x,  V = V_0 (1 + x)",
    source: "standard linear solid",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: half a percent of the volume per 100 kPa: tubes of plastics.
        EffectParameter::linear("compliance", "1/(100 kPa)", (0.0, 0.0, 1.0), "relative growth of the volume per 100 kPa in the end").usual_to(0.005).of_load(),
        EffectParameter::logarithmic("time_constant", "s", (0.3, 5.0, 300.0), "time constant of the growth").of_load(),
    ],
    probes: &[&[0.05, 1.0], &[0.05, 4.0], &[0.05, 15.0], &[0.05, 60.0]],
    rivals: &["heat_exchange", "wall_compliance", "sensor_drift"],
    separated_by: "long holds with closed ports at high and low pressure",
    smallest: 0.004,
    traits: &[],
    check: "the material of the chamber, its age and temperature",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct WallCreep<S> {
    compliance: S,
    time_constant: S,
    stretch: Remembered<S>,
}

impl<S: Scalar> WallCreep<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { compliance: values[0], time_constant: values[1], stretch: Remembered::nothing() }
    }
}

impl<S: Scalar> Hook<S> for WallCreep<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.stretches = true;
    }

    fn reset(&mut self) {
        self.stretch = Remembered::nothing();
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.stretch.known().into_iter().for_each(|stretch| visit(Memory::Estimated, stretch));
    }

    #[inline(always)]
    fn stretch(&mut self, step: &Step<'_>, pressures: &Facing<S>, stretch: &mut Stretch<S>) {
        let wanted = self.compliance * pressures.own.plus(-step.inputs.ambient_pa).times(1e-5);
        let before = self.stretch.or(wanted);
        let rest = (-self.time_constant.recip().times(step.length_s)).exp();
        let change = (wanted - before) * (-rest).plus(1.0);
        self.stretch.set(before + change);
        stretch.factor = stretch.factor + before + change.times(0.5);
        stretch.rate = stretch.rate + change.times(1.0 / step.length_s);
    }
}
