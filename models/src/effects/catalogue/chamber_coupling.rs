//! `chamber_coupling`: neighbouring chamber changes the volume.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Stretch, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "chamber_coupling",
    title: "Neighbouring chamber changes the volume",
    physics: "The chamber on the other side of the joint pushes: its pressure shortens this chamber when the bending is not measured.",
    equation: "V = V_0 (1 - coupling p_opposite), p_opposite measured",
    source: "statics of an antagonistic pair",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("coupling", "1/(100 kPa)", (-0.5, 0.0, 0.5), "relative loss of volume per 100 kPa in the chamber opposite"),
    ],
    probes: &[&[0.02], &[0.08]],
    rivals: &["sensor_crosstalk", "supply_sag", "wall_compliance"],
    separated_by: "one chamber held with closed ports while the one opposite moves",
    smallest: 0.003,
    check: "measure the joint angle, or hold the joint and see whether it vanishes",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ChamberCoupling<S> {
    coupling: S,
}

impl<S: Scalar<Real = f64>> ChamberCoupling<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { coupling: values[0] }
    }
}

impl<S: Scalar<Real = f64>> Hook<S> for ChamberCoupling<S> {
    fn stretch(&mut self, step: &Step<'_>, _: S, stretch: &mut Stretch<S>) {
        let opposite = &step.inputs.opposite_pa;
        let (Some(&now), Some(&next)) = (opposite.get(step.row), opposite.get(step.row + 1).or(opposite.last())) else {
            return;
        };
        let slope = (next - now) / step.inputs.interval_s[step.row];
        let at = now + slope * (step.time_s - step.inputs.time_s[step.row]);
        stretch.factor = stretch.factor - self.coupling.times(at * 1e-5);
        stretch.rate = stretch.rate - self.coupling.times(slope * 1e-5);
    }
}
