//! Rigs that change, watched.

use super::testing::{bank, calibrated, columns, rows};
use super::*;

/// As long as by default.
const LEARN_S: f64 = 600.0;
const CHANGES_S: f64 = 700.0;

fn watch(effect: &'static str, size: f64, seed: u64) -> (Vec<Learnt>, Vec<Change>, Watcher) {
    let file = calibrated();
    let settings = WatchSettings { learn_s: LEARN_S };
    let mut watcher = Watcher::new(("calibrated", &file), vec![columns()], settings).unwrap();
    let (mut learnt, mut changes) = (Vec::new(), Vec::new());
    for row in rows(860.0, effect, size, CHANGES_S, seed) {
        watcher.take(row, &mut |event| match event {
            WatchEvent::Learnt(about) => learnt.push(about),
            WatchEvent::Changed(about) => changes.push(about),
        });
    }
    (learnt, changes, watcher)
}

#[test]
fn a_rig_that_does_not_change_is_left_alone() {
    let (learnt, changes, watcher) = watch("exhaust_leak", 0.0, 1);
    assert_eq!(learnt.len(), 1);
    assert!((600.0..615.0).contains(&learnt[0].t_s), "{learnt:?}");
    // The noise is 0.3 kPa, and there is nothing else.
    assert!((learnt[0].innovation_kpa - 0.3).abs() < 0.03, "{}", learnt[0].innovation_kpa);
    let leak = learnt[0].detectable.iter().find(|d| d.effect == "exhaust_leak").unwrap();
    assert!(leak.value > 0.0 && leak.value < 0.02, "{leak:?}");
    assert!(changes.is_empty(), "{changes:?}");
    assert!(watcher.statistic() < 0.75 * THRESHOLD, "{}", watcher.statistic());
}

/// The change that is found first, after the checks that hold for every one.
fn first(effect: &'static str, size: f64) -> Change {
    let (_, changes, _) = watch(effect, size, 2);
    let change = changes.first().unwrap_or_else(|| panic!("{effect} was not found")).clone();
    assert!(change.t_s > CHANGES_S && change.t_s <= CHANGES_S + 60.0, "{change:?}");
    assert!((change.since_s - CHANGES_S).abs() <= 5.0, "{change:?}");
    let [early, late] = change.since_ci95_s;
    assert!(early <= CHANGES_S && late >= CHANGES_S, "{change:?}");
    let sum: f64 = change.explanations.iter().map(|e| e.probability).sum();
    assert!(sum <= 1.0 + 1e-9 && sum > 0.9, "{change:?}");
    let own = change.explanations.iter().find(|e| e.effect == effect);
    let value = own.and_then(|e| e.value).unwrap_or_else(|| panic!("{effect}: {change:?}"));
    assert!(((value - size) / size).abs() <= 0.2, "{effect} {size}: {change:?}");
    change
}

#[test]
fn a_leak_is_found_named_dated_and_measured() {
    let change = first("exhaust_leak", 0.03);
    let best = &change.explanations[0];
    assert!(best.effect == "exhaust_leak" && best.probability > 0.8, "{change:?}");
}

#[test]
fn what_moves_the_pressure_alike_is_not_told_apart() {
    // The pressure goes to and fro as slowly with less flow as with more volume, in the chamber or
    // by its wall; and rises as much by a spool that rests further open as by a leak past it.
    let slower = ["valve_gain", "chamber_volume", "wall_compliance", "wall_creep", "heat_exchange"];
    let filled = ["fill_leak", "valve_centre"];
    for (effect, size, alike) in
        [("valve_gain", 0.85, &slower[..]), ("chamber_volume", 1.15, &slower), ("fill_leak", 0.03, &filled)]
    {
        let change = first(effect, size);
        assert!(alike.contains(&change.explanations[0].effect), "{change:?}");
        let own = change.explanations.iter().find(|e| e.effect == effect).map_or(0.0, |e| e.probability);
        assert!(own > 0.2 && change.explanations[0].probability < 0.8, "{change:?}");
    }
}

#[test]
fn a_change_is_usual_after_it_has_been_said() {
    let (_, changes, watcher) = watch("exhaust_leak", 0.03, 3);
    assert_eq!(changes.len(), 1, "{changes:?}");
    assert!(watcher.statistic() < THRESHOLD);
}

#[test]
fn every_effect_that_can_be_probed_has_a_direction() {
    let ids: Vec<&str> = bank().directions.iter().map(|d| d.info().id).collect();
    for id in ["supply_level", "exhaust_leak", "valve_gain", "sensor_offset", "valve_lag", "supply_sag"] {
        assert!(ids.contains(&id), "{ids:?}");
    }
    assert!(!ids.contains(&"rate_limit") && !ids.contains(&"inflow_cycle"), "{ids:?}");
    assert!(ids.len() > 20, "{ids:?}");
}

#[test]
fn channels_that_are_not_calibrated_are_said() {
    let mut other = columns();
    other.id = "b3c1".parse().unwrap();
    let error = Watcher::new(("rig.toml", &calibrated()), vec![other], WatchSettings::default());
    let text = error.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(text.contains("b3c1") && text.contains("b0c0") && text.contains("`fit`"), "{text}");
}
