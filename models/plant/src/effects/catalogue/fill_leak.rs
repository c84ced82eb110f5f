//! `fill_leak`: leak from the supply.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::model::Areas;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "fill_leak",
    title: "Leak from the supply",
    physics: "The fill port does not close: air creeps in from the supply.",
    equation: "A_fill = A_port + area",
    source: "orifice from the supply, ISO 6358-1",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("area", "mm2", (0.0, 0.0, 20.0), "effective area of the leak"),
    ],
    probes: &[&[0.02], &[0.1]],
    rivals: &["exhaust_leak", "valve_centre"],
    separated_by: "closed ports at low pressure",
    smallest: 0.001,
    traits: &[],
    check: "the seat of the fill port: dirt or wear",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct FillLeak<S> {
    area: S,
}

impl<S: Scalar> FillLeak<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { area: values[0] }
    }
}

impl<S: Scalar> Hook<S> for FillLeak<S> {
    #[inline(always)]
    fn areas(&mut self, _: &Step<'_>, areas: &mut Areas<S>) {
        areas.fill = areas.fill + self.area;
    }
}
