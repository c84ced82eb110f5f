//! `sensor_drift`: sensor zero drifts.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_drift",
    title: "Sensor zero drifts",
    physics: "The zero of the sensor moves over the recording, with temperature for example.",
    equation: "y = p + rate t",
    source: "linear drift of the zero",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("rate", "kPa/min", (-120.0, 0.0, 120.0), "drift of the zero"),
    ],
    probes: &[&[2.0]],
    rivals: &["valve_wear", "wall_creep", "supply_ripple"],
    separated_by: "returning to ambient pressure again and again",
    smallest: 0.3,
    check: "the reading of the vented chamber at the beginning and at the end",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SensorDrift<S> {
    rate: S,
}

impl<S: Scalar<Real = f64>> SensorDrift<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { rate: values[0] }
    }
}

impl<S: Scalar<Real = f64>> Hook<S> for SensorDrift<S> {
    fn sense(&mut self, step: &Step<'_>, gauge: S) -> S {
        gauge + self.rate.times(1e3 / 60.0 * (step.time_s + 0.5 * step.length_s))
    }
}
