//! Searches from another effect on, on channels whose truth is known.

use super::super::naming::Entered;
use super::super::taking_over::{is_better, next_to_nothing, put_first, stands_in_the_catalogue};
use super::*;
use crate::diagnosis::channel::Extended;
use crate::diagnosis::screening::trials;
use crate::diagnosis::selection::selected::Withheld;
use crate::diagnosis::settings::SETTINGS;
use crate::diagnosis::testing::{STRUCTURE, channel, fitted, measured, with};
use crate::effects::catalogue::{CATALOGUE, index_of};
use std::rc::Rc;
use std::sync::Mutex;

const RULES: Rules<'_> = Rules { asked: STRUCTURE, harmless: false, beating: None };

/// Two channels with `truth`, and the stages of the base model fitted to them.
fn channels(truth: &Extended) -> (Vec<ChannelData>, Vec<ChannelStage>) {
    let (data, base) = channel(false);
    let channels: Vec<ChannelData> = (0..2).map(|seed| measured(data.clone(), truth, seed)).collect();
    let first = channels.iter().map(|data| fitted(data, &base)).collect();
    (channels, first)
}

/// What a first search has tried, with no name for it.
fn unnamed(channels: &[ChannelData], first: &[ChannelStage]) -> Named {
    let tried = trials(channels, first, STRUCTURE, &|| {});
    Named { first_round: Some(Rc::new(Entered { tried, ranked: Vec::new() })), ..Named::default() }
}

fn truth_of_two() -> Extended {
    let (data, base) = channel(false);
    with(&data, &with(&data, &base, "valve_lag", &[0.03]), "wall_compliance", &[0.1])
}

#[test]
fn a_pair_that_a_search_has_missed_is_named() {
    let (mut channels, first) = channels(&truth_of_two());
    let (mut named, mut stages) = (unnamed(&channels, &first), first.clone());
    from_another_first(&mut channels, (&first, &mut stages), RULES, &mut named, &|_, _| {});
    let mut names: Vec<&str> = named.causes.iter().map(|cause| CATALOGUE[cause.effect].id).collect();
    names.sort_unstable();
    assert_eq!(names, ["valve_lag", "wall_compliance"]);
    assert!(kept_total(&channels, &stages) < ENOUGH * open_rows(&channels));
    assert!(stages.iter().all(|stage| named.causes.iter().all(|cause| stage.model.has(cause.effect))));
}

#[test]
fn where_little_is_left_nothing_is_searched_again() {
    let (mut channels, first) = channels(&channel(false).1);
    let (mut named, mut stages) = (unnamed(&channels, &first), first.clone());
    let told = Mutex::new(Vec::new());
    let tell = |what: &str, _| told.lock().unwrap().push(what.to_owned());
    from_another_first(&mut channels, (&first, &mut stages), RULES, &mut named, &tell);
    assert!(named.causes.is_empty() && told.into_inner().unwrap().is_empty());
}

#[test]
fn the_longer_a_recording_the_fewer_further_searches() {
    let of_channels = |channels: usize, seconds: usize| most_searches(channels * seconds * 100);
    assert_eq!((of_channels(2, 60), of_channels(4, 60), of_channels(4, 220)), (3, 1, 0));
}

#[test]
fn a_further_search_ends_where_two_names_leave_more_than_the_search_before() {
    let (data, _) = channel(false);
    let truth = with(&data, &truth_of_two(), "drive_saturation", &[0.4]);
    let names = |beating: Option<f64>| {
        let (mut channels, first) = channels(&truth);
        let (mut named, mut stages) = (Named::default(), first.clone());
        name(&mut channels, (&first, &mut stages), Rules { beating, ..RULES }, &mut named, &|_, _| {});
        named.causes.len()
    };
    assert_eq!((names(None), names(Some(f64::INFINITY)), names(Some(0.0))), (3, 3, 2));
}

/// Do names with a model explain better than others, in place of which something outside the
/// catalogue with a third model would do where it is given?
fn better(again: (&[&str], &Extended), before: (&[&str], &Extended), foil: Option<&Extended>) -> bool {
    let (channels, _) = channels(&truth_of_two());
    let stages = |model: &Extended| -> Vec<ChannelStage> {
        channels.iter().map(|data| ChannelStage::new(data, model.clone(), Vec::new())).collect()
    };
    let candidate = |id: &str, model: &Extended| Candidate {
        effect: index_of(id).unwrap(),
        models: vec![model.clone(); 2],
        acts: vec![true; 2],
        losses: stages(model).iter().map(|stage| stage.losses.clone()).collect(),
    };
    let named = |(ids, model): (&[&str], &Extended)| {
        let cause = |id: &&str| Found::new(&channels, &stages(model), &[candidate(id, model)], 0, &[], 0.01);
        let name = |foil: &Extended| Withheld {
            effect: index_of("valve_wear").unwrap(),
            foil: candidate("supply_misstated", foil),
        };
        Named { causes: ids.iter().map(cause).collect(), withheld: foil.map(name), ..Named::default() }
    };
    let new = Named { withheld: None, ..named(again) };
    is_better(&channels, (&new, &stages(again.1)), (&named(before), &stages(before.1)))
}

#[test]
fn fewer_names_may_leave_as_much_and_as_many_or_more_must_leave_less() {
    let (data, base) = channel(false);
    let both = truth_of_two();
    let lagging = with(&data, &base, "valve_lag", &[0.03]);
    let (one, two, three) =
        (["valve_lag"], ["valve_lag", "wall_compliance"], ["valve_lag", "wall_compliance", "valve_wear"]);
    assert!(better((&two, &both), (&three, &both), None));
    assert!(!better((&two, &both), (&two, &both), None) && !better((&three, &both), (&two, &both), None));
    assert!(better((&two, &both), (&one, &lagging), None) && better((&two, &both), (&two, &lagging), None));
    assert!(!better((&one, &lagging), (&two, &both), None));
    assert!(!better((&[], &both), (&one, &lagging), None));
    // Surely less by 0.5 and by 2 %, of which half of what a name must gain is enough.
    let of_lag = |lag: f64| with(&data, &with(&data, &base, "valve_lag", &[lag]), "wall_compliance", &[0.1]);
    let than = |lag: f64| better((&two, &both), (&two, &of_lag(lag)), None);
    assert!(!than(0.031) && than(0.032));
}

#[test]
fn where_there_was_no_name_little_may_be_left() {
    let (data, base) = channel(false);
    let (both, lagging) = (truth_of_two(), with(&data, &base, "valve_lag", &[0.03]));
    assert!(better((&["valve_lag", "wall_compliance"], &both), (&[], &base), None));
    assert!(!better((&["valve_lag"], &lagging), (&[], &base), None));
    assert!(better((&["valve_lag"], &lagging), (&["wall_compliance"], &base), None));
    // 1.2, or of a loop a fiftieth of a large error above 1.
    let least = |before: f64, looped: bool| next_to_nothing(before, 1e3, looped).round();
    assert_eq!([least(5e3, true), least(61e3, true), least(61e3, false)], [1.2e3, 2.2e3, 1.2e3]);
}

#[test]
fn what_explains_most_alone_is_named_first_though_a_search_began_with_another() {
    let (channels, first) = channels(&truth_of_two());
    let found = |effect: usize| {
        let (models, losses) = first.iter().map(|s| (s.model.clone(), s.losses.clone())).unzip();
        let candidate = Candidate { effect, models, acts: vec![true; 2], losses };
        Found::new(&channels, &first, &[candidate], 0, &[], 0.01)
    };
    let order = |best: usize| {
        let mut causes: Vec<Found> = [3, 1, 2].map(found).to_vec();
        put_first(&mut causes, |cause| cause.effect == best);
        causes.iter().map(|cause| cause.effect).collect::<Vec<_>>()
    };
    assert_eq!([order(2), order(3), order(7)], [[2, 3, 1], [3, 1, 2], [3, 1, 2]]);
}

#[test]
fn what_harms_explains_nothing() {
    let (channels, first) = channels(&truth_of_two());
    let model = truth_of_two();
    let stages: Vec<ChannelStage> =
        channels.iter().map(|data| ChannelStage::new(data, model.clone(), Vec::new())).collect();
    let losses = stages.iter().map(|stage| stage.losses.clone()).collect();
    let candidate = Candidate { effect: 0, models: vec![model; 2], acts: vec![true; 2], losses };
    let better = |change: &dyn Fn(&mut Named)| {
        let found = Found::new(&channels, &first, std::slice::from_ref(&candidate), 0, &[], 0.01);
        let mut again = Named { causes: vec![found], ..Named::default() };
        change(&mut again);
        is_better(&channels, (&again, &stages), (&Named::default(), &first))
    };
    assert!(better(&|_| ()));
    assert!(!better(&|again| again.harmful = Some(1.0)));
}

#[test]
fn what_is_outside_the_catalogue_must_be_beaten() {
    let (data, base) = channel(false);
    let (both, lagging) = (truth_of_two(), with(&data, &base, "valve_lag", &[0.03]));
    let names = ["valve_lag", "wall_compliance"];
    assert!(better((&names, &both), (&[], &base), Some(&lagging)));
    assert!(!better((&names, &both), (&[], &base), Some(&both)));
}

/// The only name of a search that was begun with an effect, on channels with a truth, and whether
/// it stands.
fn standing(truth: &Extended, id: &str) -> (Found, bool) {
    let (mut channels, first) = channels(truth);
    let before = unnamed(&channels, &first);
    let tried = &before.first_round.as_ref().unwrap().tried;
    let effect = index_of(id).unwrap();
    let candidate = refitted(&channels, &first, tried, effect);
    let mut found = Found::new(&channels, &first, std::slice::from_ref(&candidate), 0, &[], 1.0);
    let stages = settle_finely(&mut channels, &candidate.models, false);
    found.adds(&channels, &first, &stages);
    let stands =
        stands_in_the_catalogue(&mut channels, &stages, std::slice::from_mut(&mut found), effect, STRUCTURE);
    (found, stands)
}

#[test]
fn the_effect_it_began_with_has_rivals_like_any_other_and_none_outside_the_catalogue() {
    let (data, base) = channel(false);
    let (lag, stands) = standing(&with(&data, &base, "valve_lag", &[0.03]), "valve_lag");
    assert!(stands && lag.p_value < SETTINGS.level, "{lag:?}");
    assert_eq!(lag.equivalent.len(), lag.rivals.len());
    // What explains far better than the effect it began with explains as well at least.
    let (delay, stands) = standing(&with(&data, &base, "valve_lag", &[0.03]), "transport_delay");
    assert!(stands && delay.equivalent.contains(&lag.effect), "{delay:?}");
    // A level of the supply that the rig file states wrongly, and what does much the same.
    let misstated = with(&data, &base, "supply_misstated", &[-0.15]);
    assert!(!standing(&misstated, "valve_asymmetry").1);
}

#[test]
fn searches_begin_with_what_no_name_of_a_promising_pair_began_with() {
    let pairs = [[3, 1], [1, 2], [4, 5]].map(|effects| Pair { effects, gain: 1.0 });
    let (data, base) = channel(false);
    let stage = [fitted(&data, &base)];
    let named = |effects: &[usize]| -> Vec<Found> {
        let candidate = |&effect: &usize| Candidate {
            effect,
            models: vec![base.clone()],
            acts: vec![true],
            losses: vec![stage[0].losses.clone()],
        };
        let found =
            |effect| Found::new(std::slice::from_ref(&data), &stage, &[candidate(effect)], 0, &[], 0.01);
        effects.iter().map(found).collect()
    };
    assert_eq!(next_first(&pairs, &named(&[3]), &[3]), Some(1));
    assert_eq!(next_first(&pairs, &named(&[3, 1]), &[3]), Some(1), "of the pair of 1 and 2");
    assert_eq!(next_first(&pairs, &named(&[1, 2, 3]), &[3]), Some(4));
    assert_eq!(next_first(&pairs, &[], &[1, 2, 3, 4, 5]), None);
}
