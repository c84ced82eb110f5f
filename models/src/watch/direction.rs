//! What can change: the effects of the catalogue that are watched for, each with the size of its
//! probe.

use crate::diagnosis::Extended;
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{Domain, EffectInfo, EffectParameter, Plant, Question};
use crate::model::Scale;

/// An effect that is watched for.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Number in the catalogue.
    pub effect: usize,
    /// First parameter in the calibrated model.
    from: f64,
    /// First parameter of the probe.
    to: f64,
    /// The model with the probe.
    pub model: Extended,
}

/// All effects that make sense for a plant, each beside its calibrated model.
pub fn directions(plant: &Plant, model: &Extended) -> Vec<Direction> {
    (0..CATALOGUE.len()).filter_map(|effect| direction(plant, model, effect)).collect()
}

fn direction(plant: &Plant, model: &Extended, effect: usize) -> Option<Direction> {
    let info = CATALOGUE[effect];
    let fits = match info.domain {
        Domain::Valve => !plant.model.is_regulator(),
        Domain::Regulator => plant.model.is_regulator(),
        Domain::Both => true,
    };
    if !fits || info.question == Question::Foil || !info.lasts() {
        return None;
    }
    let probe = info.probes.first()?;
    let now: Vec<f64> = match model.range(plant, effect) {
        Some(range) => model.values[range].to_vec(),
        None => info.parameters.iter().map(|p| p.null).collect(),
    };
    let present = model.effects.contains(&effect);
    let mut tried: Vec<f64> = probe.to_vec();
    if present {
        // Only its size: a time constant that was calibrated stays.
        tried.clone_from(&now);
        tried[0] = moved(&info.parameters[0], now[0], probe[0]);
    }
    let model = model.with(plant, effect, &tried);
    Some(Direction { effect, from: now[0], to: tried[0], model })
}

/// As far from a value as a probe is from nothing, to the other side where that is beyond the
/// range.
fn moved(parameter: &EffectParameter, value: f64, probe: f64) -> f64 {
    let to = match parameter.scale {
        Scale::Linear => [value + (probe - parameter.null), value - (probe - parameter.null)],
        Scale::Logarithmic => [value * probe / parameter.null, value * parameter.null / probe],
    };
    let within = |v: &f64| (parameter.lower..=parameter.upper).contains(v);
    to.into_iter().find(within).unwrap_or(value)
}

impl Direction {
    /// What the catalogue says about it.
    pub fn info(&self) -> &'static EffectInfo {
        CATALOGUE[self.effect]
    }

    /// Value of the first parameter so many probes away.
    pub fn size(&self, probes: f64) -> f64 {
        let parameter = &self.info().parameters[0];
        let value = match parameter.scale {
            Scale::Linear => self.from + probes * (self.to - self.from),
            Scale::Logarithmic => self.from * (self.to / self.from).powf(probes),
        };
        value.clamp(parameter.lower, parameter.upper)
    }

    /// Does a change of so many probes, on top of what is usual, leave the parameter's range? A
    /// leak has no negative area, but one that has become usual can be mended.
    pub fn is_beyond(&self, probes: f64, usual: f64) -> bool {
        let parameter = &self.info().parameters[0];
        let at_bound = |bound: f64| (self.from - bound).abs() <= 1e-9 * (self.to - self.from).abs();
        let step = self.to - self.from;
        let room = usual * step;
        (probes * step < -room.max(0.0) && at_bound(parameter.lower))
            || (probes * step > (-room).max(0.0) && at_bound(parameter.upper))
    }

    /// Is a change of so many probes large enough to be worth a word?
    pub fn is_worth(&self, probes: f64) -> bool {
        let parameter = &self.info().parameters[0];
        let far = match parameter.scale {
            Scale::Linear => (probes * (self.to - self.from)).abs(),
            Scale::Logarithmic => (probes * (self.to / self.from).ln()).abs(),
        };
        far >= self.info().smallest
    }
}
