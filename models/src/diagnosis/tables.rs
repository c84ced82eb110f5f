//! A report as tables of text: the same in a terminal and in a notebook.

use super::json;
use crate::report::{Table, behind, number, significant};

/// Head of the table of causes.
pub const CAUSES: [&str; 6] =
    ["cause", "channels", "size [95 %]", "test error, kPa", "gain [95 %]", "fits as well"];

/// Head of the table of recordings.
pub const RECORDINGS: [&str; 5] =
    ["recording", "channel", "load [95 %]", "test error before, kPa", "after, kPa"];
/// Head of the table of explanations.
pub const ALTERNATIVES: [&str; 3] = ["missing", "probability", "error where causes are chosen, kPa"];

/// The causes, a row each under [`CAUSES`].
#[must_use]
pub fn causes(report: &json::Report) -> Vec<Vec<String>> {
    report.causes.iter().map(cause).collect()
}

fn cause(cause: &json::Cause) -> Vec<String> {
    let size = |(name, estimate): (&String, &json::Estimate)| match estimate.ci95 {
        Some([low, high]) => format!(
            "{name} {} [{}, {}]{}",
            significant(estimate.value, 3),
            significant(low, 3),
            significant(high, 3),
            behind(&estimate.unit)
        ),
        None => format!("{name} not identifiable here"),
    };
    let gain = &cause.gain;
    vec![
        cause.effect.clone(),
        cause.channels.join(", "),
        cause.parameters.iter().map(size).collect::<Vec<_>>().join("; "),
        format!("{} to {}", number(gain.test_rmse_before_kpa, 2), number(gain.test_rmse_after_kpa, 2)),
        format!("{:.0} % [{:.0}, {:.0}]", 100.0 * gain.reduction, 100.0 * gain.ci95[0], 100.0 * gain.ci95[1]),
        if cause.equivalent.is_empty() { "-".to_owned() } else { cause.equivalent.join(", ") },
    ]
}

/// A size with its interval and unit.
fn load(name: &str, estimate: &json::Estimate) -> String {
    let unit = behind(&estimate.unit);
    let value = significant(estimate.value, 3);
    match (estimate.state.as_str(), estimate.ci95) {
        ("taken as the unit", _) => format!("{name} {value}{unit} (the unit)"),
        (_, Some([low, high])) => {
            format!("{name} {value} [{}, {}]{unit}", significant(low, 3), significant(high, 3))
        }
        (_, None) => format!("{name} not identifiable here"),
    }
}

/// The recordings of a machine with their loads, a row for each channel under [`RECORDINGS`].
#[must_use]
pub fn recordings(report: &json::Report) -> Vec<Vec<String>> {
    let all = report.machine.iter().flat_map(|machine| &machine.recordings);
    all.flat_map(|record| record.load.iter().map(move |(channel, sizes)| (record, channel, sizes)))
        .map(|(record, channel, sizes)| {
            let sizes: Vec<String> = sizes.iter().map(|(name, size)| load(name, size)).collect();
            vec![
                record.file.clone(),
                channel.clone(),
                sizes.join("; "),
                number(record.test_rmse_before_kpa, 3),
                number(record.test_rmse_after_kpa, 3),
            ]
        })
        .collect()
}

/// Explanations with their probabilities, a row each under [`ALTERNATIVES`].
#[must_use]
pub fn alternatives(report: &json::Report) -> Vec<Vec<String>> {
    let line = |one: &json::Alternative| {
        vec![one.causes.join(" + "), number(one.probability, 3), number(one.select_rmse_kpa, 3)]
    };
    report.alternatives.iter().map(line).collect()
}

/// Every table of a report that has rows, as text; of explanations only where they are asked for.
#[must_use]
pub fn text(report: &json::Report, explanations: bool) -> Vec<String> {
    let mut parts = Vec::new();
    if !report.causes.is_empty() {
        parts.push(Table::text(&CAUSES, &causes(report)));
    }
    if report.machine.is_some() {
        parts.push(Table::text(&RECORDINGS, &recordings(report)));
    }
    if explanations && !report.alternatives.is_empty() {
        parts.push(Table::text(&ALTERNATIVES, &alternatives(report)));
    }
    parts
}
