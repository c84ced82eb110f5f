//! `vent_restriction`: restriction in the exhaust.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Structure, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "vent_restriction",
    title: "Restriction in the exhaust",
    physics: "A muffler or a narrow fitting stands behind the vent port: pressure builds up before it when the port is wide open, and nothing when it is nearly closed.",
    equation: "A_port psi(p_m / p) p = A_restriction psi(p_ambient / p_m) p_m, solved for p_m",
    source: "two orifices in series, ISO 6358-3",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::logarithmic("area_ratio", "1", (0.1, 30.0, 30.0), "area of the restriction over the vent port's at full drive"),
    ],
    probes: &[&[0.5], &[0.9], &[1.6], &[3.0]],
    rivals: &["valve_asymmetry", "drive_saturation", "flow_function"],
    separated_by: "venting from high pressure at small and at full drive",
    smallest: 0.05,
    check: "muffler, exhaust fitting and tube: take them off and compare",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct VentRestriction<S> {
    area_ratio: S,
}

impl<S: Scalar<Real = f64>> VentRestriction<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { area_ratio: values[0] }
    }
}

impl<S: Scalar<Real = f64>> Hook<S> for VentRestriction<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.outlet = Some(self.area_ratio);
    }
}
