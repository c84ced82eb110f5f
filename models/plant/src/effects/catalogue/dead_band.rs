//! `dead_band`: regulator ignores small changes.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Step, Question, Reach, Trait};
use crate::effects::remembered::Remembered;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "dead_band",
    title: "Regulator ignores small changes",
    physics: "The regulator does not react until the command differs from what it acts on by a band.",
    equation: "command acted on = where |command - acted on| >= width: command",
    source: "dead band of an electro-pneumatic regulator",
    question: Question::Structure,
    domain: Domain::Regulator,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("width", "1", (0.0, 0.0, 0.3), "band as a part of the command range"),
    ],
    probes: &[&[0.01], &[0.03], &[0.08]],
    rivals: &["valve_hysteresis"],
    separated_by: "slow small command ramps in both directions",
    smallest: 0.002,
    traits: &[Trait::Thresholded],
    check: "the regulator's sensitivity in its data sheet",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct DeadBand<S> {
    width: S,
    position: [Remembered<S>; 2],
}

impl<S: Scalar> DeadBand<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { width: values[0], position: [Remembered::nothing(); 2] }
    }
}

impl<S: Scalar> Hook<S> for DeadBand<S> {
    fn reset(&mut self) {
        self.position = [Remembered::nothing(); 2];
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.position.iter_mut().filter_map(Remembered::known).for_each(|position| visit(Memory::Known, position));
    }

    #[inline(always)]
    fn drive(&mut self, _: &Step<'_>, valve: usize, drive: S) -> S {
        let before = self.position[valve].or(drive);
        let after = S::select((drive - before).abs().less(self.width), before, drive);
        self.position[valve].set(after);
        after
    }
}
