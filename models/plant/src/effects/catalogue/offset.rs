//! `offset`: pressure stands beside the command.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, RegulatorLaw, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "offset",
    title: "Pressure stands beside the command",
    physics: "The regulator holds a pressure that differs from the command by a constant.",
    equation: "dp/dt = beta (command + offset) - alpha p",
    source: "zero error of a regulator",
    question: Question::Structure,
    domain: Domain::Regulator,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("offset", "kPa", (-100.0, 0.0, 100.0), "added to the command"),
    ],
    probes: &[&[-3.0], &[3.0]],
    rivals: &["dead_band"],
    separated_by: "commands over the whole range, held",
    smallest: 0.3,
    traits: &[],
    check: "the regulator's zero",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct Offset<S> {
    offset: S,
}

impl<S: Scalar> Offset<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { offset: values[0] }
    }
}

impl<S: Scalar> Hook<S> for Offset<S> {
    #[inline]
    fn regulator(&mut self, _: &Step<'_>, law: &mut RegulatorLaw<S>) {
        law.offset_pa = law.offset_pa + self.offset.times(1e3);
    }
}
