//! `transport_delay`: dead time between drive and flow.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Step, Question, Reach};
use std::collections::VecDeque;

use crate::numeric::{Real, Scalar};

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "transport_delay",
    title: "Dead time between drive and flow",
    physics: "Nothing happens for a fixed time after the drive has changed, then the flow follows unchanged.",
    equation: "u_spool(t) = u(t - delay)",
    source: "pure delay of a line or a sampled bus; Franklin, Powell, Workman, Digital Control, ch. 4",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        // Usual: a board loop, an exchange and a row that is dated a little off.
        EffectParameter::linear("delay", "s", (0.0, 0.0, 0.25), "dead time").usual_to(0.004),
    ],
    probes: &[&[0.004], &[0.012], &[0.03], &[0.08]],
    rivals: &["valve_lag", "sensor_lag"],
    separated_by: "fast drive steps: a lag starts to move at once, a dead time does not",
    smallest: 0.0025,
    check: "loop and bus timing, valve switching time, length of the tube",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct TransportDelay<S> {
    delay: S,
    past: [VecDeque<S>; 2],
}

impl<S: Scalar> TransportDelay<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { delay: values[0], past: [VecDeque::new(), VecDeque::new()] }
    }
}

impl<S: Scalar> Hook<S> for TransportDelay<S> {
    fn reset(&mut self) {
        self.past.iter_mut().for_each(VecDeque::clear);
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.past.iter_mut().flatten().for_each(|drive| visit(Memory::Known, drive));
    }

    fn drive(&mut self, step: &Step<'_>, valve: usize, drive: S) -> S {
        let steps = self.delay.times(1.0 / step.length_s);
        let whole = steps.real().floor().max(S::Real::zero());
        let part = steps.shift(-whole);
        let longest = (0..S::Real::LANES).map(|lane| steps_of(whole, lane)).max().unwrap_or(0);
        let past = &mut self.past[valve];
        if past.is_empty() {
            // Before the first step it was what it is in it.
            past.resize(longest + 1, drive);
        }
        past.push_front(drive);
        past.truncate(longest + 2);
        let at = |k: usize| past.get(k).or(past.back()).copied().unwrap_or(drive);
        // Mean over the step of a drive that is constant over each step.
        let mean = |back: usize| at(back) + (at(back + 1) - at(back)) * part;
        let mut delayed = mean(steps_of(whole, 0));
        for lane in 1..S::Real::LANES {
            let own = S::Real::constant(whole.lane(lane));
            let differs = whole.lane(lane).total_cmp(&whole.lane(0)).is_ne();
            if differs {
                let equal = S::Real::both(S::Real::not(own.below(whole)), S::Real::not(whole.below(own)));
                delayed = S::select(equal, mean(steps_of(whole, lane)), delayed);
            }
        }
        delayed
    }
}

/// Whole steps in one lane.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // floored, not negative, bounded
fn steps_of<R: Real>(whole: R, lane: usize) -> usize {
    whole.lane(lane) as usize
}
