//! `supply_misstated`: the supply is not what the rig file states. Never named.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Question, Reach, Step, Trait};
use crate::model::Areas;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "supply_misstated",
    title: "Supply is not what the rig file states",
    physics: "A gauge is read to some per cent. Of a supply that is lower than stated, chambers fill more slowly the higher their pressure is; so they do where the supply falls with the flow, or the flow function is another.",
    equation: "p_s = (1 + share) p_stated",
    source: "gauges of class 4 and worse, EN 837-1",
    question: Question::Foil,
    domain: Domain::Valve,
    reach: Reach::Rig,
    // A regulator that somebody has turned is off by more than its gauge.
    parameters: &[EffectParameter::linear("share", "1", (-0.3, 0.0, 0.3), "error of the stated supply, as a part of its absolute pressure")],
    probes: &[&[-0.1], &[-0.03], &[0.03]],
    rivals: &["supply_sag", "flow_function"],
    separated_by: "a recorded supply pressure; without it, slow fills close to the supply's pressure beside fast ones",
    smallest: 0.002,
    traits: &[Trait::NeedsStatedSupply],
    check: "the regulator's gauge",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SupplyMisstated<S> {
    share: S,
}

impl<S: Scalar> SupplyMisstated<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { share: values[0] }
    }
}

impl<S: Scalar> Hook<S> for SupplyMisstated<S> {
    #[inline(always)]
    fn supply(&mut self, _: &Step<'_>, supply: S, _: &Areas<S>, _: S) -> S {
        supply + supply * self.share
    }
}
