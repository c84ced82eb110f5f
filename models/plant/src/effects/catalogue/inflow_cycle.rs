//! `inflow_cycle`: what flows in swings with a period, whatever the supply pressure does. Never
//! named.

use core::f64::consts::TAU;

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Question, Reach, Step, Trait, Wave};
use crate::model::Areas;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "inflow_cycle",
    title: "Inflow swings by itself",
    physics: "What flows into the chamber swings with a period by the same part at every pressure, as under a supply whose air gets warmer and colder. A supply pressure that cycles acts more where the chamber's pressure is close to it.",
    equation: "A_in = A (1 + amplitude sin(2 pi (t / period + phase)))",
    source: "choked flow grows with the root of the temperature, ISO 6358-1",
    question: Question::Foil,
    domain: Domain::Valve,
    reach: Reach::Rig,
    parameters: &[
        EffectParameter::linear("amplitude", "1", (0.0, 0.0, 0.5), "half of the swing, as a part of the flow"),
        EffectParameter::logarithmic("period", "s", (0.3, 8.0, 600.0), "period"),
        EffectParameter::linear("phase", "1", (-1.0, 0.0, 2.0), "phase at the start, in periods"),
    ],
    probes: &[],
    rivals: &["supply_ripple"],
    separated_by: "a recorded supply pressure; without it, fills close to the supply's pressure over several periods",
    smallest: 0.002,
    traits: &[Trait::Periodic(probes)],
    check: "a thermometer in the supply line",
};

/// The cycle that a wave is.
fn probes(wave: &Wave) -> Vec<Vec<f64>> {
    let phase = (wave.cosine.atan2(wave.sine) / TAU).rem_euclid(1.0);
    vec![vec![wave.share().clamp(0.002, 0.4), wave.period_s(), phase]]
}

/// The effect at work.
#[derive(Debug, Clone)]
pub struct InflowCycle<S> {
    amplitude: S,
    period: S,
    phase: S,
}

impl<S: Scalar> InflowCycle<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { amplitude: values[0], period: values[1], phase: values[2] }
    }
}

impl<S: Scalar> Hook<S> for InflowCycle<S> {
    #[inline(always)]
    fn areas(&mut self, step: &Step<'_>, areas: &mut Areas<S>) {
        let angle = (self.period.recip().times(step.time_s) + self.phase).times(std::f64::consts::TAU);
        areas.fill = areas.fill * (self.amplitude * angle.sin()).plus(1.0);
    }
}
