//! `stale_samples`: old samples repeated.

use crate::effects::{Domain, EffectInfo, EffectParameter, ChannelInputs, Hook, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "stale_samples",
    title: "Old samples repeated",
    physics: "Some rows carry the previous measurement again instead of a fresh one.",
    equation: "where a reading equals the one before exactly: y = (1 - share) p + share y before",
    source: "sample-and-hold of a missed measurement",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("share", "1", (0.0, 0.0, 1.0), "part of the repeated readings that are stale"),
    ],
    probes: &[&[0.5], &[1.0]],
    rivals: &["sensor_lag", "transport_delay"],
    separated_by: "any movement fast enough that two fresh samples differ",
    smallest: 0.1,
    check: "measurement task of the board against the bus rate; lost answers that are filled in",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct StaleSamples<S> {
    share: S,
    before: Option<S>,
}

impl<S: Scalar<Real = f64>> StaleSamples<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { share: values[0], before: None }
    }
}

impl<S: Scalar<Real = f64>> Hook<S> for StaleSamples<S> {
    fn reset(&mut self) {
        self.before = None;
    }

    fn sample(&mut self, inputs: &ChannelInputs, row: usize, reading: S) -> S {
        let repeated = row > 0 && inputs.measured_pa[row].total_cmp(&inputs.measured_pa[row - 1]).is_eq();
        let reading = match (repeated, self.before) {
            (true, Some(before)) => reading + self.share * (before - reading),
            _ => reading,
        };
        self.before = Some(reading);
        reading
    }
}
