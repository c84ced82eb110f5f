//! `supply_ripple`: supply cycles by itself.

use core::f64::consts::{PI, TAU};

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach, Trait, Wave};
use crate::model::Areas;
use crate::numeric::{Real, Scalar};

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "supply_ripple",
    title: "Supply cycles by itself",
    physics: "A compressor switches on and off: the supply rises while it runs and falls while it rests, whatever the channels do.",
    equation: "p_s = p_nominal + amplitude triangle(t / period + phase), rising for a part `rise` of the period",
    source: "pressure switch of a compressor",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Rig,
    parameters: &[
        // Usual: 1 % of the supply: a good regulator.
        EffectParameter::linear("amplitude", "kPa", (0.0, 0.0, 300.0), "half of the swing").usual_to(4.0),
        EffectParameter::logarithmic("period", "s", (0.3, 8.0, 600.0), "period"),
        EffectParameter::linear("phase", "1", (-1.0, 0.0, 2.0), "phase at the start, in periods"),
        EffectParameter::linear("rise", "1", (0.1, 0.5, 0.9), "part of the period in which it rises"),
    ],
    probes: &[],
    rivals: &["supply_sag", "valve_wear"],
    separated_by: "the same movements repeated over several periods; better, record the supply",
    smallest: 1.0,
    traits: &[Trait::Periodic(probes)],
    check: "the compressor's pressure switch; a regulator after the tank",
};

/// Parts of a period in which the supply rises that are tried.
const RISES: [f64; 2] = [0.3, 0.7];

/// Triangles whose first harmonic is a wave.
fn probes(wave: &Wave) -> Vec<Vec<f64>> {
    let amplitude_kpa = (wave.share() * wave.gauge_pa * 1e-3 * PI * PI / 8.0).clamp(0.5, 250.0);
    // cos(w t) c + sin(w t) s peaks at phase peak; the triangle's first harmonic peaks at rise /
    // 2 + 1 / 4.
    let peak = wave.sine.atan2(wave.cosine) / TAU;
    let phase = |rise: f64| (0.25 + 0.5 * rise - peak).rem_euclid(1.0);
    RISES.iter().map(|&rise| vec![amplitude_kpa, wave.period_s(), phase(rise), rise]).collect()
}

/// The effect at work.
#[derive(Debug, Clone)]
pub struct SupplyRipple<S> {
    amplitude: S,
    period: S,
    phase: S,
    rise: S,
}

impl<S: Scalar> SupplyRipple<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { amplitude: values[0], period: values[1], phase: values[2], rise: values[3] }
    }
}

impl<S: Scalar> Hook<S> for SupplyRipple<S> {
    #[inline(always)]
    fn supply(&mut self, step: &Step<'_>, supply: S, _: &Areas<S>, _: S) -> S {
        let phase = self.period.recip().times(step.time_s) + self.phase;
        let phase = phase.shift(-phase.real().floor());
        let up = (phase / self.rise).times(2.0).plus(-1.0);
        let down = ((phase - self.rise) / (-self.rise).plus(1.0)).times(-2.0).plus(1.0);
        let wave = S::select(phase.less(self.rise), up, down);
        supply + (self.amplitude * wave).times(1e3)
    }
}
