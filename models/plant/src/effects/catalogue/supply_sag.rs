//! `supply_sag`: supply falls with the flow drawn.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Step, Question, Reach, Trait};
use crate::effects::remembered::Forgetting;
use crate::model::{Areas, ValveLaw, psi_max};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "supply_sag",
    title: "Supply falls with the flow drawn",
    physics: "The line or the regulator before the valves has a resistance: when channels fill, the supply at the valves falls, for all of them.",
    equation: "p_s = p_nominal - drop(t), drop follows resistance times total flow with a time constant",
    source: "linear resistance and volume of a supply line",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Rig,
    parameters: &[
        // Usual: 1 % of the supply: a good regulator and a short line.
        EffectParameter::linear("drop", "kPa", (0.0, 0.0, 400.0), "fall of the supply at the choked flow of one valve at full drive").usual_to(5.0),
        EffectParameter::linear("time_constant", "s", (0.0, 0.02, 1.5), "time in which the supply follows"),
    ],
    probes: &[&[10.0, 0.02], &[40.0, 0.02], &[100.0, 0.05], &[40.0, 0.3]],
    rivals: &["flow_function", "valve_asymmetry", "supply_ripple", "drive_saturation"],
    separated_by: "one channel filling alone against all filling at once, over a wide range of pressure",
    smallest: 1.0,
    traits: &[Trait::NeedsOthersDraw],
    check: "the supply pressure at the manifold while all channels fill; tube bore and regulator size",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SupplySag<S> {
    drop: S,
    time_constant: S,
    forgetting: Forgetting<S>,
    open: S,
    sag: S,
}

impl<S: Scalar> SupplySag<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self {
            drop: values[0],
            time_constant: values[1],
            forgetting: Forgetting::new(),
            open: S::zero(),
            sag: S::zero(),
        }
    }
}

impl<S: Scalar> Hook<S> for SupplySag<S> {
    fn reset(&mut self) {
        self.sag = S::zero();
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        visit(Memory::Estimated, &mut self.sag);
    }

    #[inline(always)]
    fn valve(&mut self, _: &Step<'_>, law: &mut ValveLaw<S>) {
        self.open = law.gain_in;
    }

    #[inline(always)]
    fn supply(&mut self, step: &Step<'_>, supply: S, areas: &Areas<S>, pressure: S) -> S {
        // Own flow from this simulation, the others' from the recording. The sag of the step before
        // closes the loop.
        let now = supply - self.sag;
        let ratio = (pressure / now).min(S::constant(1.0));
        let excess = (ratio.plus(-0.3)).times(1.0 / 0.7).max(S::zero());
        let psi = (-excess.square()).plus(1.0 + 1e-6).sqrt();
        let draw = (areas.fill * psi * now).plus(step.inputs.others_draw[step.row] / psi_max());
        let wanted = self.drop.times(1e3) * draw / (self.open * supply);
        let (_, rest) = self.forgetting.over(self.time_constant, step.length_s);
        let next = wanted + (self.sag - wanted) * rest;
        // Half a step at a time: at a large resistance the next step's flow is smaller.
        self.sag = (self.sag + next).times(0.5).min(supply.times(0.8));
        supply - self.sag
    }
}
