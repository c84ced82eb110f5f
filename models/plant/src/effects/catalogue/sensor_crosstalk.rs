//! `sensor_crosstalk`: reading contains the channel sampled before.

use crate::effects::{Domain, EffectInfo, EffectParameter, ChannelInputs, Hook, Question, Reach, Step, Trait};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_crosstalk",
    title: "Reading contains the channel sampled before",
    physics: "The sampling capacitor has not settled when the converter moves on: a part of the previous channel remains in the reading.",
    equation: "y = p + share (p_before - p), p_before measured",
    source: "RP2040 datasheet, ADC: source impedance and settling",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: half a percent: a converter that settles.
        EffectParameter::linear("share", "1", (-0.1, 0.0, 0.5), "part of the other channel's reading").usual_to(0.004),
    ],
    probes: &[&[0.02]],
    rivals: &["chamber_coupling", "supply_sag"],
    separated_by: "one channel held while the one sampled before it moves",
    smallest: 0.002,
    traits: &[Trait::NeedsSampledBefore],
    check: "source impedance and settling time of the converter's inputs",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SensorCrosstalk<S> {
    share: S,
}

impl<S: Scalar> SensorCrosstalk<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { share: values[0] }
    }
}

impl<S: Scalar> Hook<S> for SensorCrosstalk<S> {
    /// A board's loop follows what its converter delivers.
    #[inline(always)]
    fn sense(&mut self, step: &Step<'_>, gauge: S) -> S {
        match step.inputs.sampled_before_pa.get(step.row) {
            Some(&here) if step.inputs.in_loop() => {
                let there = step.inputs.sampled_before_pa.get(step.row + 1).copied().unwrap_or(here);
                let before = here + step.end_of_interval() * (there - here);
                gauge - self.share * gauge.plus(-before)
            }
            _ => gauge,
        }
    }

    fn sample(&mut self, inputs: &ChannelInputs, row: usize, reading: S) -> S {
        match inputs.sampled_before_pa.get(row) {
            Some(&before) if !inputs.in_loop() => reading - self.share * reading.plus(-before),
            _ => reading,
        }
    }
}
