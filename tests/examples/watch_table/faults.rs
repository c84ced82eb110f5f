//! How long it takes to find a change of which size, and whether it is named right.

use std::ops::Range;

use pneudrive_model::watch::{WatchSettings, Watcher};
use pneudrive_sim::plant::Effect;
use pneudrive_sim::record::Row;

use super::rig::{Kind, TUBE_STEP_NS, first_change};

/// Changes of channel 1, by the sizes at which they are made.
const FAULTS: [(&str, [f64; 4]); 24] = [
    ("exhaust_leak", [0.002, 0.005, 0.01, 0.03]),
    ("fill_leak", [0.002, 0.005, 0.01, 0.03]),
    ("valve_gain", [0.97, 0.93, 0.85, 0.7]),
    ("valve_centre", [0.003, 0.006, 0.012, 0.03]),
    ("chamber_volume", [1.03, 1.06, 1.12, 1.25]),
    ("sensor_offset", [1.0, 2.0, 4.0, 8.0]),
    ("sensor_gain", [1.01, 1.02, 1.04, 1.08]),
    ("transport_delay", [0.002, 0.004, 0.008, 0.016]),
    ("valve_lag", [0.002, 0.005, 0.01, 0.02]),
    ("valve_hysteresis", [0.005, 0.01, 0.02, 0.05]),
    ("valve_stiction", [0.01, 0.02, 0.04, 0.08]),
    ("drive_saturation", [0.95, 0.9, 0.8, 0.6]),
    ("valve_asymmetry", [0.95, 0.9, 0.8, 0.6]),
    ("vent_restriction", [0.4, 0.5, 0.6, 0.8]),
    ("line_restriction", [0.05, 0.1, 0.2, 0.4]),
    ("wall_compliance", [0.1, 0.2, 0.4, 0.8]),
    ("sensor_crosstalk", [0.005, 0.01, 0.02, 0.04]),
    ("flow_function", [0.06, 0.12, 0.2, 0.35]),
    ("heat_exchange", [0.05, 0.15, 0.5, 1.5]),
    ("wall_creep", [0.2, 0.4, 0.8, 1.6]),
    ("chamber_coupling", [0.3, 0.8, 1.5, 3.0]),
    ("sensor_lag", [0.005, 0.01, 0.02, 0.04]),
    ("sensor_nonlinearity", [5.0, 10.0, 25.0, 50.0]),
    ("stale_samples", [0.05, 0.1, 0.2, 0.4]),
];
/// Of the whole rig.
const RIG_FAULTS: [(&str, [f64; 4]); 2] =
    [("supply_level", [-10.0, -20.0, -40.0, -80.0]), ("supply_sag", [5.0, 10.0, 20.0, 40.0])];

/// When the change is made, how long it may take to be found, and how long the rig is off in
/// between, s.
const AT_S: f64 = 640.0;
const PATIENCE_S: f64 = 300.0;
const OFF_S: f64 = 1.0;

/// Prints a table: of how many rigs the change was found, the median delay, and of how many it got
/// the right name. What is usual is learnt once a rig; after that the rig is off for a second, and
/// comes back changed, with the movements of its first minutes.
pub fn run(kind: Kind, seeds: Range<u64>, only: &[String]) {
    let folder = tempfile::tempdir().unwrap();
    let healthy: Vec<(u64, Watcher)> = seeds
        .map(|seed| {
            let mut watcher = kind.watcher(&kind.calibrated(seed, folder.path()), WatchSettings::default());
            let early = first_change(kind, &mut watcher, kind.rows(seed, AT_S, &[]));
            assert!(early.is_none(), "rig {seed}: {early:?}");
            (seed, watcher)
        })
        .collect();
    let place = |id: &str| if id == "chamber_coupling" { "@b0" } else { "@b0c1" };
    let local = FAULTS.iter().map(|(id, sizes)| (*id, place(id), sizes));
    let all = local.chain(RIG_FAULTS.iter().map(|(id, sizes)| (*id, "", sizes)));
    for (id, place, sizes) in all.filter(|(id, ..)| only.is_empty() || only.iter().any(|one| one == id)) {
        let faulty = if ["line_restriction", "flow_function"].contains(&id) {
            Kind { step_ns: TUBE_STEP_NS, ..kind }
        } else {
            kind
        };
        let mut line = format!("| `{id}` |");
        for size in sizes {
            let fault: Effect = format!("{id}={size}{place}").parse().unwrap();
            let (mut delays, mut right) = (Vec::new(), 0);
            for (seed, watcher) in &healthy {
                let mut watcher = watcher.clone();
                let changed = faulty.rows(*seed, PATIENCE_S, std::slice::from_ref(&fault));
                let later = changed.map(|row| Row { t_s: row.t_s + AT_S + OFF_S, ..row });
                let Some(change) = first_change(kind, &mut watcher, later) else { continue };
                delays.push(change.t_s - AT_S - OFF_S);
                right += u32::from(change.explanations.first().is_some_and(|e| e.effect == id));
                if std::env::var_os("SHOW").is_some() {
                    let told: Vec<String> = change
                        .explanations
                        .iter()
                        .map(|e| format!("{} {:.3?} {:.2}", e.effect, e.value.unwrap_or(0.0), e.probability))
                        .collect();
                    println!(
                        "  {seed} {id}={size}: at {:.0} s since {:.0} s: {told:?}",
                        change.t_s, change.since_s
                    );
                }
            }
            delays.sort_by(f64::total_cmp);
            let median = delays.get(delays.len() / 2).map_or("-".to_owned(), |d| format!("{d:.0} s"));
            line += &format!(" {size}: {median} ({}/{}, {right}) |", delays.len(), healthy.len());
        }
        println!("{line}");
    }
}
