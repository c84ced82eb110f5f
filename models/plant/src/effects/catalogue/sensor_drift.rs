//! `sensor_drift`: sensor zero drifts.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach, Trait};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_drift",
    title: "Sensor zero drifts",
    physics: "The zero of the sensor moves over the recording, as when it warms up.",
    equation: "y = p + change (1 - exp(-t / time_constant))",
    source: "warm-up drift of the zero",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: 0.2 % of a 100 psi range, as data sheets state it.
        EffectParameter::linear("change", "kPa", (-200.0, 0.0, 200.0), "change of the zero in the end").usual_to(1.5),
        EffectParameter::logarithmic("time_constant", "s", (20.0, 200.0, 3000.0), "time constant of the change"),
    ],
    probes: &[&[4.0, 30.0], &[8.0, 300.0]],
    rivals: &["valve_wear", "wall_creep", "supply_ripple"],
    separated_by: "returning to ambient pressure again and again",
    smallest: 0.3,
    traits: &[Trait::WithinARecording],
    check: "the reading of the vented chamber at the beginning and at the end",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SensorDrift<S> {
    change: S,
    time_constant: S,
}

impl<S: Scalar> SensorDrift<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { change: values[0], time_constant: values[1] }
    }
}

impl<S: Scalar> Hook<S> for SensorDrift<S> {
    #[inline(always)]
    fn sense(&mut self, step: &Step<'_>, gauge: S) -> S {
        let grown = (-(-self.time_constant.recip().times(step.time_s + 0.5 * step.length_s)).exp()).plus(1.0);
        gauge + (self.change * grown).times(1e3)
    }
}
