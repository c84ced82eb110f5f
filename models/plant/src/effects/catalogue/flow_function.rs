//! `flow_function`: flow function differs from nominal.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Structure, Question, Reach};
use crate::model::GeneralFlow;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "flow_function",
    title: "Flow function differs from nominal",
    physics: "The ports choke at another pressure ratio, or the subsonic flow falls off with another exponent, than the rig file says.",
    equation: "psi = psi_max (1 - ((r - critical_ratio) / (1 - critical_ratio))^2)^exponent",
    source: "ISO 6358-3:2014",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: ISO 6358-1 measurements of b scatter by about 0.05.
        EffectParameter::linear("critical_ratio", "1", (0.02, 0.3, 0.7), "pressure ratio below which the flow is choked").usual_to(0.06),
        // Usual: the range that ISO 6358-3 gives for plain orifices.
        EffectParameter::linear("exponent", "1", (0.25, 0.5, 1.2), "subsonic exponent").usual_to(0.08),
    ],
    probes: &[&[0.15, 0.5], &[0.45, 0.5], &[0.3, 0.4], &[0.3, 0.65]],
    rivals: &["vent_restriction", "valve_asymmetry", "supply_sag"],
    separated_by: "filling towards the supply pressure and venting towards ambient at constant drive",
    smallest: 0.02,
    traits: &[],
    check: "the valve's data sheet (C and b), fittings in series with it",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct FlowFunctionShape<S> {
    critical_ratio: S,
    exponent: S,
}

impl<S: Scalar> FlowFunctionShape<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { critical_ratio: values[0], exponent: values[1] }
    }
}

impl<S: Scalar> Hook<S> for FlowFunctionShape<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.flow_function = Some(GeneralFlow::new(self.critical_ratio, self.exponent));
    }
}
