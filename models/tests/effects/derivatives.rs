//! Derivatives of the simulation by every parameter, of the effects and of the base model, against
//! differences.

use pneudrive_model::effects::{Domain, EffectInfo};

use crate::effects::bench::{Bench, Installed, catalogue};
use crate::effects::random::{DrivenBy, rig_for};

/// Largest error as a part of the largest derivative of the recording.
const ERROR: f64 = 3e-4;
/// Part of the rows that may stand on a kink.
const KINKS: f64 = 0.1;

/// Sizes at which an entry is tried.
fn sizes(info: &EffectInfo) -> Vec<Vec<f64>> {
    match info.id {
        // Their probes are found in a recording.
        "supply_ripple" => vec![vec![20.0, 0.9, 0.3, 0.4]],
        "inflow_cycle" => vec![vec![0.1, 0.9, 0.3]],
        // At whole steps the response to a step of the drive has a kink.
        "transport_delay" => info.probes.iter().map(|p| vec![p[0] + 0.0013]).collect(),
        // Differences go with the size: without a laminar loss they drown in rounding.
        "line_restriction" => info.probes.iter().map(|p| vec![p[0], p[1], p[2].max(2.0)]).collect(),
        _ => info.probes.iter().map(|p| p.to_vec()).collect(),
    }
}

/// Where the loop hunts, secants take the place of derivatives.
fn hunts(id: &str, driven_by: DrivenBy) -> bool {
    driven_by == DrivenBy::Board && ["valve_hysteresis", "valve_stiction"].contains(&id)
}

fn check(name: &str, bench: &Bench, effects: Installed<'_>) {
    for d in bench.derivatives(effects) {
        let sides = || d.before.iter().zip(&d.behind);
        let largest = sides().map(|(a, b)| a.abs().max(b.abs())).fold(0.0, f64::max);
        // A parameter that does nothing here must have derivatives of nothing.
        let most = ERROR * largest.max(0.1);
        let kinks = sides().filter(|(a, b)| (*a - *b).abs() > most).count();
        assert!(
            kinks as f64 <= KINKS * d.exact.len() as f64,
            "{name}: {} has {kinks} kinks: differences say nothing",
            d.parameter
        );
        for (row, (exact, (a, b))) in d.exact.iter().zip(sides()).enumerate() {
            // On a kink, the derivative to either side is right.
            let right = (a.min(*b) - most..=a.max(*b) + most).contains(exact);
            assert!(right, "{name}: {}, row {row}: {exact:e}, differences {a:e} and {b:e}", d.parameter);
        }
    }
}

#[test]
fn every_effect_is_differentiated_exactly() {
    for info in catalogue() {
        for &driven_by in DrivenBy::of(info.domain).iter().filter(|d| !hunts(info.id, **d)) {
            for values in sizes(info) {
                for seed in 0..2 {
                    let bench = rig_for(info.id, seed, driven_by);
                    let name = format!("{} {values:?} ({driven_by:?}, seed {seed})", info.id);
                    check(&name, &bench, &[(info.id, &values)]);
                }
            }
        }
    }
}

/// Effects that share the chamber's step.
#[test]
fn effects_on_one_chamber_are_differentiated_exactly() {
    let heat: (&str, &[f64]) = ("heat_exchange", &[0.3]);
    let tube: (&str, &[f64]) = ("line_restriction", &[0.3, 0.05, 5.0]);
    let wall: (&str, &[f64]) = ("wall_compliance", &[0.1]);
    let pairs: [Installed<'_>; 3] = [&[heat, tube], &[heat, wall], &[heat, tube, wall]];
    for effects in pairs {
        for &driven_by in DrivenBy::of(Domain::Valve) {
            let bench = rig_for("heat_exchange", 0, driven_by);
            check(&format!("{effects:?} ({driven_by:?})"), &bench, effects);
        }
    }
}
