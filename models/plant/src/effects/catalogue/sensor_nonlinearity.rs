//! `sensor_nonlinearity`: sensor characteristic is curved.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_nonlinearity",
    title: "Sensor characteristic is curved",
    physics: "The reading is right at the ends of the range and wrong in the middle.",
    equation: "y = p + bow 4 x (1 - x), x = p / range",
    source: "terminal-based nonlinearity, IEC 61298-2",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: half a percent of a 100 psi range, as data sheets state it.
        EffectParameter::linear("bow", "kPa", (-80.0, 0.0, 80.0), "error in the middle of the 100 psi range").usual_to(3.0),
    ],
    probes: &[&[-6.0], &[6.0]],
    rivals: &["wall_compliance", "flow_function"],
    separated_by: "a slow sweep over the whole range beside a reference gauge",
    smallest: 1.0,
    traits: &[],
    check: "the sensor against a reference gauge at three pressures",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SensorNonlinearity<S> {
    bow: S,
}

impl<S: Scalar> SensorNonlinearity<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { bow: values[0] }
    }
}

/// Range of the sensor, Pa: 100 psi.
const RANGE_PA: f64 = 689_475.7;

impl<S: Scalar> Hook<S> for SensorNonlinearity<S> {
    #[inline(always)]
    fn sense(&mut self, _: &Step<'_>, gauge: S) -> S {
        let x = gauge.times(1.0 / RANGE_PA);
        gauge + (self.bow * x * (-x).plus(1.0)).times(4.0e3)
    }

    // With a = 4 bow / range, a x^2 - (1 + a) x + reading / range = 0, in the form that does not
    // cancel where a is small.
    #[inline(always)]
    fn shown(&self, reading: S) -> S {
        let a = self.bow.times(4.0e3 / RANGE_PA);
        let straight = a.plus(1.0);
        let under = straight.square() - (a * reading).times(4.0 / RANGE_PA);
        reading.times(2.0) / (straight + under.sqrt())
    }
}
