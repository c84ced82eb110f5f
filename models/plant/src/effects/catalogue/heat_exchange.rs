//! `heat_exchange`: gas temperature is a state.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Structure, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "heat_exchange",
    title: "Gas temperature is a state",
    physics: "Filling heats the gas and venting cools it; the wall brings it back to ambient with a time constant. Fast changes are adiabatic, slow ones isothermal.",
    equation: "first law with outflow at the gas temperature and a wall of constant conductance",
    source: "Carneiro and de Almeida, Proc. IMechE I 220, 2006",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: 0.02 s: hardly to be told from isothermal.
        EffectParameter::logarithmic("time_constant", "s", (0.004, 0.004, 40.0), "time constant of the gas temperature at 250 kPa absolute").usual_to(1.6).of_load(),
    ],
    probes: &[&[0.03], &[0.12], &[0.5], &[2.0]],
    rivals: &["wall_creep", "wall_compliance", "line_restriction"],
    separated_by: "fast pressure steps followed by closed ports: the pressure relaxes while the temperature returns",
    smallest: 0.003,
    traits: &[],
    check: "nothing is wrong: it is physics the simple model leaves out",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct HeatExchange<S> {
    time_constant: S,
}

impl<S: Scalar> HeatExchange<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { time_constant: values[0] }
    }
}

impl<S: Scalar> Hook<S> for HeatExchange<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.heat_time_constant_s = Some(self.time_constant);
    }
}
