//! Scores `report.json` against what was hidden.

use std::collections::BTreeMap;

use pneudrive_sim::plant::{Background, PlantParameters};
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

/// A named cause: the effect, and what cannot be told from it.
type Cause<'a> = (&'a str, Vec<&'a str>);

fn causes(report: &Value) -> Vec<Cause<'_>> {
    fn one(cause: &Value) -> Option<Cause<'_>> {
        let rivals = cause["equivalent"].as_array()?.iter().filter_map(Value::as_str).collect();
        Some((cause["effect"].as_str()?, rivals))
    }
    report["causes"].as_array().into_iter().flatten().filter_map(one).collect()
}

/// Does a cause stand for something that was hidden?
fn stands(case: &Case, (id, rivals): &Cause<'_>) -> bool {
    case.kind != Kind::OffCatalogue
        && case.effects.iter().any(|hidden| id == hidden || rivals.contains(&hidden.as_str()))
}

/// How many named causes stand for nothing that was hidden.
#[must_use]
pub fn false_names(case: &Case, report: &Value) -> usize {
    causes(report).iter().filter(|cause| !stands(case, cause)).count()
}

/// Scores one report.
#[must_use]
pub fn score(case: &Case, report: &Value) -> Outcome {
    let causes = causes(report);
    match case.kind {
        Kind::Null if causes.is_empty() => return Outcome::Clean,
        Kind::OffCatalogue if causes.is_empty() => return Outcome::Unnamed,
        Kind::Null | Kind::OffCatalogue => return Outcome::Wrong,
        _ if causes.is_empty() => return Outcome::Missed,
        _ => {}
    }
    // How each hidden effect was found, at worst.
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
    // One cause that is a tie of two hidden effects says that one of them is there.
    if causes.len() < case.effects.len() {
        worst = Outcome::Wrong;
    }
    if worst != Outcome::Wrong && false_names(case, report) > 0 { Outcome::Extra } else { worst }
}

/// Parameters that the truth plant and the diagnosis define alike: effect, the diagnosis'
/// parameter, and its unit over the plant's.
const SAME: [(&str, &str, f64); 14] = [
    ("supply_ripple", "amplitude", 1.0),
    ("transport_delay", "delay", 1.0),
    ("valve_lag", "time_constant", 1.0),
    ("valve_hysteresis", "half_width", 1.0),
    ("valve_stiction", "threshold", 1.0),
    ("drive_saturation", "limit", 1.0),
    ("valve_asymmetry", "ratio", 1.0),
    ("heat_exchange", "time_constant", 1.0),
    ("wall_compliance", "compliance", 0.1),
    ("wall_creep", "compliance", 0.1),
    ("sensor_lag", "time_constant", 1.0),
    ("sensor_nonlinearity", "bow", 1.0),
    ("sensor_drift", "change", 1.0),
    ("sensor_crosstalk", "share", 1.0),
];

/// Effects of the chamber's wall, whose size is a growth relative to all the volume behind the
/// valve.
const OF_THE_WALL: [&str; 2] = ["wall_compliance", "wall_creep"];

/// Part of the volume behind a valve whose wall gives way. On the rigs of hard rounds a rigid tube
/// is the rest; the plant states a growth relative to the chamber alone.
fn chamber_share(case: &Case) -> f64 {
    let tube_m3 = case.hard.as_ref().map_or(0.0, |_| Background::typical().tube_m3());
    let chamber = PlantParameters::default().chamber;
    let chamber_m3 = std::f64::consts::PI * chamber.radius_m.powi(2) * chamber.length_m;
    chamber_m3 / (chamber_m3 + tube_m3)
}

/// Whether the 95 % interval of a hidden effect's size contains the size that was hidden. `None`
/// where it was not named first, its size is not defined alike on both sides, or the report gives
/// no interval.
#[must_use]
pub fn covered(case: &Case, report: &Value) -> Option<bool> {
    let (Kind::Single | Kind::OneChannel, [effect], [argument]) =
        (case.kind, case.effects.as_slice(), case.arguments.as_slice())
    else {
        return None;
    };
    let (_, name, unit) = SAME.iter().find(|(id, ..)| id == effect)?;
    let size: f64 = argument.split_once('=')?.1.split('@').next()?.parse().ok()?;
    let share = if OF_THE_WALL.contains(&effect.as_str()) { chamber_share(case) } else { 1.0 };
    let cause = report["causes"].as_array()?.iter().find(|c| c["effect"] == effect.as_str())?;
    let ends = cause["parameters"][*name]["ci95"].as_array()?;
    let (low, high) = (ends.first()?.as_f64()?, ends.get(1)?.as_f64()?);
    Some((low..=high).contains(&(size * unit * share)))
}

/// Shares by kind and size: what the aims are stated in.
#[must_use]
pub fn summary(scored: &[(Case, Outcome, String)]) -> String {
    let mut groups: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for (case, outcome, _) in scored {
        let drive = if case.drive { "drive recorded" } else { "closed loop" };
        let (what, good): (&str, &[Outcome]) = match case.kind {
            Kind::Null => ("nothing hidden, nothing named", &[Outcome::Clean]),
            Kind::OffCatalogue => ("off the catalogue, nothing named", &[Outcome::Unnamed]),
            Kind::Single => ("one effect, right or tied", &[Outcome::Right, Outcome::Tied]),
            Kind::OneChannel => ("on one channel, right or tied", &[Outcome::Right, Outcome::Tied]),
            Kind::Pair => ("two effects, both and nothing else", &[Outcome::Right, Outcome::Tied]),
        };
        let sized = !matches!(case.kind, Kind::Null | Kind::OffCatalogue);
        let size = if sized { format!(", {}", case.size) } else { String::new() };
        let group = groups.entry(format!("{what}{size} ({drive})")).or_default();
        group.0 += usize::from(good.contains(outcome));
        group.1 += 1;
    }
    let line = |(name, (good, all)): (String, (usize, usize))| {
        format!("| {name} | {good} of {all} | {:.0} % |\n", 100.0 * good as f64 / all as f64)
    };
    let lines: String = groups.into_iter().map(line).collect();
    format!("| | cases | share |\n|---|--:|--:|\n{lines}")
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
        let row = if case.drive { row } else { format!("{row}, closed loop") };
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
    use super::super::plan::Hard;
    use super::*;
    use serde_json::json;

    fn report(causes: &[(&str, &[&str])]) -> Value {
        let causes: Vec<Value> =
            causes.iter().map(|(id, rivals)| json!({"effect": id, "equivalent": rivals})).collect();
        json!({ "causes": causes })
    }

    #[test]
    fn an_interval_covers_the_hidden_size_in_the_plants_unit() {
        let mut hidden = Case::moderate(Kind::Single, &["wall_creep"]);
        hidden.arguments = vec!["wall_creep=0.8".to_owned()];
        let with = |low: f64, high: f64| {
            json!({"causes": [{"effect": "wall_creep", "equivalent": [],
                "parameters": {"compliance": {"value": 0.08, "ci95": [low, high]}}}]})
        };
        assert_eq!(covered(&hidden, &with(0.07, 0.09)), Some(true));
        assert_eq!(covered(&hidden, &with(0.081, 0.09)), Some(false));
        assert_eq!(covered(&hidden, &report(&[("wall_creep", &[])])), None);
        // Behind the valves of hard rounds 57 ml of tube beside 362 ml of chamber do not give way:
        // the gas fills 0.0691 times more, not 0.08.
        hidden.hard =
            Some(Hard { rate_hz: 100.0, seconds: 60.0, stated_volume: 1.0, stated_supply: 1.0, jitter: 0.0 });
        assert_eq!(covered(&hidden, &with(0.069, 0.0692)), Some(true));
        assert_eq!(covered(&hidden, &with(0.07, 0.09)), Some(false));
        assert_eq!(covered(&hidden, &report(&[])), None);
    }

    #[test]
    fn every_outcome_is_told_from_the_others() {
        let single = Case::moderate(Kind::Single, &["valve_lag"]);
        assert_eq!(score(&single, &report(&[("valve_lag", &[])])), Outcome::Right);
        assert_eq!(score(&single, &report(&[("sensor_lag", &["valve_lag"])])), Outcome::Tied);
        assert_eq!(score(&single, &report(&[("a", &["b", "c", "valve_lag"])])), Outcome::Wrong);
        assert_eq!(score(&single, &report(&[])), Outcome::Missed);
        assert_eq!(score(&single, &report(&[("supply_sag", &[])])), Outcome::Wrong);
        assert_eq!(score(&single, &report(&[("valve_lag", &[]), ("supply_sag", &[])])), Outcome::Extra);
        assert_eq!(score(&Case::moderate(Kind::Null, &[]), &report(&[])), Outcome::Clean);
        assert_eq!(score(&Case::moderate(Kind::Null, &[]), &report(&[("valve_lag", &[])])), Outcome::Wrong);
        assert_eq!(score(&Case::moderate(Kind::OffCatalogue, &["x"]), &report(&[])), Outcome::Unnamed);
        let pair = Case::moderate(Kind::Pair, &["valve_lag", "supply_sag"]);
        assert_eq!(score(&pair, &report(&[("valve_lag", &[]), ("supply_sag", &[])])), Outcome::Right);
        assert_eq!(score(&pair, &report(&[("valve_lag", &[])])), Outcome::Wrong);
        assert_eq!(score(&pair, &report(&[("valve_lag", &["supply_sag"])])), Outcome::Wrong);
    }

    #[test]
    fn a_name_is_false_that_stands_for_nothing_hidden() {
        let pair = Case::moderate(Kind::Pair, &["valve_lag", "supply_sag"]);
        assert_eq!(false_names(&pair, &report(&[])), 0, "missed is not false");
        assert_eq!(false_names(&pair, &report(&[("sensor_lag", &["valve_lag"]), ("supply_sag", &[])])), 0);
        assert_eq!(false_names(&pair, &report(&[("valve_lag", &[]), ("sensor_lag", &["offset"])])), 1);
        assert_eq!(false_names(&Case::moderate(Kind::Null, &[]), &report(&[("valve_lag", &[])])), 1);
        let off = Case::moderate(Kind::OffCatalogue, &["valve_lag"]);
        assert_eq!(false_names(&off, &report(&[("valve_lag", &[])])), 1);
    }
}
