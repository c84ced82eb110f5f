//! `valve_gain`: valve gain has changed.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::model::ValveLaw;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "valve_gain",
    title: "Valve gain has changed",
    physics: "The same drive opens the ports more or less than at the calibration.",
    equation: "G = ratio G_0",
    source: "change of the opening per drive",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::logarithmic("ratio", "1", (0.1, 1.0, 10.0), "gain over the calibrated one"),
    ],
    probes: &[&[0.8], &[1.2]],
    rivals: &["chamber_volume", "supply_level"],
    separated_by: "fast and slow movements over the whole range",
    smallest: 0.01,
    traits: &[],
    check: "the valve, its driver and its supply voltage",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ValveGain<S> {
    ratio: S,
}

impl<S: Scalar> ValveGain<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { ratio: values[0] }
    }
}

impl<S: Scalar> Hook<S> for ValveGain<S> {
    #[inline(always)]
    fn valve(&mut self, _: &Step<'_>, law: &mut ValveLaw<S>) {
        law.gain_in = law.gain_in * self.ratio;
        law.gain_out = law.gain_out * self.ratio;
    }
}
