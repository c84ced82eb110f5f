//! `valve_asymmetry`: fill and vent gains differ.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, RegulatorLaw, Step, Question, Reach, Trait};
use crate::model::ValveLaw;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "valve_asymmetry",
    title: "Fill and vent gains differ",
    physics: "The vent port opens faster or slower over the drive than the fill port.",
    equation: "G_vent = ratio G_fill (of a regulator: speed falling over speed rising)",
    source: "spool geometry; two gains instead of the one of the nonlinear model",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        // Usual: data sheets state flows to 10 %. In a loop a supply that is 5 % more or less than
        // stated looks like 5 % beside: a choked fill goes with it, and a vent does not.
        EffectParameter::logarithmic("ratio", "1", (0.1, 1.0, 10.0), "vent gain over fill gain").in_base_to(0.1).seeming_in_loop(0.05),
    ],
    probes: &[&[0.6], &[0.85], &[1.2], &[1.7]],
    rivals: &["vent_restriction", "flow_function", "drive_saturation"],
    separated_by: "venting and filling over the whole range of drive and pressure",
    smallest: 0.015,
    traits: &[Trait::NeedsOneSpool],
    check: "the two ports of the valve, and what is screwed into them",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ValveAsymmetry<S> {
    ratio: S,
}

impl<S: Scalar> ValveAsymmetry<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { ratio: values[0] }
    }
}

impl<S: Scalar> Hook<S> for ValveAsymmetry<S> {
    #[inline(always)]
    fn valve(&mut self, _: &Step<'_>, law: &mut ValveLaw<S>) {
        law.gain_out = law.gain_out * self.ratio;
    }

    #[inline(always)]
    fn regulator(&mut self, _: &Step<'_>, law: &mut RegulatorLaw<S>) {
        law.falling = law.falling * self.ratio;
    }
}
