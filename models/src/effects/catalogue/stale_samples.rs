//! `stale_samples`: old samples repeated.

use crate::effects::{Domain, EffectInfo, EffectParameter, ChannelInputs, Hook, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "stale_samples",
    title: "Old samples repeated",
    physics: "Some rows carry the previous measurement again instead of a fresh one.",
    equation: "where a reading repeats the one before exactly though the pressure has moved: y = (1 - share) p + share y_before",
    source: "sample-and-hold of a missed measurement",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("share", "1", (0.0, 0.0, 1.0), "part of the impossible repeats that are stale"),
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
    held: Option<S>,
}

impl<S: Scalar<Real = f64>> StaleSamples<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { share: values[0], held: None }
    }
}

impl<S: Scalar<Real = f64>> Hook<S> for StaleSamples<S> {
    fn reset(&mut self) {
        self.held = None;
    }

    fn sample(&mut self, inputs: &ChannelInputs, row: usize, reading: S) -> S {
        // A coarse converter repeats itself by chance while the pressure hardly moves.
        const CHANCE: f64 = 4.0;
        // What was not measured was not repeated either.
        let measured = row > 0 && inputs.usable[row] && inputs.usable[row - 1];
        let repeated =
            measured && inputs.measured_pa[row].total_cmp(&inputs.measured_pa[row - 1]).is_eq();
        match self.held {
            Some(held) if repeated => {
                let back = held - reading;
                if back.real().abs() > CHANCE * inputs.noise_pa { reading + self.share * back } else { reading }
            }
            _ => {
                self.held = Some(reading);
                reading
            }
        }
    }
}
