//! `wall_compliance`: chamber grows with pressure.

use crate::effects::{Domain, EffectInfo, EffectParameter, Facing, Hook, Step, Stretch, Question, Reach, Structure};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "wall_compliance",
    title: "Chamber grows with pressure",
    physics: "The wall gives way at once: at higher pressure the chamber is larger and its pressure changes more slowly.",
    equation: "V = V_0 (1 + compliance (p - p_ambient))",
    source: "linear elastic wall",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: half a percent of the volume per 100 kPa: fittings and tubes.
        EffectParameter::linear("compliance", "1/(100 kPa)", (0.0, 0.0, 1.0), "relative growth of the volume per 100 kPa").usual_to(0.005).of_load(),
    ],
    probes: &[&[0.02], &[0.08], &[0.25]],
    rivals: &["wall_creep", "flow_function", "sensor_nonlinearity"],
    separated_by: "the same flow at low and at high pressure",
    smallest: 0.004,
    traits: &[],
    check: "the chamber under pressure: diameter and length against pressure",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct WallCompliance<S> {
    compliance: S,
}

impl<S: Scalar> WallCompliance<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { compliance: values[0] }
    }
}

impl<S: Scalar> Hook<S> for WallCompliance<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.stretches = true;
    }

    #[inline(always)]
    fn stretch(&mut self, step: &Step<'_>, pressures: &Facing<S>, stretch: &mut Stretch<S>) {
        let per_pa = self.compliance.times(1e-5);
        stretch.factor = stretch.factor + per_pa * pressures.own.plus(-step.inputs.ambient_pa);
        stretch.by_pressure = stretch.by_pressure + per_pa;
    }
}
