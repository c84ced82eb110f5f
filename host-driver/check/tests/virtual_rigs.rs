//! The self-test on virtual rigs: healthy ones pass, hidden faults are found and named.
//! docs/check.md has the whole table, from `cargo run -p system-tests --bin check_table`.

#![allow(clippy::unwrap_used)]

use pneudrive_check::{Quantity, Report, Verdict, problems};
use system_tests::self_check::{Busy, alarms, check, check_on_busy, laboratory, with_fault};

fn first(seed: u64) -> Report {
    check(&laboratory(seed), 0.5, None)
}

fn name(board: u8, channel: Option<usize>) -> String {
    channel.map_or_else(|| format!("board {board}"), |channel| format!("board {board}, channel {channel}"))
}

#[test]
fn healthy_rigs_pass_for_themselves_and_beside_their_first_check() {
    for seed in 100..108 {
        let first = first(seed);
        assert!(!alarms(&first), "{:?}", problems(&first, &name));
        for again in [1.3, 2.7] {
            let again = check(&laboratory(seed), again, Some(&first));
            assert_eq!(again.verdict, Verdict::Pass, "{:?}", problems(&again, &name));
        }
    }
}

/// A fault's size at which docs/check.md says that all are found, and what it shows in.
const FAULTS: [(&str, &str, Quantity); 8] = [
    ("exhaust_leak", "=0.02", Quantity::Leak),
    // It fills the dead band before the fall could be measured, and shows in a chamber that cannot
    // be emptied.
    ("fill_leak", "=0.02", Quantity::Zero),
    ("valve_gain", "=0.8", Quantity::FillRate),
    ("valve_centre", "=0.04", Quantity::Centre),
    ("transport_delay", "=0.008", Quantity::DeadTime),
    ("vent_restriction", "=0.8", Quantity::VentRate),
    ("sensor_offset", "=5", Quantity::Zero),
    ("sensor_crosstalk", "=0.04", Quantity::Crosstalk),
];

#[test]
fn a_hidden_fault_shows_in_its_quantity_on_its_channel() {
    for (seed, (effect, size, quantity)) in (200..).zip(FAULTS) {
        let first = first(seed);
        let rig = with_fault(laboratory(seed), &format!("{effect}{size}@b0c2"));
        let found = check(&rig, 1.9, Some(&first));
        // What one channel couples into another is told of the one that was commanded.
        let channel = if quantity == Quantity::Crosstalk { 1 } else { 2 };
        let value = found.boards[0].value(quantity, channel).unwrap();
        assert!(value.verdict >= Verdict::Warn, "{effect}: {value:?}");
        let elsewhere: Vec<_> = found.boards[0].problems().filter(|value| value.channel != channel).collect();
        assert!(elsewhere.is_empty(), "{effect}: {elsewhere:?}");
    }
}

#[test]
fn a_low_supply_shows_in_every_fill_rate_and_a_repair_is_seen() {
    let first = first(300);
    let low = check(&with_fault(laboratory(300), "supply_level=-100"), 1.1, Some(&first));
    let slower = (0..4).filter(|&channel| {
        low.boards[0].value(Quantity::FillRate, channel).is_some_and(|value| value.verdict >= Verdict::Warn)
    });
    assert_eq!(slower.count(), 4);
    assert_eq!(check(&laboratory(300), 2.1, Some(&first)).verdict, Verdict::Pass);
}

#[test]
fn a_busy_machine_does_not_make_a_board_look_worn() {
    for (seed, busy) in (400..).zip([
        Busy { share: 0.02, longest_s: 0.01 },
        Busy { share: 0.05, longest_s: 0.03 },
        Busy { share: 0.01, longest_s: 0.12 },
    ]) {
        let first = first(seed);
        let again = check_on_busy(&laboratory(seed), 1.3, Some(&first), busy);
        assert!(!alarms(&again), "{busy:?}: {:?}", problems(&again, &name));
        let values = &again.boards[0].values;
        let measured = values.iter().filter(|value| value.value.is_some()).count();
        assert!(3 * measured > 2 * values.len(), "{busy:?}: {measured} of {}", values.len());
        let worn = with_fault(laboratory(seed), "transport_delay=0.02@b0c2");
        let worn = check_on_busy(&worn, 1.7, Some(&first), busy);
        let delay = worn.boards[0].value(Quantity::DeadTime, 2).unwrap();
        assert!(delay.verdict >= Verdict::Warn || delay.value.is_none(), "{busy:?}: {delay:?}");
    }
}

#[test]
fn a_machine_that_stands_still_all_the_time_is_named_and_not_the_board() {
    let first = first(410);
    let busy = Busy { share: 0.3, longest_s: 0.05 };
    let again = check_on_busy(&laboratory(410), 1.3, Some(&first), busy);
    assert!(!alarms(&again), "{:?}", problems(&again, &name));
    assert!(again.was_disturbed() && again.verdict == Verdict::NotMeasured, "{again:?}");
}
