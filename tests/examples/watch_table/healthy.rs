//! False alarms of healthy rigs.

use std::ops::Range;

use pneudrive_model::watch::{WatchEvent, WatchSettings};

use super::rig::Kind;

/// Levels of the statistic whose crossings are counted: how they grow rarer says how far the
/// threshold is.
const LEVELS: [f64; 6] = [20.0, 25.0, 30.0, 35.0, 40.0, 45.0];
/// A crossing counts anew once the statistic has fallen below this share of the level.
const BACK: f64 = 0.7;

/// Watches a rig of each seed; prints every false alarm and, in the end, their rate, how often
/// lower levels were crossed, and how much memory the program had.
pub fn run(kind: Kind, seeds: Range<u64>, hours: f64) {
    let folder = tempfile::tempdir().unwrap();
    let settings = WatchSettings::default();
    let (mut watched_h, mut alarms) = (0.0, 0_u32);
    let mut crossings = [0_u32; LEVELS.len()];
    for seed in seeds {
        let model = kind.calibrated(seed, folder.path());
        let mut watcher = kind.watcher(&model, settings);
        let (mut learnt_s, mut largest) = (Vec::new(), 0.0_f64);
        let mut above = [false; LEVELS.len()];
        for row in kind.rows(seed, 3600.0 * hours, &[]) {
            watcher.take(kind.sample(&row), &mut |event| match event {
                WatchEvent::Learnt(learnt) => learnt_s.push(learnt.t_s),
                WatchEvent::Changed(change) => {
                    alarms += 1;
                    let best = change.explanations.first().map(|e| (e.effect, e.value, e.probability));
                    println!(
                        "rig {seed}, {} at {:.0} s since {:.0} s, {:.1}: {best:?}",
                        change.channel, change.t_s, change.since_s, change.statistic
                    );
                }
            });
            if row.t_s.fract() == 0.0 {
                let now = watcher.statistic();
                largest = largest.max(now);
                for ((level, above), count) in LEVELS.iter().zip(&mut above).zip(&mut crossings) {
                    *count += u32::from(now >= *level && !*above);
                    *above = now >= if *above { BACK * level } else { *level };
                }
            }
        }
        let began = learnt_s.iter().copied().fold(0.0, f64::max);
        watched_h += (hours - began / 3600.0).max(0.0);
        println!(
            "rig {seed}: watched from {began:.0} s on; largest statistic {largest:.1}; so far {watched_h:.1} h, {alarms} false alarms, \
             crossings of {LEVELS:?}: {crossings:?}, {} kB resident",
            resident_kb()
        );
    }
    let most = super::poisson_upper95(alarms);
    println!(
        "{watched_h:.1} h of rigs of {} channels, {alarms} false alarms: at least {:.0} h between them (95 %, exact Poisson)",
        kind.channels,
        watched_h / most
    );
}

/// Memory of this process, kB; 0 where the system does not say.
fn resident_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
