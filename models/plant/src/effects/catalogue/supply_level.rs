//! `supply_level`: supply pressure has moved.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::model::Areas;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "supply_level",
    title: "Supply pressure has moved",
    physics: "The supply stands higher or lower than at the calibration.",
    equation: "p_s = p_nominal + level",
    source: "regulator setting",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Rig,
    parameters: &[
        EffectParameter::linear("level", "kPa", (-500.0, 0.0, 500.0), "change of the supply"),
    ],
    probes: &[&[-30.0], &[30.0]],
    rivals: &["valve_gain", "fill_leak"],
    separated_by: "filling to high pressure: the end pressure moves, not only the speed",
    smallest: 1.0,
    traits: &[],
    check: "the regulator and its gauge",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SupplyLevel<S> {
    level: S,
}

impl<S: Scalar> SupplyLevel<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { level: values[0] }
    }
}

impl<S: Scalar> Hook<S> for SupplyLevel<S> {
    #[inline(always)]
    fn supply(&mut self, _: &Step<'_>, supply: S, _: &Areas<S>, _: S) -> S {
        supply + self.level.times(1e3)
    }
}
