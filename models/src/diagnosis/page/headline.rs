//! The headline: the recording, what was found in it, and how sure that is.

use crate::diagnosis::json::{Cause, Report, Verdict};
use crate::diagnosis::report::verdict;

/// File and finding.
pub fn title(report: &Report) -> String {
    let file = std::path::Path::new(&report.data.file);
    let file =
        file.file_name().map_or_else(|| report.data.file.clone(), |name| name.to_string_lossy().into_owned());
    let causes = report.causes.iter().map(cause).collect::<Vec<_>>().join("; ");
    match report.verdict {
        Verdict::Adequate => format!("{file}: the model is adequate"),
        Verdict::Explained => format!("{file}: {causes}"),
        Verdict::PartlyExplained => format!("{file}: {causes}; and something more"),
        Verdict::Unexplained => format!("{file}: something that no name fits"),
    }
}

fn cause(cause: &Cause) -> String {
    let title = |id: &str| decapitalised(verdict::title(id));
    if !cause.equivalent.is_empty() {
        let all: Vec<String> =
            std::iter::once(&cause.effect).chain(&cause.equivalent).map(|id| title(id)).collect();
        return format!("one of: {}", all.join(", "));
    }
    format!("{}{}", if verdict::is_sure(cause) { "" } else { "probably " }, title(&cause.effect))
}

/// In the middle of a line, but for abbreviations.
fn decapitalised(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.clone().next()) {
        (Some(first), Some(second)) if second.is_lowercase() => first.to_lowercase().chain(letters).collect(),
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::json::Gain;
    use std::collections::BTreeMap;

    fn found(low: f64, p_value: f64, equivalent: &[&str]) -> String {
        of_probability(None, low, p_value, equivalent)
    }

    fn of_probability(probability: Option<f64>, low: f64, p_value: f64, equivalent: &[&str]) -> String {
        let gain = Gain {
            test_rmse_before_kpa: 2.0,
            test_rmse_after_kpa: 1.0,
            reduction: 0.5,
            ci95: [low, 0.6],
            weighted_ci95: [low, 0.6],
        };
        cause(&Cause {
            effect: "exhaust_leak".to_owned(),
            channels: Vec::new(),
            equivalent: equivalent.iter().map(|id| (*id).to_owned()).collect(),
            parameters: BTreeMap::new(),
            by_channel: BTreeMap::new(),
            p_value,
            probability,
            gain,
        })
    }

    #[test]
    fn what_is_uncertain_is_said_so() {
        assert!(!found(0.3, 0.001, &[]).contains("probably"));
        assert!(found(-0.4, 0.001, &[]).starts_with("probably "));
        assert!(found(0.3, 0.04, &[]).starts_with("probably "));
        assert!(!of_probability(Some(0.9), 0.3, 0.001, &[]).contains("probably"));
        assert!(of_probability(Some(0.4), 0.3, 0.001, &[]).starts_with("probably "));
        assert!(found(0.3, 0.001, &["valve_hysteresis"]).starts_with("one of: "));
    }
}
