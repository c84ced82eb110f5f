//! `valve_lag`: spool follows with a lag.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Step, Question, Reach, Structure};
use crate::effects::remembered::{Forgetting, Remembered};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "valve_lag",
    title: "Spool follows with a lag",
    physics: "The spool needs time to follow the drive: coil current and spool mass make it a first-order lag.",
    equation: "time_constant du_spool/dt = u - u_spool",
    source: "first-order servo-valve model, Merritt, Hydraulic Control Systems, ch. 7",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        // Usual: small proportional valves follow within some milliseconds.
        EffectParameter::linear("time_constant", "s", (0.0, 0.0, 0.5), "time constant of the spool").usual_to(0.004),
    ],
    probes: &[&[0.004], &[0.012], &[0.03], &[0.1]],
    rivals: &["transport_delay", "sensor_lag"],
    separated_by: "fast drive steps: a lag starts to move at once, a dead time does not; a sensor lag rounds pressure corners that are not at drive steps",
    smallest: 0.0025,
    traits: &[],
    check: "coil current rise, spring and friction of the spool",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ValveLag<S> {
    time_constant: S,
    forgetting: Forgetting<S>,
    position: [Remembered<S>; 2],
}

impl<S: Scalar> ValveLag<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { time_constant: values[0], forgetting: Forgetting::new(), position: [Remembered::nothing(); 2] }
    }
}

impl<S: Scalar> Hook<S> for ValveLag<S> {
    fn reset(&mut self) {
        self.position = [Remembered::nothing(); 2];
    }

    fn structure(&self, structure: &mut Structure<S>) {
        structure.lags = true;
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.position.iter_mut().filter_map(Remembered::known).for_each(|position| visit(Memory::Estimated, position));
    }

    #[inline(always)]
    fn drive(&mut self, step: &Step<'_>, valve: usize, drive: S) -> S {
        let start = self.position[valve].or(drive);
        let (ratio, rest) = self.forgetting.over(self.time_constant, step.length_s);
        self.position[valve].set(drive + (start - drive) * rest);
        // Mean over the step.
        drive + (start - drive) * ratio * (-rest).plus(1.0)
    }
}
