//! Scores `report.json` against what was hidden.

use std::collections::BTreeMap;

use serde_json::Value;

use super::plan::{Case, Kind};

/// How one case came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// Named, and nothing else as well.
    Right,
    /// In a tie of at most three.
    Tied,
    /// Nothing was named.
    Missed,
    /// Something else was named.
    Wrong,
    /// Of several named, the hidden one is there and something false too.
    Extra,
    /// A null recording in which nothing was named.
    Clean,
    /// An effect off the catalogue that came out without a name.
    Unnamed,
}

/// Scores one report.
#[must_use]
pub fn score(case: &Case, report: &Value) -> Outcome {
    let empty = Vec::new();
    let causes: Vec<(&str, Vec<&str>)> = report["causes"]
        .as_array()
        .unwrap_or(&empty)
        .iter()
        .filter_map(|cause| {
            let rivals = cause["equivalent"].as_array()?.iter().filter_map(Value::as_str).collect();
            Some((cause["effect"].as_str()?, rivals))
        })
        .collect();
    match case.kind {
        Kind::Null if causes.is_empty() => return Outcome::Clean,
        Kind::OffCatalogue if causes.is_empty() => return Outcome::Unnamed,
        Kind::Null | Kind::OffCatalogue => return Outcome::Wrong,
        _ if causes.is_empty() => return Outcome::Missed,
        _ => {}
    }
    // How each hidden effect was found, at worst, and how many named causes stand for none of them.
    let mut worst = Outcome::Right;
    for hidden in &case.effects {
        let alone = causes.iter().any(|(id, rivals)| id == hidden && rivals.is_empty());
        let tied = causes
            .iter()
            .any(|(id, rivals)| (id == hidden || rivals.contains(&hidden.as_str())) && rivals.len() <= 2);
        let found = if alone {
            Outcome::Right
        } else if tied {
            Outcome::Tied
        } else {
            Outcome::Wrong
        };
        worst = worst.max(found);
    }
    let stands = |(id, rivals): &(&str, Vec<&str>)| {
        case.effects.iter().any(|hidden| id == hidden || rivals.contains(&hidden.as_str()))
    };
    let false_names = causes.iter().filter(|cause| !stands(cause)).count();
    if worst != Outcome::Wrong && false_names > 0 { Outcome::Extra } else { worst }
}

/// Lines of a confusion matrix: by what was hidden, how often it came out how.
#[must_use]
pub fn matrix(scored: &[(Case, Outcome, String)]) -> String {
    const COLUMNS: [(Outcome, &str); 7] = [
        (Outcome::Right, "right"),
        (Outcome::Tied, "tied"),
        (Outcome::Missed, "missed"),
        (Outcome::Wrong, "wrong"),
        (Outcome::Extra, "extra"),
        (Outcome::Clean, "clean"),
        (Outcome::Unnamed, "unnamed"),
    ];
    let mut rows: BTreeMap<String, BTreeMap<Outcome, usize>> = BTreeMap::new();
    for (case, outcome, _) in scored {
        let row = match case.kind {
            Kind::Null => "(nothing)".to_owned(),
            Kind::Single => format!("{} {}", case.effects.join("+"), case.size),
            Kind::OneChannel => "(one channel only)".to_owned(),
            Kind::Pair => "(pairs)".to_owned(),
            Kind::OffCatalogue => format!("off: {}", case.effects.join("+")),
        };
        *rows.entry(row).or_default().entry(*outcome).or_default() += 1;
    }
    let head = COLUMNS.map(|(_, name)| name).join(" | ");
    let mut text = format!("| hidden | {head} |\n|---|{}\n", "--:|".repeat(COLUMNS.len()));
    for (row, counts) in rows {
        let cells: Vec<String> =
            COLUMNS.iter().map(|(o, _)| counts.get(o).map_or(String::new(), ToString::to_string)).collect();
        text.push_str(&format!("| {row} | {} |\n", cells.join(" | ")));
    }
    text
}

/// What a report names, for a person.
#[must_use]
pub fn named(report: &Value) -> String {
    let causes = report["causes"].as_array().cloned().unwrap_or_default();
    let one = |cause: &Value| {
        let rivals: Vec<&str> = cause["equivalent"]
            .as_array()
            .map(|r| r.iter().filter_map(Value::as_str).collect())
            .unwrap_or_default();
        let name = cause["effect"].as_str().unwrap_or("?");
        if rivals.is_empty() { name.to_owned() } else { format!("{name}~{}", rivals.join("~")) }
    };
    let names: Vec<String> = causes.iter().map(one).collect();
    if names.is_empty() { report["verdict"].as_str().unwrap_or("?").to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn case(kind: Kind, effects: &[&str]) -> Case {
        Case {
            number: 0,
            kind,
            effects: effects.iter().map(|e| (*e).to_owned()).collect(),
            arguments: Vec::new(),
            size: "moderate".to_owned(),
            seed: 1,
            drive: true,
        }
    }

    fn report(causes: &[(&str, &[&str])]) -> Value {
        let causes: Vec<Value> =
            causes.iter().map(|(id, rivals)| json!({"effect": id, "equivalent": rivals})).collect();
        json!({ "causes": causes })
    }

    #[test]
    fn every_outcome_is_told_from_the_others() {
        let single = case(Kind::Single, &["valve_lag"]);
        assert_eq!(score(&single, &report(&[("valve_lag", &[])])), Outcome::Right);
        assert_eq!(score(&single, &report(&[("sensor_lag", &["valve_lag"])])), Outcome::Tied);
        assert_eq!(score(&single, &report(&[("a", &["b", "c", "valve_lag"])])), Outcome::Wrong);
        assert_eq!(score(&single, &report(&[])), Outcome::Missed);
        assert_eq!(score(&single, &report(&[("supply_sag", &[])])), Outcome::Wrong);
        assert_eq!(score(&single, &report(&[("valve_lag", &[]), ("supply_sag", &[])])), Outcome::Extra);
        assert_eq!(score(&case(Kind::Null, &[]), &report(&[])), Outcome::Clean);
        assert_eq!(score(&case(Kind::Null, &[]), &report(&[("valve_lag", &[])])), Outcome::Wrong);
        assert_eq!(score(&case(Kind::OffCatalogue, &["x"]), &report(&[])), Outcome::Unnamed);
        let pair = case(Kind::Pair, &["valve_lag", "supply_sag"]);
        assert_eq!(score(&pair, &report(&[("valve_lag", &[]), ("supply_sag", &[])])), Outcome::Right);
        assert_eq!(score(&pair, &report(&[("valve_lag", &[])])), Outcome::Wrong);
    }
}
