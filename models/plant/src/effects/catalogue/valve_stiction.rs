//! `valve_stiction`: spool sticks, then jumps.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Step, Question, Reach, Trait};
use crate::effects::remembered::Remembered;
use crate::numeric::{Real, Scalar};

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "valve_stiction",
    title: "Spool sticks, then jumps",
    physics: "Static friction holds the spool until the drive has moved away by a threshold; then it jumps to where the drive wants it.",
    equation: "u_spool = u where |u - u_spool before| >= threshold, else unchanged; behind a lag, each time that u is a threshold away",
    source: "stick-and-jump model, Choudhury, Thornhill, Shah, Control Eng. Practice 13, 2005",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: data sheets of good proportional valves: response sensitivity of 1 %.
        EffectParameter::linear("threshold", "1", (0.0, 0.0, 0.5), "movement of the drive that tears the spool off").usual_to(0.01),
    ],
    probes: &[&[0.015], &[0.04], &[0.08], &[0.15], &[0.25]],
    rivals: &["valve_hysteresis", "transport_delay"],
    separated_by: "slow small drive ramps: stiction shows stairs, play does not",
    smallest: 0.004,
    traits: &[Trait::Thresholded, Trait::LimitCycle],
    check: "dirt, varnish or side load on the spool; dither",
};

/// Thresholds below this are none.
const LEAST: f64 = 1e-9;

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ValveStiction<S> {
    threshold: S,
    position: [Remembered<S>; 2],
}

impl<S: Scalar> ValveStiction<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { threshold: values[0], position: [Remembered::nothing(); 2] }
    }
}

impl<S: Scalar> Hook<S> for ValveStiction<S> {
    fn reset(&mut self) {
        self.position = [Remembered::nothing(); 2];
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.position.iter_mut().filter_map(Remembered::known).for_each(|position| visit(Memory::Known, position));
    }

    #[inline(always)]
    fn drive(&mut self, step: &Step<'_>, valve: usize, drive: S) -> S {
        let before = self.position[valve].or(S::zero());
        let after = if step.lags {
            drive.with_real(jumped(before.real(), drive.real(), self.threshold.real()))
        } else {
            let stuck = (drive - before).abs().less(self.threshold);
            S::select(stuck, before, drive)
        };
        self.position[valve].set(after);
        after
    }
}

/// Where a spool stands that stood at `before`, once a force that never jumps has come to `force`:
/// it has torn off each time the force was a threshold away, and not jumped as far as steps of the
/// simulation happen to take the force.
#[inline(always)]
fn jumped<R: Real>(before: R, force: R, threshold: R) -> R {
    let way = force - before;
    let threshold = threshold.max(R::constant(LEAST));
    let jumps = (way.abs() / threshold).floor();
    before + (jumps * threshold).with_sign_of(way)
}
