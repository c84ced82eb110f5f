//! Explanations of one recording, and their probabilities.

use super::predicted::{Evidence, Predicted};
use super::weights::probabilities;
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::order::descending;
use crate::parallel;

/// What may be missing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Missing {
    /// Nothing.
    Nothing,
    /// Something that depends on one measured variable, beside some effects; without a name.
    SomethingElse(Vec<usize>),
    /// Effects of the catalogue, in the order in which they were found.
    Effects(Vec<usize>),
}

impl Missing {
    /// Effects of the catalogue in it.
    #[must_use]
    pub fn effects(&self) -> &[usize] {
        match self {
            Self::Nothing => &[],
            Self::SomethingElse(effects) | Self::Effects(effects) => effects,
        }
    }

    /// Leaves away effects that do not count.
    pub fn retain(&mut self, counts: impl Fn(usize) -> bool) {
        if let Self::SomethingElse(effects) | Self::Effects(effects) = self {
            effects.retain(|&effect| counts(effect));
        }
        if matches!(self, Self::Effects(effects) if effects.is_empty()) {
            *self = Self::Nothing;
        }
    }

    /// Does another hold the same to be missing, in whatever order it was found?
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        let sorted = |missing: &Self| {
            let mut effects = missing.effects().to_vec();
            effects.sort_unstable();
            (matches!(missing, Self::SomethingElse(_)), effects)
        };
        sorted(self) == sorted(other)
    }

    /// Ids, as reports have them.
    #[must_use]
    pub fn ids(&self) -> Vec<String> {
        let named = self.effects().iter().map(|&e| CATALOGUE[e].id.to_owned());
        match self {
            Self::Nothing => vec!["none".to_owned()],
            Self::SomethingElse(_) => named.chain(["something_else".to_owned()]).collect(),
            Self::Effects(_) => named.collect(),
        }
    }
}

/// An explanation with its models.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// What it holds to be missing.
    pub missing: Missing,
    /// Models, channel by channel.
    pub models: Vec<Extended>,
}

/// An explanation with what it is worth.
#[derive(Debug, Clone)]
pub struct Weighed {
    /// What it holds to be missing.
    pub missing: Missing,
    /// Its probability. Those of all that were weighed leave room for what was not fitted.
    pub probability: f64,
    /// RMS error of rollouts over the blocks where causes are chosen, kPa.
    pub select_rmse_kpa: f64,
}

/// What the models of a recording's channels are worth together, block by block.
#[must_use]
pub fn evidence(channels: &[ChannelData], models: &[Extended]) -> Evidence {
    let of = |(data, model): (&ChannelData, &Extended)| Predicted::of(data, model).by_block();
    Evidence::together(&channels.iter().zip(models).map(of).collect::<Vec<_>>())
}

/// Weighs explanations of a recording by how well they predict the blocks where causes are chosen;
/// the most probable comes first. Of several with the same causes that counts which predicts best.
#[must_use]
pub fn weigh(channels: &[ChannelData], explanations: Vec<Explanation>) -> Vec<Weighed> {
    let mut best: Vec<(Missing, Evidence)> = Vec::new();
    let evidences: Vec<Evidence> = parallel::map(explanations.iter(), |e| evidence(channels, &e.models));
    for (Explanation { missing, .. }, evidence) in explanations.into_iter().zip(evidences) {
        if !evidence.log_density().is_finite() {
            continue;
        }
        match best.iter_mut().find(|(known, _)| known.is_same(&missing)) {
            Some((_, known)) if known.log_density() >= evidence.log_density() => {}
            Some((_, known)) => *known = evidence,
            None => best.push((missing, evidence)),
        }
    }
    let evidences: Vec<&Evidence> = best.iter().map(|(_, evidence)| evidence).collect();
    let probable = probabilities(&evidences);
    let mut weighed: Vec<Weighed> = best
        .into_iter()
        .zip(probable)
        .map(|((missing, evidence), probability)| Weighed {
            missing,
            probability: (1.0 - SETTINGS.not_fitted) * probability,
            select_rmse_kpa: evidence.rmse_kpa(),
        })
        .collect();
    descending(&mut weighed, |item| item.probability);
    weighed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, measured, with};
    use crate::effects::catalogue::index_of;

    #[test]
    fn what_was_there_is_probable_and_of_equal_explanations_the_better_counts() {
        let (data, base) = channel(false);
        let lag = index_of("valve_lag").unwrap();
        let truth = with(&data, &base, "valve_lag", &[0.02]);
        let other = with(&data, &base, "valve_lag", &[0.05]);
        let data = measured(data, &truth, 4);
        let explanation =
            |missing: Missing, model: &Extended| Explanation { missing, models: vec![model.clone()] };
        let all = vec![
            explanation(Missing::Nothing, &base),
            explanation(Missing::Effects(vec![lag]), &other),
            explanation(Missing::Effects(vec![lag]), &truth),
        ];
        let weighed = weigh(std::slice::from_ref(&data), all);
        assert_eq!(weighed.len(), 2, "{weighed:?}");
        assert_eq!(weighed[0].missing, Missing::Effects(vec![lag]));
        assert!(weighed[0].probability > 0.89, "{weighed:?}");
        assert!((weighed[0].select_rmse_kpa / data.noise_kpa - 1.0).abs() < 0.2, "{weighed:?}");
        let all: f64 = weighed.iter().map(|w| w.probability).sum();
        assert!((all + SETTINGS.not_fitted - 1.0).abs() < 1e-9, "{weighed:?}");
    }

    #[test]
    fn sets_are_the_same_in_any_order_and_empty_ones_are_nothing() {
        let mut pair = Missing::Effects(vec![3, 1]);
        assert!(pair.is_same(&Missing::Effects(vec![1, 3])));
        assert!(!pair.is_same(&Missing::SomethingElse(vec![1, 3])));
        pair.retain(|effect| effect == 1);
        assert_eq!(pair, Missing::Effects(vec![1]));
        pair.retain(|_| false);
        assert_eq!(pair, Missing::Nothing);
        let mut smooth = Missing::SomethingElse(vec![1]);
        smooth.retain(|_| false);
        assert_eq!(smooth, Missing::SomethingElse(Vec::new()));
    }
}
