//! What probabilities mean for names.

use crate::diagnosis::evidence::Weighed;
use crate::diagnosis::json::Cause;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::order::descending;

use super::earned::{EVEN, hunts, is_sure_by_itself};

/// Parts causes into those that keep their names and those that are less probable than not beside
/// one that is more. Of what makes a loop hunt (`looped`) its own likelihood has told already, and
/// what rollouts predict tells little: none is in step with the recording. So has the test data of
/// what is sure there.
pub fn part(causes: Vec<Cause>, weighed: &[Weighed], looped: bool) -> (Vec<Cause>, Vec<Cause>) {
    let probable = |cause: &Cause| looped && hunts(cause) || probability(cause, weighed) >= EVEN;
    let any = causes.iter().any(probable);
    causes.into_iter().partition(|cause| probable(cause) || !any || is_sure_by_itself(cause, looped))
}

/// How probable a cause is, counted with what fits as well; 1 where nothing was weighed.
#[must_use]
pub fn probability(cause: &Cause, weighed: &[Weighed]) -> f64 {
    let ties: Vec<String> = cause.equivalent.iter().chain([&cause.effect]).cloned().collect();
    if weighed.is_empty() { 1.0 } else { probability_of(&ties, weighed) }
}

/// What counts of that for a name: what the rows of a loop show (`looped`, `shown`) is there. It
/// follows its stale samples, and rollouts of it tell little; of recorded drives they do.
#[must_use]
pub fn counted(cause: &Cause, weighed: &[Weighed], looped: bool, shown: bool) -> f64 {
    if looped && shown { 1.0 } else { probability(cause, weighed) }
}

/// Probability of all explanations with one of some effects.
pub fn probability_of(ids: &[String], weighed: &[Weighed]) -> f64 {
    let one_of = |effect: &usize| ids.iter().any(|id| id == CATALOGUE[*effect].id);
    let with = weighed.iter().filter(|w| w.missing.effects().iter().any(one_of));
    with.fold(0.0, |sum, w| sum + w.probability).min(1.0)
}

/// Probabilities that heed the names, too: the tests for them are evidence besides how well
/// explanations predict. Sets with a cause that got no name count less, the others take what they
/// lose.
pub fn by_names(weighed: &[Weighed], causes: &[Cause]) -> Vec<Weighed> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::evidence::Missing;
    use crate::diagnosis::testing::{cause, sized};
    use crate::effects::catalogue::index_of;

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
        // The three with a cause count as 0.1 of 0.8, nothing as 0.1, and together they are 0.9 as
        // before.
        let expected =
            [("none", 0.1), ("supply_sag", 0.05), ("valve_lag", 0.02), ("valve_lag+supply_sag", 0.01)];
        for (ids, counts) in expected {
            let found = unnamed.iter().find(|(found, _)| found == ids).map(|(_, p)| *p);
            assert!((found.unwrap() - 0.9 * counts / 0.18).abs() < 1e-12, "{ids}: {unnamed:?}");
        }
        assert!((unnamed.iter().map(|(_, p)| p).sum::<f64>() - 0.9).abs() < 1e-12);
        // One name, and a tie of it.
        let tied = Cause { equivalent: vec![CATALOGUE[lag].id.to_owned()], ..cause("transport_delay", 0.5) };
        let order: Vec<String> = told(&[tied]).into_iter().map(|(ids, _)| ids).collect();
        assert_eq!(order, ["valve_lag", "none", "supply_sag", "valve_lag+supply_sag"]);
    }

    #[test]
    fn what_the_rows_show_is_sure_in_a_loop_and_as_probable_as_it_is_with_recorded_drives() {
        let stale = index_of("stale_samples").unwrap();
        let weighed =
            [Weighed { missing: Missing::Effects(vec![stale]), probability: 0.003, select_rmse_kpa: 1.0 }];
        let of = |looped: bool, shown: bool| counted(&cause("stale_samples", 0.5), &weighed, looped, shown);
        let told = [(true, true), (true, false), (false, true)].map(|(looped, shown)| of(looped, shown));
        assert_eq!(told, [1.0, 0.003, 0.003]);
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
        let beside_sag = |low_s: f64, weighted: f64| {
            let mut lag = sized("valve_lag", "time_constant", [low_s, 0.03]);
            lag.gain.weighted_ci95 = [weighted, 0.3];
            part(vec![cause("supply_sag", 0.5), lag], &weighed, false).0.len()
        };
        assert_eq!(beside_sag(0.02, 0.1), 2, "its size and its gain are sure");
        assert_eq!((beside_sag(0.0, 0.1), beside_sag(0.02, 0.04)), (1, 1));
        assert_eq!(named(&[("valve_lag", &[])]), "valve_lag", "alone, it is said to be improbable");
        let hunting: [(&str, &[&str]); 2] = [("supply_sag", &[]), ("valve_stiction", &[])];
        assert_eq!(named_of(&hunting, true), "supply_sag+valve_stiction");
        assert_eq!(named(&hunting), "supply_sag", "the drive being recorded, rollouts tell");
    }
}
