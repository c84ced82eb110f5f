//! `valve_wear`: valve gain changes over the recording.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach, Trait};
use crate::model::ValveLaw;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "valve_wear",
    title: "Valve gain changes over the recording",
    physics: "The same drive opens the ports less (or more) at the end of the recording than at its start.",
    equation: "G = G_0 exp(rate t)",
    source: "exponential change of the gain",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: a coil that warms up.
        EffectParameter::linear("rate", "1/min", (-3.0, 0.0, 3.0), "relative change of the gain per minute").usual_to(0.01),
    ],
    probes: &[&[-0.05]],
    rivals: &["supply_ripple", "sensor_drift"],
    separated_by: "the same movement repeated at the start and at the end, filling and venting",
    smallest: 0.005,
    traits: &[Trait::WithinARecording],
    check: "the valve: dirt, warming coil, wear",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ValveWear<S> {
    rate: S,
}

impl<S: Scalar> ValveWear<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { rate: values[0] }
    }
}

impl<S: Scalar> Hook<S> for ValveWear<S> {
    #[inline(always)]
    fn valve(&mut self, step: &Step<'_>, law: &mut ValveLaw<S>) {
        let factor = self.rate.times(step.time_s / 60.0).exp();
        law.gain_in = law.gain_in * factor;
        law.gain_out = law.gain_out * factor;
    }
}
