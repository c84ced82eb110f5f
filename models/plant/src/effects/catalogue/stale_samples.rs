//! `stale_samples`: old samples repeated.

use crate::effects::{Domain, EffectInfo, EffectParameter, ChannelInputs, Hook, Memory, Question, Reach, Step, Trait};
use crate::effects::remembered::Remembered;
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
    traits: &[Trait::RoughlyTimed],
    check: "measurement task of the board against the bus rate; lost answers that are filled in",
};

/// A coarse converter repeats itself by chance while the pressure moves by less than this many
/// times the noise.
const CHANCE: f64 = 4.0;

/// The effect at work.
#[derive(Debug, Clone)]
pub struct StaleSamples<S> {
    share: S,
    held: Remembered<S>,
}

impl<S: Scalar> StaleSamples<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { share: values[0], held: Remembered::nothing() }
    }

    /// What is delivered while the old sample is held, or else.
    fn deliver(&mut self, held: bool, noise_pa: f64, fresh: S) -> S {
        let old = self.held.or(fresh);
        if !held {
            self.held.set(fresh);
            return fresh;
        }
        self.held.set(old);
        let back = old - fresh;
        let by_chance = S::constant(CHANCE * noise_pa);
        S::select(by_chance.less(back.abs()), fresh + self.share * back, fresh)
    }
}

/// Does a row repeat the one before it? What was not measured was not repeated either.
fn repeated(inputs: &ChannelInputs, row: usize) -> bool {
    let known = row > 0 && row < inputs.rows() && inputs.usable[row] && inputs.usable[row - 1];
    known && inputs.measured_pa[row].total_cmp(&inputs.measured_pa[row - 1]).is_eq()
}

impl<S: Scalar> Hook<S> for StaleSamples<S> {
    fn reset(&mut self) {
        self.held = Remembered::nothing();
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.held.known().into_iter().for_each(|held| visit(Memory::Known, held));
    }

    /// A board's loop follows the old sample. Rows that are equal say that it was held from some
    /// time before the first of them until some time after the last: half an interval in the mean.
    #[inline]
    fn sense(&mut self, step: &Step<'_>, gauge: S) -> S {
        let inputs = step.inputs;
        if !inputs.in_loop() {
            return gauge;
        }
        // A loop that ends in the middle is early, however its time is rounded.
        let late = step.end_of_interval() > 0.5 + 1e-6;
        let held = repeated(inputs, step.row + 1) || repeated(inputs, if late { step.row + 2 } else { step.row });
        self.deliver(held, inputs.noise_pa, gauge)
    }

    fn sample(&mut self, inputs: &ChannelInputs, row: usize, reading: S) -> S {
        if inputs.in_loop() { reading } else { self.deliver(repeated(inputs, row), inputs.noise_pa, reading) }
    }
}
