//! `rate_limit`: pressure cannot change faster.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, RegulatorLaw, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "rate_limit",
    title: "Pressure cannot change faster",
    physics: "The flow through the regulator is limited, so that large steps become ramps.",
    equation: "|dp/dt| <= limit",
    source: "choked flow of the regulator",
    question: Question::Structure,
    domain: Domain::Regulator,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::logarithmic("limit", "kPa/s", (1.0, 20000.0, 20000.0), "largest rate of pressure"),
    ],
    probes: &[&[20.0], &[80.0], &[300.0], &[1200.0]],
    rivals: &["valve_asymmetry", "valve_lag"],
    separated_by: "small and large command steps",
    smallest: 1.0,
    traits: &[],
    check: "the regulator's flow rating against the volume it fills",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct RateLimit<S> {
    limit: S,
}

impl<S: Scalar> RateLimit<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { limit: values[0] }
    }
}

impl<S: Scalar> Hook<S> for RateLimit<S> {
    #[inline]
    fn regulator(&mut self, _: &Step<'_>, law: &mut RegulatorLaw<S>) {
        law.slew_pa_s = Some(self.limit.times(1e3));
    }
}
