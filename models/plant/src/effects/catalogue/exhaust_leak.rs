//! `exhaust_leak`: leak to the air.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::model::Areas;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "exhaust_leak",
    title: "Leak to the air",
    physics: "Air escapes from the chamber past the valve or through a fitting, at all times.",
    equation: "A_vent = A_port + area",
    source: "orifice to ambient, ISO 6358-1",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("area", "mm2", (0.0, 0.0, 20.0), "effective area of the leak"),
    ],
    probes: &[&[0.02], &[0.1]],
    rivals: &["fill_leak", "valve_centre"],
    separated_by: "closed ports at high pressure",
    smallest: 0.001,
    traits: &[],
    check: "soap water on chamber, tube and fittings",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ExhaustLeak<S> {
    area: S,
}

impl<S: Scalar> ExhaustLeak<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { area: values[0] }
    }
}

impl<S: Scalar> Hook<S> for ExhaustLeak<S> {
    #[inline(always)]
    fn areas(&mut self, _: &Step<'_>, areas: &mut Areas<S>) {
        areas.vent = areas.vent + self.area;
    }
}
