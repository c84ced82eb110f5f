//! `valve_hysteresis`: play between drive and spool.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Step, Question, Reach, Trait};
use crate::effects::remembered::Remembered;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "valve_hysteresis",
    title: "Play between drive and spool",
    physics: "The spool follows the drive only after a gap has been crossed: on the way up it stands lower than on the way down.",
    equation: "u_spool = clamp(u_spool before, u - half_width, u + half_width)",
    source: "play operator, Krasnoselskii and Pokrovskii, Systems with Hysteresis, 1989",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        // Usual: data sheets of good proportional valves: hysteresis of 1 to 2 %.
        EffectParameter::linear("half_width", "1", (0.0, 0.0, 0.5), "half the gap, as a part of full drive").usual_to(0.008),
    ],
    probes: &[&[0.015], &[0.04], &[0.1], &[0.2]],
    rivals: &["valve_stiction", "transport_delay"],
    separated_by: "slow small drive reversals at several levels: play follows smoothly after the gap, stiction jumps",
    smallest: 0.004,
    traits: &[Trait::LimitCycle],
    check: "friction and magnetic hysteresis of the valve: dither the drive and see whether it vanishes",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ValveHysteresis<S> {
    half_width: S,
    position: [Remembered<S>; 2],
}

impl<S: Scalar> ValveHysteresis<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { half_width: values[0], position: [Remembered::nothing(); 2] }
    }
}

impl<S: Scalar> Hook<S> for ValveHysteresis<S> {
    fn reset(&mut self) {
        self.position = [Remembered::nothing(); 2];
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.position.iter_mut().filter_map(Remembered::known).for_each(|position| visit(Memory::Known, position));
    }

    #[inline(always)]
    fn drive(&mut self, _: &Step<'_>, valve: usize, drive: S) -> S {
        let before = self.position[valve].or(S::zero());
        let after = before.max(drive - self.half_width).min(drive + self.half_width);
        self.position[valve].set(after);
        after
    }
}
