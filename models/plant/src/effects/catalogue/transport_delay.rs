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
    traits: &[],
    check: "loop and bus timing, valve switching time, length of the tube",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct TransportDelay<S> {
    delay: S,
    /// Drives of each valve and how long each of them lasted, s, the latest first.
    past: [VecDeque<(S, f64)>; 2],
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
        self.past.iter_mut().flatten().for_each(|(drive, _)| visit(Memory::Known, drive));
    }

    /// The mean over the step of a drive that is constant over each step. Steps are not of one
    /// length: neither are rows.
    #[inline(always)]
    fn drive(&mut self, step: &Step<'_>, valve: usize, drive: S) -> S {
        let past = &mut self.past[valve];
        past.push_front((drive, step.length_s));
        // Ages, from the end of the step back: the delayed step lasts from `until` to `since`.
        let (until, since) = (self.delay, self.delay.plus(step.length_s));
        let lanes = |age: S| (0..S::Real::LANES).map(move |lane| age.real().lane(lane));
        let youngest = lanes(until).fold(f64::INFINITY, f64::min);
        let oldest = lanes(since).fold(0.0, f64::max);
        let (mut sum, mut age, mut needed) = (S::zero(), 0.0, 0);
        for &(drive, lasted) in past.iter() {
            let (from, to) = (age, age + lasted);
            (age, needed) = (to, needed + 1);
            if to > youngest {
                let overlap = since.min(S::constant(to)) - until.max(S::constant(from));
                sum = sum + drive * overlap.max(S::zero());
            }
            if age >= oldest {
                break;
            }
        }
        past.truncate(needed);
        // Before the first step it was what it is in it.
        let first = past.back().map_or(drive, |(drive, _)| *drive);
        let before = (since - until.max(S::constant(age))).max(S::zero());
        (sum + first * before).times(1.0 / step.length_s)
    }
}
