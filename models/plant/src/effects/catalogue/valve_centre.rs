//! `valve_centre`: valve centre has shifted.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "valve_centre",
    title: "Valve centre has shifted",
    physics: "The spool rests beside its calibrated centre: more drive is needed on one side, less on the other.",
    equation: "u_spool = u + centre",
    source: "shift of the spool at zero drive",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("centre", "1", (-0.5, 0.0, 0.5), "shift of the spool at zero drive"),
    ],
    probes: &[&[-0.03], &[0.03]],
    rivals: &["fill_leak", "exhaust_leak"],
    separated_by: "small drives on both sides of the centre",
    smallest: 0.003,
    traits: &[],
    check: "the zero adjustment of the valve",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ValveCentre<S> {
    centre: S,
}

impl<S: Scalar> ValveCentre<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { centre: values[0] }
    }
}

impl<S: Scalar> Hook<S> for ValveCentre<S> {
    #[inline(always)]
    fn drive(&mut self, _: &Step<'_>, valve: usize, drive: S) -> S {
        if valve == 0 { drive + self.centre } else { drive - self.centre }
    }
}
