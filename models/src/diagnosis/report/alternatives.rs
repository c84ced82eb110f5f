//! Explanations of a recording with their probabilities.

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::discrepancy::{Rest, corrected};
use crate::diagnosis::estimation::models_of;
use crate::diagnosis::evidence::{Explanation, Missing, Weighed, weigh};
use crate::diagnosis::json::{Alternative, Cause, Imperfection, Report, Unnamed, Verdict};
use crate::diagnosis::selection::{Found, Outcome, is_shown};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::order::descending;

use super::earned::hunts;

/// Explanations that are listed.
const LISTED: usize = 8;
/// Explanations less probable than this are not listed, and no cause among them has a name.
pub const LEAST_PROBABLE: f64 = 0.001;
/// What is at least as probable is more so than not.
pub const EVEN: f64 = 0.5;

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

/// Probabilities that heed the names, too: the tests for them are evidence besides how well
/// explanations predict. Sets with a cause that got no name count less, the others take what they
/// lose.
fn by_names(weighed: &[Weighed], causes: &[Cause]) -> Vec<Weighed> {
    let named = |effect: &usize| {
        let id = CATALOGUE[*effect].id;
        causes.iter().any(|cause| cause.effect == id || cause.equivalent.iter().any(|tie| tie == id))
    };
    let mut heeded = weighed.to_vec();
    for one in &mut heeded {
        if !one.missing.effects().iter().all(named) {
            one.probability *= SETTINGS.unnamed;
        }
    }
    let sum = |all: &[Weighed]| all.iter().map(|w| w.probability).sum::<f64>();
    let scale = sum(weighed) / sum(&heeded).max(f64::MIN_POSITIVE);
    heeded.iter_mut().for_each(|one| one.probability *= scale);
    descending(&mut heeded, |item| item.probability);
    heeded
}

/// Parts causes into those that keep their names and those that are less probable than not beside
/// one that is more. Of what makes a loop hunt (`looped`) its own likelihood has told already, and
/// what rollouts predict tells little: none is in step with the recording.
fn part(causes: Vec<Cause>, weighed: &[Weighed], looped: bool) -> (Vec<Cause>, Vec<Cause>) {
    let probable = |cause: &Cause| looped && hunts(cause) || probability(cause, weighed) >= EVEN;
    let any = causes.iter().any(probable);
    causes.into_iter().partition(|cause| probable(cause) || !any)
}

/// How probable a cause is, counted with what fits as well; 1 where nothing was weighed.
#[must_use]
pub fn probability(cause: &Cause, weighed: &[Weighed]) -> f64 {
    let ties: Vec<String> = cause.equivalent.iter().chain([&cause.effect]).cloned().collect();
    if weighed.is_empty() { 1.0 } else { probability_of(&ties, weighed) }
}

/// Was something found, and is none of it, counted with what fits as well, worth a line? What the
/// rows show is.
#[must_use]
pub fn all_improbable(channels: &[ChannelData], found: &[Found], weighed: &[Weighed]) -> bool {
    let improbable = |cause: &Found| {
        let effects = cause.equivalent.iter().chain([&cause.effect]);
        let ids: Vec<String> = effects.map(|&effect| CATALOGUE[effect].id.to_owned()).collect();
        !is_shown(channels, cause.effect) && probability_of(&ids, weighed) < LEAST_PROBABLE
    };
    !found.is_empty() && !weighed.is_empty() && found.iter().all(improbable)
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

/// Probability of all explanations with one of some effects.
fn probability_of(ids: &[String], weighed: &[Weighed]) -> f64 {
    let one_of = |effect: &usize| ids.iter().any(|id| id == CATALOGUE[*effect].id);
    let with = weighed.iter().filter(|w| w.missing.effects().iter().any(one_of));
    with.fold(0.0, |sum, w| sum + w.probability).min(1.0)
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
    use crate::diagnosis::testing::{cause, channel, with};
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
    fn what_got_no_name_counts_less_and_the_others_take_what_it_loses() {
        let [lag, sag] = ["valve_lag", "supply_sag"].map(|id| index_of(id).unwrap());
        let weighed = [
            (Missing::Effects(vec![sag]), 0.5),
            (Missing::Effects(vec![lag]), 0.2),
            (Missing::Effects(vec![lag, sag]), 0.1),
            (Missing::Nothing, 0.1),
        ]
        .map(|(missing, probability)| Weighed { missing, probability, select_rmse_kpa: 1.0 });
        let told = |causes: &[Cause]| -> Vec<(String, f64)> {
            let heeded = by_names(&weighed, causes);
            heeded.iter().map(|w| (w.missing.ids().join("+"), w.probability)).collect()
        };
        let unnamed = told(&[]);
        // The three with a cause count as 0.3 of 0.8, nothing as 0.1, and together they are 0.9 as
        // before.
        let expected =
            [("none", 0.1), ("supply_sag", 0.15), ("valve_lag", 0.06), ("valve_lag+supply_sag", 0.03)];
        for (ids, counts) in expected {
            let found = unnamed.iter().find(|(found, _)| found == ids).map(|(_, p)| *p);
            assert!((found.unwrap() - 0.9 * counts / 0.34).abs() < 1e-12, "{ids}: {unnamed:?}");
        }
        assert!((unnamed.iter().map(|(_, p)| p).sum::<f64>() - 0.9).abs() < 1e-12);
        // One name, and a tie of it.
        let tied = Cause { equivalent: vec![CATALOGUE[lag].id.to_owned()], ..cause("transport_delay", 0.5) };
        let order: Vec<String> = told(&[tied]).into_iter().map(|(ids, _)| ids).collect();
        assert_eq!(order, ["valve_lag", "supply_sag", "none", "valve_lag+supply_sag"]);
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

    #[test]
    fn names_are_taken_back_where_none_of_them_nor_a_tie_is_worth_a_line() {
        let (data, base) = channel(false);
        let channels = [data];
        let [lag, delay, sag, stale] =
            ["valve_lag", "transport_delay", "supply_sag", "stale_samples"].map(|id| index_of(id).unwrap());
        let weighed = [
            (Missing::Nothing, 0.8),
            (Missing::Effects(vec![sag]), 0.0999),
            (Missing::Effects(vec![lag, delay]), 0.0001),
        ]
        .map(|(missing, probability)| Weighed { missing, probability, select_rmse_kpa: 1.0 });
        let found = |effect: usize, equivalent: &[usize]| Found {
            effect,
            acts: vec![true],
            p_value: 0.0,
            equivalent: equivalent.to_vec(),
            without: vec![base.clone()],
            gained: 1.0,
            rivals: Vec::new(),
            errors: None,
        };
        let taken_back = |found: &[Found]| all_improbable(&channels, found, &weighed);
        assert!(taken_back(&[found(lag, &[])]) && taken_back(&[found(lag, &[delay]), found(stale, &[])]));
        assert!(!taken_back(&[found(sag, &[])]) && !taken_back(&[found(lag, &[]), found(sag, &[])]));
        assert!(!taken_back(&[found(lag, &[sag])]), "counted with what fits as well");
        assert!(!taken_back(&[]));
    }

    #[test]
    fn beside_a_probable_name_an_improbable_one_is_none() {
        let [lag, delay, sag] =
            ["valve_lag", "transport_delay", "supply_sag"].map(|id| index_of(id).unwrap());
        let weighed = [
            (Missing::Effects(vec![sag, lag]), 0.4),
            (Missing::Effects(vec![sag]), 0.35),
            (Missing::Effects(vec![sag, delay]), 0.15),
        ]
        .map(|(missing, probability)| Weighed { missing, probability, select_rmse_kpa: 1.0 });
        let named_of = |causes: &[(&str, &[&str])], looped: bool| {
            let with_ties = |(id, ties): &(&str, &[&str])| Cause {
                equivalent: ties.iter().map(|tie| (*tie).to_owned()).collect(),
                ..cause(id, 0.5)
            };
            let (named, _) = part(causes.iter().map(with_ties).collect(), &weighed, looped);
            named.into_iter().map(|cause| cause.effect).collect::<Vec<_>>().join("+")
        };
        let named = |causes: &[(&str, &[&str])]| named_of(causes, false);
        assert_eq!(named(&[("supply_sag", &[]), ("valve_lag", &[])]), "supply_sag");
        // One of the two is there with 0.55.
        assert_eq!(
            named(&[("supply_sag", &[]), ("valve_lag", &["transport_delay"])]),
            "supply_sag+valve_lag"
        );
        assert_eq!(named(&[("valve_lag", &[])]), "valve_lag", "alone, it is said to be improbable");
        let hunting: [(&str, &[&str]); 2] = [("supply_sag", &[]), ("valve_stiction", &[])];
        assert_eq!(named_of(&hunting, true), "supply_sag+valve_stiction");
        assert_eq!(named(&hunting), "supply_sag", "the drive being recorded, rollouts tell");
    }
}
