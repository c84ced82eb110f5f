//! A model of one channel: the base model, effects at work, and their parameters' values.

use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{Plant, Question};
use crate::model::Parameter;

use super::correction::Correction;

/// Effects at work and their parameters' values: a model of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Extended {
    /// Numbers of the effects in the catalogue, ascending.
    pub effects: Vec<usize>,
    /// Values: the base model's parameters, then those of each effect.
    pub values: Vec<f64>,
    /// Those of the effects that are held to [what is usual on sound
    /// rigs](crate::effects::EffectParameter::usual), ascending: a part of the base model, no
    /// causes.
    pub usual: Vec<usize>,
    /// A smooth correction of what no effect explains.
    pub correction: Option<Correction>,
}

impl Extended {
    /// A base model without effects.
    #[must_use]
    pub fn base(values: Vec<f64>) -> Self {
        Self { effects: Vec::new(), values, usual: Vec::new(), correction: None }
    }

    /// The model without its correction.
    #[must_use]
    pub fn uncorrected(&self) -> Self {
        Self { correction: None, ..self.clone() }
    }

    /// Is an effect at work in any size?
    #[must_use]
    pub fn has(&self, effect: usize) -> bool {
        self.effects.contains(&effect) && !self.usual.contains(&effect)
    }

    /// Is something at work that stands for causes outside the catalogue?
    #[must_use]
    pub fn has_foil(&self) -> bool {
        let foil = |&effect: &usize| CATALOGUE[effect].question == Question::Foil;
        self.effects.iter().any(foil)
    }

    /// The model with one more effect in any size, which takes the place of the usual one where
    /// that is there.
    #[must_use]
    pub fn with(&self, plant: &Plant, effect: usize, parameters: &[f64]) -> Self {
        if let Some(range) = self.range(plant, effect) {
            let mut next = self.clone();
            next.values[range].copy_from_slice(parameters);
            next.usual.retain(|&e| e != effect);
            return next;
        }
        let position = self.effects.partition_point(|&e| e < effect);
        let base = plant.parameters().len();
        let before: usize = self.effects[..position].iter().map(|&e| CATALOGUE[e].parameters.len()).sum();
        let mut next = self.clone();
        next.effects.insert(position, effect);
        next.values.splice(base + before..base + before, parameters.iter().copied());
        next
    }

    /// The model with an effect that is held to what is usual; it begins with nothing.
    #[must_use]
    pub fn with_usual(&self, plant: &Plant, effect: usize) -> Self {
        let nulls: Vec<f64> = CATALOGUE[effect].parameters.iter().map(|p| p.null).collect();
        let mut next = self.with(plant, effect, &nulls);
        next.usual.push(effect);
        next.usual.sort_unstable();
        next
    }

    /// The model without one of its effects; what belongs to the base model becomes usual again.
    #[must_use]
    pub fn without(&self, plant: &Plant, effect: usize) -> Self {
        if CATALOGUE[effect].in_base(plant) {
            return self.with_usual(plant, effect);
        }
        let mut next = self.clone();
        if let Some(range) = self.range(plant, effect) {
            next.values.drain(range);
            next.effects.retain(|&e| e != effect);
        }
        next
    }

    /// Where the values of one effect are.
    #[must_use]
    pub fn range(&self, plant: &Plant, effect: usize) -> Option<std::ops::Range<usize>> {
        let mut at = plant.parameters().len();
        for &e in &self.effects {
            let next = at + CATALOGUE[e].parameters.len();
            if e == effect {
                return Some(at..next);
            }
            at = next;
        }
        None
    }

    /// All parameters, in the order of the values.
    #[must_use]
    pub fn parameters(&self, plant: &Plant) -> Vec<Parameter> {
        let mut list = plant.parameters();
        for p in list.iter_mut().filter(|p| p.name.starts_with("threshold")) {
            (p.lower, p.upper) = (p.lower.max(-SETTINGS.widest_edge), p.upper.min(SETTINGS.widest_edge));
        }
        for &e in &self.effects {
            let usual = self.usual.contains(&e);
            list.extend(CATALOGUE[e].parameters.iter().map(|p| (p, p.bounds(usual))).map(|(p, bounds)| {
                Parameter {
                    name: format!("{}.{}", CATALOGUE[e].id, p.name),
                    unit: p.unit,
                    lower: bounds.0,
                    upper: bounds.1,
                    nominal: p.null,
                    scale: p.scale,
                    meaning: p.meaning,
                }
            }));
        }
        list
    }
}
