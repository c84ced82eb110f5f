//! `vent_restriction`: restriction in the exhaust.

use crate::effects::{
    Domain, EffectInfo, EffectParameter, Hook, OutletParameters, Structure, Question, Reach, Trait,
};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "vent_restriction",
    title: "Restriction in the exhaust",
    physics: "A muffler or a narrow fitting stands behind the vent port: pressure builds up before it when the port is wide open, and nothing when it is nearly closed. The space before it fills within milliseconds.",
    equation: "V_m dp_m/dt = R T (m_port(p, p_m) - m_restriction(p_m, p_ambient))",
    source: "two orifices in series (ISO 6358-3) with a volume at constant temperature between them",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: twice the port, which takes 10 % of the flow.
        EffectParameter::logarithmic("area_ratio", "1", (0.1, 30.0, 30.0), "area of the restriction over the vent port's at full drive").usual_to(2.68),
        EffectParameter::logarithmic("volume_ratio", "1", (0.001, 0.01, 0.3), "volume before the restriction over the chamber's"),
    ],
    probes: &[&[0.5, 0.01], &[0.9, 0.01], &[1.6, 0.01], &[3.0, 0.01]],
    rivals: &["valve_asymmetry", "drive_saturation", "flow_function"],
    separated_by: "venting from high pressure at small and at full drive",
    smallest: 0.05,
    traits: &[Trait::FastInLoop],
    check: "muffler, exhaust fitting and tube: take them off and compare",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct VentRestriction<S> {
    outlet: OutletParameters<S>,
}

impl<S: Scalar> VentRestriction<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { outlet: OutletParameters { area_ratio: values[0], volume_ratio: values[1] } }
    }
}

impl<S: Scalar> Hook<S> for VentRestriction<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.outlet = Some(self.outlet);
    }
}
