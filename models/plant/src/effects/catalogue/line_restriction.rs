//! `line_restriction`: tube between valve and chamber.

use crate::effects::{DerivedSize, Domain, EffectInfo, EffectParameter, Hook, LineParameters, Question, Reach, Structure, Trait};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "line_restriction",
    title: "Tube between valve and chamber",
    physics: "A narrow tube separates the chamber from the valve, where the sensor sits: the sensor sees the tube fill first and the chamber after it.",
    equation: "V_t dp_t/dt = n R T (m_in - m_out - m_t),  V dp/dt = n R T m_t,  n R T m_t = V (sqrt(F^2 + (l/2)^2) - l/2) / tau with the flow pressure F of an orifice",
    source: "two volumes and an orifice, ISO 6358-1; the laminar part l of the loss is that of an isothermal pipe, proportional to the difference of squared pressures",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: 0.06 s: two metres of tube with 6 mm.
        EffectParameter::logarithmic("time_constant", "s", (0.0003, 0.0003, 30.0), "pressure of the chamber over its rate at a flow pressure as large").usual_to(5.3).of_load(),
        EffectParameter::logarithmic("volume_ratio", "1", (0.003, 0.02, 0.5), "volume of the tube over the chamber's"),
        EffectParameter::linear("laminar", "kPa", (0.0, 0.0, 100.0), "flow pressure below which the loss in the tube is laminar").of_load(),
    ],
    probes: &[&[0.1, 0.02, 0.0], &[0.3, 0.02, 0.0], &[1.0, 0.02, 0.0], &[0.3, 0.1, 0.0], &[0.7, 0.06, 5.0], &[3.0, 0.06, 5.0]],
    rivals: &["heat_exchange", "sensor_lag", "wall_creep"],
    separated_by: "fast steps over a wide range of pressure: at the end of a flow the reading falls back or rises",
    smallest: 0.0005,
    traits: &[Trait::FastInLoop, Trait::Derives(DerivedSize {
        name: "resistance",
        unit: "kPa s",
        meaning: "resistance: what the tube loses (its flow pressure squared) over the flow",
        of: resistance,
    }), Trait::Unnoticed(wide)],
    check: "length and bore of the tube, kinks, fittings between valve and chamber",
};

/// A usual tube, m^3: two metres with 6 mm.
const TUBE_M3: f64 = 2.0 * core::f64::consts::PI * 3e-3 * 3e-3;

/// A tube that hardly resists: gas at the temperature of its walls, in a volume that does not give
/// way.
fn wide(chamber_m3: f64) -> Vec<f64> {
    vec![0.003, (TUBE_M3 / chamber_m3).min(0.5), 0.0]
}

/// `F^2 / q = tau^2 q + tau l` at the flow `q`: a turbulent part that grows with the flow, and a
/// laminar one.
fn resistance(values: &[f64], flow_kpa_s: f64) -> f64 {
    let [time_constant_s, _, laminar_kpa] = [0, 1, 2].map(|k| values[k]);
    time_constant_s * (time_constant_s * flow_kpa_s + laminar_kpa)
}

/// The effect at work.
#[derive(Debug, Clone)]
pub struct LineRestriction<S> {
    line: LineParameters<S>,
}

impl<S: Scalar> LineRestriction<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        let [time_constant_s, volume_ratio, laminar] = [0, 1, 2].map(|k| values[k]);
        Self { line: LineParameters { time_constant_s, volume_ratio, laminar_pa: laminar.times(1e3) } }
    }
}

impl<S: Scalar> Hook<S> for LineRestriction<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        structure.line = Some(self.line);
    }
}
