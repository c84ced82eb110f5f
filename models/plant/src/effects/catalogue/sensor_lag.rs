//! `sensor_lag`: measurement lags the pressure.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Step, Question, Reach, Trait};
use crate::effects::remembered::{Forgetting, Remembered};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_lag",
    title: "Measurement lags the pressure",
    physics: "A filter, a narrow sensor port or the sensor itself delays and rounds the reading.",
    equation: "time_constant dy/dt = p - y",
    source: "first-order low-pass filter",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: the anti-aliasing filter before the converter.
        EffectParameter::linear("time_constant", "s", (0.0, 0.0, 0.5), "time constant of the reading").usual_to(0.004),
    ],
    probes: &[&[0.004], &[0.012], &[0.03], &[0.1]],
    rivals: &["valve_lag", "transport_delay", "line_restriction"],
    separated_by: "pressure corners that do not coincide with drive steps: saturation, choking, another source of pressure",
    smallest: 0.0025,
    traits: &[Trait::FastInLoop],
    check: "filter settings on the board and in the sensor, tube to the sensor",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SensorLag<S> {
    time_constant: S,
    forgetting: Forgetting<S>,
    last: Remembered<S>,
    reading: Remembered<S>,
}

impl<S: Scalar> SensorLag<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self {
            time_constant: values[0],
            forgetting: Forgetting::new(),
            last: Remembered::nothing(),
            reading: Remembered::nothing(),
        }
    }
}

impl<S: Scalar> Hook<S> for SensorLag<S> {
    fn reset(&mut self) {
        self.last = Remembered::nothing();
        self.reading = Remembered::nothing();
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        let remembered = [&mut self.last, &mut self.reading].into_iter();
        remembered.filter_map(Remembered::known).for_each(|value| visit(Memory::Estimated, value));
    }

    #[inline(always)]
    fn sense(&mut self, step: &Step<'_>, gauge: S) -> S {
        let before = self.last.or(gauge);
        let start = self.reading.or(gauge);
        let (ratio, rest) = self.forgetting.over(self.time_constant, step.length_s);
        // Exact for a pressure that is a straight line over the step.
        let lagging = (gauge - before) * ratio;
        let reading = gauge - lagging + (start - before + lagging) * rest;
        self.last.set(gauge);
        self.reading.set(reading);
        reading
    }
}
