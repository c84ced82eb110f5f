//! `sensor_gain`: sensor gain has moved.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_gain",
    title: "Sensor gain has moved",
    physics: "The reading is wrong by a factor.",
    equation: "y = ratio p",
    source: "span error",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::logarithmic("ratio", "1", (0.3, 1.0, 3.0), "reading over pressure"),
    ],
    probes: &[&[0.97], &[1.03]],
    rivals: &["supply_level", "valve_gain"],
    separated_by: "venting to ambient and filling to the supply",
    smallest: 0.003,
    traits: &[],
    check: "the sensor against a reference gauge at high pressure",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SensorGain<S> {
    ratio: S,
}

impl<S: Scalar> SensorGain<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { ratio: values[0] }
    }
}

impl<S: Scalar> Hook<S> for SensorGain<S> {
    #[inline(always)]
    fn sense(&mut self, _: &Step<'_>, gauge: S) -> S {
        gauge * self.ratio
    }
}
