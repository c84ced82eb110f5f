//! What the self-test finds on virtual rigs: false alarms of healthy ones, and how often a fault of
//! which size is found.
//!
//! `check_table healthy RIGS CHECKS` makes so many rigs and checks each so often against its first
//! check; `check_table faults RIGS [EFFECT..]` hides each fault, or these, at five sizes in so many
//! rigs; `check_table show EFFECT SEED [PAGE.html]` prints one check, and writes its page. Both are
//! in docs/check.md.

#![allow(clippy::unwrap_used, reason = "a measurement that cannot be made is a failure")]

use pneudrive_host::check::{Quantity, Report, page, problems, table};
use std::collections::BTreeMap;
use system_tests::self_check::{alarms, check, laboratory, with_fault};

/// Faults on channel 2, by the sizes at which they are hidden.
const FAULTS: [(&str, [f64; 5]); 12] = [
    ("exhaust_leak", [0.001, 0.002, 0.005, 0.01, 0.02]),
    ("fill_leak", [0.001, 0.002, 0.005, 0.01, 0.02]),
    ("valve_gain", [0.97, 0.93, 0.9, 0.8, 0.7]),
    ("valve_centre", [0.005, 0.01, 0.02, 0.03, 0.04]),
    ("transport_delay", [0.001, 0.002, 0.004, 0.008, 0.012]),
    ("valve_lag", [0.002, 0.005, 0.01, 0.015, 0.02]),
    ("valve_stiction", [0.01, 0.02, 0.03, 0.045, 0.06]),
    ("vent_restriction", [0.4, 0.5, 0.6, 0.7, 0.8]),
    ("sensor_offset", [0.5, 1.0, 2.0, 3.0, 5.0]),
    ("chamber_volume", [1.03, 1.06, 1.1, 1.15, 1.2]),
    ("sensor_crosstalk", [0.005, 0.01, 0.015, 0.02, 0.04]),
    ("drive_crosstalk", [0.02, 0.05, 0.1, 0.15, 0.2]),
];
/// Shares of the tolerances at which a change is counted too: what stricter tolerances would find,
/// and how often in vain.
const STRICTER: [f64; 2] = [0.7, 0.5];
/// Of the whole rig.
const SUPPLY: (&str, [f64; 5]) = ("supply_level", [-10.0, -25.0, -50.0, -75.0, -100.0]);

/// When a check begins, s after the rig was switched on: never at the same time, so that noise is
/// other noise.
fn begin_s(number: u64) -> f64 {
    0.5 + 0.137 * number as f64
}

fn baseline(seed: u64) -> Report {
    check(&laboratory(seed), begin_s(0), None)
}

fn healthy(rigs: u64, checks: u64) {
    let mut what: BTreeMap<(Quantity, bool), u64> = BTreeMap::new();
    let mut largest: BTreeMap<Quantity, f64> = BTreeMap::new();
    let (mut alone, mut beside, mut all) = (0, 0, 0);
    let mut stricter = [0_u64; STRICTER.len()];
    for seed in 0..rigs {
        let first = baseline(seed);
        alone += u64::from(alarms(&first));
        count(&first, false, &mut what);
        for number in 1..=checks {
            let next = check(&laboratory(seed), begin_s(number), Some(&first));
            all += 1;
            beside += u64::from(alarms(&next));
            count(&next, true, &mut what);
            let change = largest_change(&next);
            STRICTER
                .iter()
                .zip(&mut stricter)
                .for_each(|(share, count)| *count += u64::from(change > *share));
            for value in next.boards.iter().flat_map(|board| &board.values) {
                let (Some(now), Some(before)) = (value.value, value.before) else { continue };
                let is_rate = matches!(value.quantity, Quantity::FillRate | Quantity::VentRate);
                let change = if is_rate { (now / before).ln() } else { now - before };
                let so_far = largest.entry(value.quantity).or_default();
                *so_far = so_far.max(change.abs());
            }
        }
        // Who waits for a thousand checks wants to see that they go on.
        eprintln!("{} rigs, {all} checks: {alone} and {beside} false alarms", seed + 1);
    }
    for (share, count) in STRICTER.iter().zip(stricter) {
        println!("beyond {share} of a tolerance: {count} of {all} checks beside the first");
    }
    println!(
        "{rigs} first checks: {alone} false alarms; {all} checks beside the first: {beside} false alarms"
    );
    for (quantity, change) in largest {
        println!("  largest change of {}: {change:.3} (rates: logarithm)", quantity.name());
    }
    for ((quantity, compared), count) in what {
        println!("  {} {}: {count}", if compared { "beside the first" } else { "alone" }, quantity.name());
    }
}

fn count(report: &Report, compared: bool, what: &mut BTreeMap<(Quantity, bool), u64>) {
    for board in &report.boards {
        board.problems().for_each(|value| *what.entry((value.quantity, compared)).or_default() += 1);
    }
}

/// How far the largest change has gone, in tolerances: from 1 on it warns.
fn largest_change(report: &Report) -> f64 {
    let values = report.boards.iter().flat_map(|board| &board.values);
    let gone = values.filter_map(|value| {
        let (now, before) = (value.value?, value.before?);
        let to = if now > before { value.limits.1? } else { value.limits.0? };
        Some((now - before) / (to - before))
    });
    gone.filter(|gone| gone.is_finite()).fold(0.0, f64::max)
}

fn faults(rigs: u64, only: &[String]) {
    let first: Vec<Report> = (0..rigs).map(baseline).collect();
    let local = FAULTS.iter().map(|(id, sizes)| (*id, "@b0c2", sizes));
    let all = local.chain([(SUPPLY.0, "", &SUPPLY.1)]);
    for (id, place, sizes) in all.filter(|(id, ..)| only.is_empty() || only.iter().any(|one| one == id)) {
        let mut stricter = String::new();
        let mut line = format!("| `{id}` |");
        let mut named: BTreeMap<&str, u64> = BTreeMap::new();
        for size in sizes {
            let (mut alone, mut beside, mut found_by) = (0, 0, [0_u64; STRICTER.len()]);
            for (seed, first) in (0..rigs).zip(&first) {
                let rig = with_fault(laboratory(seed), &format!("{id}={size}{place}"));
                let found = check(&rig, begin_s(seed + 1), Some(first));
                let unaided = check_alone(&found);
                beside += u64::from(alarms(&found));
                alone += u64::from(unaided);
                let change = largest_change(&found);
                STRICTER.iter().zip(&mut found_by).for_each(|(share, hits)| {
                    *hits += u64::from(change > *share || alarms(&found));
                });
                for board in &found.boards {
                    board.problems().for_each(|value| *named.entry(value.quantity.name()).or_default() += 1);
                }
            }
            let percent = |hits: u64| 100 * hits / rigs;
            line += &format!(" {size}: {} ({}) |", percent(beside), percent(alone));
            stricter += &format!(" {size}: {:?}", found_by.map(percent));
        }
        let mut named: Vec<_> = named.into_iter().collect();
        named.sort_by_key(|one| std::cmp::Reverse(one.1));
        let named: Vec<_> = named.iter().take(3).map(|(name, _)| *name).collect();
        println!("{line} {} |", named.join(", "));
        println!("  at {STRICTER:?} of the tolerances:{stricter}");
    }
}

/// Whether the limits for itself alone alarm: values as measured, judged without the earlier check.
fn check_alone(found: &Report) -> bool {
    found.boards.iter().any(|board| board.alarms_alone())
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |place: usize| words.get(place).and_then(|word| word.parse().ok());
    match (words.first().map(String::as_str), number(1), number(2)) {
        (Some("healthy"), Some(rigs), Some(checks)) => healthy(rigs, checks),
        (Some("faults"), Some(rigs), _) => faults(rigs, &words[2..]),
        (Some("show"), _, seed) => {
            let seed = seed.unwrap_or(0);
            let first = baseline(seed);
            let rig = match words.get(1).map(String::as_str) {
                None | Some("none") => laboratory(seed),
                Some(effect) => with_fault(laboratory(seed), effect),
            };
            let report = check(&rig, begin_s(3), Some(&first));
            let name = |board: u8, channel: Option<usize>| match channel {
                Some(channel) => format!("board {board}, channel {channel}"),
                None => format!("board {board}"),
            };
            print!("{}", table(&report, &name));
            problems(&report, &name).iter().for_each(|problem| println!("{problem}"));
            if let Some(file) = words.get(3) {
                std::fs::write(file, page(&report, &name)).unwrap();
            }
        }
        _ => {
            eprintln!(
                "expected: healthy RIGS CHECKS, faults RIGS [EFFECT..], or show EFFECT SEED [PAGE.html]"
            );
            std::process::exit(2);
        }
    }
}
