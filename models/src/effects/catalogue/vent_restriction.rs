//! `vent_restriction`: restriction in the exhaust.

use crate::effects::{Domain, EffectInfo, EffectParameter, Areas, Hook, Step, ValveLaw, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "vent_restriction",
    title: "Restriction in the exhaust",
    physics: "A muffler or a narrow fitting stands in series with the vent port: it costs much when the port is wide open and nothing when it is nearly closed.",
    equation: "1 / A_vent^2 = 1 / A_port^2 + 1 / A_restriction^2",
    source: "series of two restrictions in the subsonic limit, ISO 6358-3",
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
    open: S,
}

impl<S: Scalar<Real = f64>> VentRestriction<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { area_ratio: values[0], open: S::zero() }
    }
}

impl<S: Scalar<Real = f64>> Hook<S> for VentRestriction<S> {
    fn valve(&mut self, _: &Step<'_>, law: &mut ValveLaw<S>) {
        self.open = law.gain_out;
    }

    fn areas(&mut self, _: &Step<'_>, areas: &mut Areas<S>) {
        let part = areas.vent / (self.area_ratio * self.open);
        areas.vent = areas.vent / part.square().plus(1.0).sqrt();
    }
}
