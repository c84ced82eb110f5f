//! Explanations of a recording with their probabilities.

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::discrepancy::{Rest, corrected};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::evidence::{Explanation, Missing, Weighed, weigh};
use crate::diagnosis::json::{Alternative, Report};
use crate::diagnosis::selection::{Found, Outcome};
use crate::effects::catalogue::CATALOGUE;

/// Explanations that are listed.
const LISTED: usize = 8;
/// Explanations less probable than this are not listed.
pub const LEAST_PROBABLE: f64 = 0.001;

/// Weighs all explanations that a search has fitted, and beside them nothing at all and something smooth without a name; the most
/// probable comes first. An effect in a size that sound rigs have is no cause: with it, nothing is missing. Since a calibration (`change`),
/// every size counts.
#[must_use]
pub fn weighed(channels: &[ChannelData], outcome: &Outcome, rest: &Rest, change: bool) -> Vec<Weighed> {
    let models =
        |stages: &[ChannelStage]| -> Vec<Extended> { stages.iter().map(|s| s.model.clone()).collect() };
    let named: Vec<usize> = outcome.causes.iter().map(|cause| cause.effect).collect();
    let mut all = outcome.explanations.clone();
    all.push(Explanation { missing: Missing::Nothing, models: outcome.base.clone() });
    all.extend(smooth(Vec::new(), corrected(channels, &rest.base_stages, &rest.symptoms)));
    if !named.is_empty() {
        all.push(Explanation { missing: Missing::Effects(named.clone()), models: models(&outcome.stages) });
        all.extend(smooth(named, corrected(channels, &outcome.stages, &rest.left)));
        all.extend(outcome.causes.iter().map(|cause| without(cause, outcome)));
    }
    if !change {
        for explanation in &mut all {
            explanation.missing.retain(|effect| is_beyond_usual(channels, &explanation.models, effect));
        }
    }
    weigh(channels, all)
}

/// Is an effect, on some channel, larger than on sound rigs? One is for which nothing says how large that is.
fn is_beyond_usual(channels: &[ChannelData], models: &[Extended], effect: usize) -> bool {
    let info = CATALOGUE[effect];
    let told = || info.parameters.iter().enumerate().filter(|(_, p)| p.usual.is_finite());
    let beyond = |(data, model): (&ChannelData, &Extended)| {
        let range = model.range(&data.plant, effect).filter(|_| model.has(effect));
        range.is_some_and(|range| {
            let values = &model.values[range];
            told().next().is_none() || told().any(|(k, p)| p.distance(values[k]) > p.usual)
        })
    };
    channels.iter().zip(models).any(beyond)
}

/// A smooth correction beside some effects, where there is one.
fn smooth(effects: Vec<usize>, models: Vec<Extended>) -> Option<Explanation> {
    let any = models.iter().any(|model| model.correction.is_some());
    any.then_some(Explanation { missing: Missing::SomethingElse(effects), models })
}

/// All that is named but one cause.
fn without(cause: &Found, outcome: &Outcome) -> Explanation {
    let others: Vec<usize> = outcome.causes.iter().map(|c| c.effect).filter(|e| *e != cause.effect).collect();
    let missing = if others.is_empty() { Missing::Nothing } else { Missing::Effects(others) };
    Explanation { missing, models: cause.without.clone() }
}

impl Report {
    /// Takes over the probabilities of explanations, and of each cause that of all explanations with it.
    pub fn weigh(&mut self, weighed: &[Weighed]) {
        if weighed.is_empty() {
            return;
        }
        self.alternatives = listed(weighed.iter().map(|w| (&w.missing, w.probability, w.select_rmse_kpa)));
        for cause in &mut self.causes {
            let with = |w: &&Weighed| w.missing.effects().iter().any(|&e| CATALOGUE[e].id == cause.effect);
            cause.probability =
                Some(weighed.iter().filter(with).fold(0.0, |sum, w| sum + w.probability).min(1.0));
        }
    }
}

/// Those that are worth a line.
#[must_use]
pub fn listed<'a>(weighed: impl IntoIterator<Item = (&'a Missing, f64, f64)>) -> Vec<Alternative> {
    let worth = weighed.into_iter().filter(|(_, probability, _)| *probability >= LEAST_PROBABLE);
    worth
        .take(LISTED)
        .map(|(missing, probability, select_rmse_kpa)| Alternative {
            causes: missing.ids(),
            probability,
            select_rmse_kpa,
        })
        .collect()
}
