//! `line_restriction`: tube between valve and chamber.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Structure, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "line_restriction",
    title: "Tube between valve and chamber",
    physics: "A narrow tube separates the chamber from the valve, where the sensor sits: the sensor sees the tube fill first and the chamber after it.",
    equation: "V_t dp_t/dt = n R T (m_in - m_out - m_t),  V dp/dt = n R T m_t,  m_t through an orifice",
    source: "two volumes and an orifice, ISO 6358-1",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::logarithmic("area_ratio", "1", (0.1, 30.0, 30.0), "area of the tube over the fill port's at full drive"),
        EffectParameter::logarithmic("volume_ratio", "1", (0.003, 0.02, 0.3), "volume of the tube over the chamber's"),
    ],
    probes: &[&[4.0, 0.02], &[1.5, 0.02], &[0.6, 0.02], &[1.5, 0.1]],
    rivals: &["heat_exchange", "sensor_lag", "wall_creep"],
    separated_by: "fast steps over a wide range of pressure: at the end of a flow the reading falls back or rises",
    smallest: 0.05,
    check: "length and bore of the tube, kinks, fittings between valve and chamber",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct LineRestriction<S> {
    area_ratio: S,
    volume_ratio: S,
}

impl<S: Scalar> LineRestriction<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { area_ratio: values[0], volume_ratio: values[1] }
    }
}

impl<S: Scalar> Hook<S> for LineRestriction<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.line = Some((self.area_ratio, self.volume_ratio));
    }
}
