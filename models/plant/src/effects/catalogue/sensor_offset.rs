//! `sensor_offset`: sensor zero has moved.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_offset",
    title: "Sensor zero has moved",
    physics: "The reading is wrong by a constant.",
    equation: "y = p + offset",
    source: "zero error",
    question: Question::Change,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("offset", "kPa", (-200.0, 0.0, 200.0), "added to the reading"),
    ],
    probes: &[&[-3.0], &[3.0]],
    rivals: &["sensor_gain", "supply_level"],
    separated_by: "venting to ambient and filling to the supply",
    smallest: 0.3,
    traits: &[],
    check: "the reading of the vented chamber",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SensorOffset<S> {
    offset: S,
}

impl<S: Scalar> SensorOffset<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { offset: values[0] }
    }
}

impl<S: Scalar> Hook<S> for SensorOffset<S> {
    #[inline(always)]
    fn sense(&mut self, _: &Step<'_>, gauge: S) -> S {
        gauge + self.offset.times(1e3)
    }
}
