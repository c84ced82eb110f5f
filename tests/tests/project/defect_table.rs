//! `defects.md` names a test for every defect of the original: each named test must exist.

use std::collections::BTreeSet;
use std::path::Path;

/// (number, path, function) of each row.
fn rows() -> Vec<(u32, String, String)> {
    let table = include_str!("../../defects.md");
    let rows = table.lines().filter_map(|line| {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        let [_, number, _, test, _] = cells[..] else { return None };
        let number = number.parse().ok()?;
        let (path, function) = test.trim_matches('`').split_once("::").unwrap_or_else(|| panic!("{line}"));
        Some((number, path.to_owned(), function.to_owned()))
    });
    rows.collect()
}

#[test]
fn every_defect_has_a_test_that_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for (number, path, function) in rows() {
        let source =
            std::fs::read_to_string(root.join(&path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        let at = source
            .find(&format!("fn {function}("))
            .unwrap_or_else(|| panic!("defect {number}: no {function} in {path}"));
        // The attribute stands right above, or the function is inside `proptest!`.
        let before = source[..at].trim_end().lines().next_back().unwrap_or_default().trim();
        assert_eq!(before, "#[test]", "defect {number}: {function} in {path} is no test");
    }
}

#[test]
fn all_eleven_defects_are_there() {
    let numbers: BTreeSet<_> = rows().into_iter().map(|(number, ..)| number).collect();
    assert_eq!(numbers, (1..=11).collect());
}
