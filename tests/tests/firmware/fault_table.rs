//! The fault table of docs/reliability.md: what stands there is what happens, and nothing wrong is
//! believed or obeyed.

use pneudrive_host::bus::FormatPolicy;
use system_tests::fault_table::{
    Boards, Case, Met, Outcome, Setting, Speech, Stranger, cases, meet, row, run, strangers_row,
};

const PAGE: &str = include_str!("../../../docs/reliability.md");

fn outcomes(boards: Boards, case: Case) -> [Outcome; 2] {
    [FormatPolicy::Unchecked, FormatPolicy::Checked]
        .map(|frames| run(Setting { boards, frames, sessions: false, case }))
}

fn kind(case: &Case) -> &str {
    case.fault.split('=').next().unwrap()
}

/// One rate of every kind on native boards, exactly as printed: virtual time and fixed seeds leave
/// nothing to chance.
#[test]
fn the_page_has_what_happens() {
    let mut kinds = std::collections::BTreeSet::new();
    for &case in cases().iter().filter(|case| kinds.insert(kind(case))) {
        let [unchecked, checked] = outcomes(Boards::Native, case);
        let row = row(case, Boards::Native, &unchecked, &checked);
        assert!(
            PAGE.contains(&row),
            "docs/reliability.md has another row for {}; now it is\n{row}If that is right, renew the table: \
             cargo run -p system-tests --example fault_table -- --write",
            case.fault
        );
    }
    assert_eq!(
        kinds.len(),
        pneudrive_sim::fault::FaultKind::ALL.len(),
        "a kind of fault is not in the table"
    );
}

/// The rates that hit most, with checked packets: on chips too nothing wrong is believed or obeyed,
/// and the unchecked runs show that there was something to believe.
#[test]
fn checked_packets_let_nothing_wrong_through() {
    for boards in [Boards::Native, Boards::Chips] {
        let case = Case { fault: "bit_flip=1e-2", lasts_ms: 0, chip_seconds: 3 };
        let [unchecked, checked] = outcomes(boards, case);
        assert!(unchecked.wrong_pressures > 50 && unchecked.wrong_commands > 50, "{boards:?}: {unchecked:?}");
        assert_eq!((checked.wrong_pressures, checked.wrong_commands), (0, 0), "{boards:?}: {checked:?}");
        assert!(checked.struck > 300 && checked.tried > 2_000, "{boards:?}: {checked:?}");
    }
}

/// The same fault in a session.
#[test]
fn sessions_let_nothing_wrong_through() {
    let case = Case { fault: "bit_flip=1e-2", lasts_ms: 0, chip_seconds: 3 };
    let setting = Setting { boards: Boards::Native, frames: FormatPolicy::Checked, sessions: true, case };
    let outcome = run(setting);
    assert_eq!((outcome.wrong_pressures, outcome.wrong_commands), (0, 0), "{outcome:?}");
    assert!(outcome.struck > 4_000 && outcome.tried > 20_000, "{outcome:?}");
    assert!(outcome.tried - outcome.lost > 15_000, "it goes on: {outcome:?}");
}

/// Whole and valid requests that the host has not sent to that board now: nothing but a session
/// keeps them out.
#[test]
fn in_a_session_no_stranger_is_obeyed() {
    strangers_on(Boards::Native, 300);
}

/// The same of the firmware's ELF.
#[test]
fn in_a_session_no_chip_obeys_a_stranger() {
    strangers_on(Boards::Chips, 200);
}

/// Every stranger strikes at least so often, as the page says, and is obeyed without a session
/// only.
fn strangers_on(boards: Boards, often: u64) {
    for stranger in Stranger::ALL {
        let met: [Met; 3] = Speech::ALL.map(|speech| meet(boards, stranger, speech));
        let row = strangers_row(stranger, boards, &met);
        assert!(
            PAGE.contains(&row),
            "docs/reliability.md has another row for {stranger:?}; now it is\n{row}If that is right, renew the \
             table: cargo run -p system-tests --example fault_table -- --write",
        );
        let [unchecked, checked, session] = met;
        assert!(unchecked.wrong_commands > often && checked.wrong_commands > often, "{stranger:?}: {met:?}");
        assert!(session.struck > often && session.wrong_commands == 0, "{stranger:?}: {met:?}");
    }
}

/// What was reviewed: every row of the page, both kinds of boards.
#[test]
fn no_row_of_the_page_has_anything_wrong_with_checked_packets() {
    let rows: Vec<Vec<&str>> = PAGE
        .lines()
        .filter(|line| line.starts_with("| `") && (line.contains("| native |") || line.contains("| chips |")))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), 2 * cases().len());
    for row in rows {
        for cell in [row[6], row[7]] {
            assert_eq!(cell.split_once(" / ").unwrap().1, "0", "{row:?}");
        }
    }
}
