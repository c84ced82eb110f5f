//! Explanations of a recording with their probabilities.

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::discrepancy::{Rest, corrected};
use crate::diagnosis::estimation::models_of;
use crate::diagnosis::evidence::{Explanation, Missing, Weighed, weigh};
use crate::diagnosis::json::{Alternative, Imperfection, Report, Unnamed, Verdict};
use crate::diagnosis::selection::{Candidate, Found, Outcome, is_shown};
use crate::effects::catalogue::CATALOGUE;
use crate::order::descending;

use super::earned::LEAST_PROBABLE;
use super::probable::{by_names, part, probability_of};

/// Explanations that are listed.
const LISTED: usize = 8;

/// Weighs all explanations that a search has fitted, and beside them nothing at all and something
/// smooth without a name; the most probable comes first. An effect in a size that sound rigs have
/// is no cause: with it, nothing is missing. Since a calibration (`change`), every size counts.
#[must_use]
pub fn weighed(channels: &[ChannelData], outcome: &Outcome, rest: &Rest, change: bool) -> Vec<Weighed> {
    let named: Vec<usize> = outcome.causes.iter().map(|cause| cause.effect).collect();
    let mut all = outcome.explanations.clone();
    all.push(Explanation { missing: Missing::Nothing, models: outcome.base.clone() });
    all.extend(smooth(Vec::new(), corrected(channels, &rest.base_stages, &rest.symptoms)));
    if !named.is_empty() {
        all.push(Explanation {
            missing: Missing::Effects(named.clone()),
            models: models_of(&outcome.stages),
        });
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

/// Is an effect, on some channel, larger than on sound rigs? One is for which nothing says how
/// large that is.
fn is_beyond_usual(channels: &[ChannelData], models: &[Extended], effect: usize) -> bool {
    let info = CATALOGUE[effect];
    let told = || info.parameters.iter().enumerate().filter(|(_, p)| p.usual.is_finite());
    let beyond = |(data, model): (&ChannelData, &Extended)| {
        let range = model.range(&data.plant, effect).filter(|_| model.has(effect));
        range.is_some_and(|range| {
            let values = &model.values[range];
            told().next().is_none()
                || told().any(|(k, p)| p.distance(values[k]) > p.unsuspicious(data.inputs.in_loop()))
        })
    };
    channels.iter().zip(models).any(beyond)
}

/// Effects that were found, in place of which something that sound rigs have does as well: then
/// nothing need be missing, unless the rows show it.
#[must_use]
pub fn tied_with_the_usual(channels: &[ChannelData], causes: &[Found]) -> Vec<&'static str> {
    let usual = |rival: &Candidate| !is_beyond_usual(channels, &rival.models, rival.effect);
    let tied = causes.iter().filter(|c| c.rivals.iter().any(usual) && !is_shown(channels, c.effect));
    tied.map(|c| CATALOGUE[c.effect].id).collect()
}

/// A smooth correction beside some effects, where there is one.
fn smooth(effects: Vec<usize>, models: Vec<Extended>) -> Option<Explanation> {
    let any = models.iter().any(|model| model.correction.is_some());
    any.then_some(Explanation { missing: Missing::SomethingElse(effects), models })
}

/// All that is named but one cause.
fn without(cause: &Found, outcome: &Outcome) -> Explanation {
    let others: Vec<usize> = outcome.causes.iter().map(|c| c.effect).filter(|e| *e != cause.effect).collect();
    let foil = cause.without.iter().any(Extended::has_foil);
    let missing = match others.is_empty() {
        true if foil => Missing::SomethingElse(others),
        true => Missing::Nothing,
        false => Missing::Effects(others),
    };
    Explanation { missing, models: cause.without.clone() }
}

impl Report {
    /// Takes over the probabilities of explanations, and of each cause that of all explanations
    /// with it; `looped`: no drive was recorded.
    pub fn weigh(&mut self, weighed: &[Weighed], looped: bool) {
        if weighed.is_empty() {
            return;
        }
        let (named, improbable) = part(std::mem::take(&mut self.causes), weighed, looped);
        self.causes = named;
        let unnamed = |cause| Imperfection { why: Unnamed::Improbable, cause };
        self.imperfections.extend(improbable.into_iter().map(unnamed));
        let weighed = by_names(weighed, &self.causes);
        for cause in &mut self.causes {
            cause.probability = Some(probability_of(std::slice::from_ref(&cause.effect), &weighed));
        }
        let weighed = match self.verdict {
            Verdict::Unexplained => without_a_name(&weighed),
            _ => weighed,
        };
        self.alternatives = listed(weighed.iter().map(|w| (&w.missing, w.probability, w.select_rmse_kpa)));
    }
}

/// Where the error itself says that something is missing, "nothing" is something without a name.
fn without_a_name(weighed: &[Weighed]) -> Vec<Weighed> {
    let mut others: Vec<Weighed> = Vec::new();
    let mut unnamed: Option<Weighed> = None;
    for one in weighed {
        match (&one.missing, &mut unnamed) {
            (Missing::Nothing, Some(all)) => all.probability += one.probability,
            (Missing::SomethingElse(effects), Some(all)) if effects.is_empty() => {
                all.probability += one.probability;
            }
            (Missing::Nothing, None) => {
                unnamed = Some(Weighed { missing: Missing::SomethingElse(Vec::new()), ..one.clone() });
            }
            (Missing::SomethingElse(effects), None) if effects.is_empty() => unnamed = Some(one.clone()),
            _ => others.push(one.clone()),
        }
    }
    others.extend(unnamed);
    descending(&mut others, |item| item.probability);
    others
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::estimation::ChannelStage;
    use crate::diagnosis::testing::{channel, with, with_repeated_readings};
    use crate::effects::catalogue::index_of;

    #[test]
    fn a_size_that_sound_rigs_have_is_no_cause_unless_a_channel_has_more() {
        let (data, base) = channel(false);
        let asymmetry = index_of("valve_asymmetry").unwrap();
        let of = |ratio: f64| with(&data, &base, "valve_asymmetry", &[ratio]);
        let channels = [data.clone(), data.clone()];
        let beyond = |models: [Extended; 2]| is_beyond_usual(&channels, &models, asymmetry);
        assert!(!beyond([of(0.95), of(1.05)]) && !beyond([base.clone(), base.clone()]));
        assert!(beyond([of(0.95), of(0.7)]) && beyond([base.clone(), of(1.4)]));
    }

    #[test]
    fn what_ties_with_a_size_that_sound_rigs_have_is_told_unless_rows_show_it() {
        let (data, base) = channel(true);
        let tied = |data: &ChannelData, effect: &str, rival: &str, size: f64| {
            let stage = ChannelStage::new(data, base.clone(), Vec::new());
            let of = |id: &str, size: f64| Candidate {
                effect: index_of(id).unwrap(),
                models: vec![with(data, &base, id, &[size])],
                acts: vec![true],
                losses: vec![stage.losses.clone()],
            };
            let (channels, ranked) = (std::slice::from_ref(data), [of(effect, 0.3), of(rival, size)]);
            let found = Found::new(channels, std::slice::from_ref(&stage), &ranked, 0, &[1], 0.01);
            tied_with_the_usual(channels, &[found])
        };
        let beside = |size| tied(&data, "valve_hysteresis", "valve_asymmetry", size);
        assert_eq!(beside(0.95), ["valve_hysteresis"]);
        assert!(beside(0.7).is_empty(), "sound rigs have no such asymmetry");
        let shown = with_repeated_readings(data.clone());
        assert!(tied(&shown, "stale_samples", "valve_asymmetry", 0.95).is_empty());
        assert!(tied(&data, "valve_hysteresis", "supply_misstated", -0.1).is_empty(), "no effect but a foil");
    }

    #[test]
    fn nothing_is_something_without_a_name_where_the_error_says_so() {
        let [lag, delay] = ["valve_lag", "transport_delay"].map(|id| index_of(id).unwrap());
        let weighed = [
            (Missing::Effects(vec![lag]), 0.45),
            (Missing::Nothing, 0.3),
            (Missing::SomethingElse(Vec::new()), 0.2),
            (Missing::SomethingElse(vec![delay]), 0.05),
        ]
        .map(|(missing, probability)| Weighed { missing, probability, select_rmse_kpa: 1.0 });
        let named = without_a_name(&weighed);
        let told: Vec<_> =
            named.iter().map(|w| (w.missing.ids().join("+"), (100.0 * w.probability).round())).collect();
        let expected =
            [("something_else", 50.0), ("valve_lag", 45.0), ("transport_delay+something_else", 5.0)];
        assert_eq!(told, expected.map(|(ids, percent)| (ids.to_owned(), percent)));
    }

    #[test]
    fn a_cause_is_as_probable_as_all_that_has_it_and_what_is_improbable_is_not_listed() {
        let [lag, delay] = ["valve_lag", "transport_delay"].map(|id| index_of(id).unwrap());
        let weighed = [
            (Missing::Effects(vec![lag, delay]), 0.6),
            (Missing::SomethingElse(vec![lag]), 0.3),
            (Missing::Nothing, 0.0996),
            (Missing::Effects(vec![delay]), 0.0004),
        ]
        .map(|(missing, probability)| Weighed { missing, probability, select_rmse_kpa: 1.0 });
        assert!((probability_of(&["valve_lag".to_owned()], &weighed) - 0.9).abs() < 1e-12);
        assert_eq!(probability_of(&["supply_sag".to_owned()], &weighed).to_bits(), 0.0_f64.to_bits());
        let listed = listed(weighed.iter().map(|w| (&w.missing, w.probability, w.select_rmse_kpa)));
        let causes: Vec<_> = listed.iter().map(|a| a.causes.join("+")).collect();
        assert_eq!(causes, ["valve_lag+transport_delay", "valve_lag+something_else", "none"]);
    }
}
