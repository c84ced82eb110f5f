//! `chamber_volume`: chamber volume has changed.

use crate::effects::{Domain, EffectInfo, EffectParameter, Facing, Hook, Question, Reach, Step, Stretch, Trait, Structure};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "chamber_volume",
    title: "Chamber volume has changed",
    physics: "The gas volume behind the valve is larger or smaller than at the calibration.",
    equation: "V = ratio V_0",
    source: "another tube, water, a stuck fold",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::logarithmic("ratio", "1", (0.1, 1.0, 10.0), "volume over the calibrated one").of_load(),
    ],
    probes: &[&[0.8], &[1.2]],
    rivals: &["valve_gain", "supply_level"],
    separated_by: "leaking down with closed ports as well as filling: the volume slows both",
    smallest: 0.01,
    traits: &[Trait::ScaleOfLoad],
    check: "tube length, water in the chamber, a fold that does not open",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ChamberVolume<S> {
    ratio: S,
}

impl<S: Scalar> ChamberVolume<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { ratio: values[0] }
    }
}

impl<S: Scalar> Hook<S> for ChamberVolume<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.stretches = true;
    }

    #[inline(always)]
    fn stretch(&mut self, _: &Step<'_>, _: &Facing<S>, stretch: &mut Stretch<S>) {
        stretch.factor = stretch.factor * self.ratio;
    }
}
