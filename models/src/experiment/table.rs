//! A comparison as lines of text.

use crate::report::{Table, duration_text, number};

use super::{Comparison, ModelResult};

/// The head of the table, with units.
pub(super) const HEAD: [&str; 10] = [
    "model",
    "rollout R2",
    "RMSE kPa",
    "mean abs kPa",
    "IAE kPa s",
    "1-step R2",
    "1-step RMSE kPa",
    "on fit kPa",
    "evaluation",
    "starts agreeing",
];

/// One model's cells under [`HEAD`].
pub(super) fn cells(result: &ModelResult) -> Vec<String> {
    let (Some(rollout), Some(fit)) = (&result.rollout, &result.fit) else {
        let reason = result.error.as_deref().unwrap_or("no usable sample");
        return vec![result.model.name().to_owned(), format!("not possible: {reason}")];
    };
    let step = |value: &dyn Fn(&super::Score) -> f64, decimals| {
        result.one_step.as_ref().map_or_else(|| "n/a".to_owned(), |s| number(value(s), decimals))
    };
    vec![
        result.model.name().to_owned(),
        number(rollout.r2, 4),
        number(rollout.rmse_kpa, 3),
        number(rollout.mae_kpa, 3),
        number(rollout.iae_kpa_s, 2),
        step(&|s| s.r2, 4),
        step(&|s| s.rmse_kpa, 3),
        result.rollout_fitted.as_ref().map_or_else(|| "n/a".to_owned(), |s| number(s.rmse_kpa, 3)),
        result.evaluation_s.map_or_else(|| "n/a".to_owned(), duration_text),
        format!("{}/{}", fit.agreeing_starts, fit.starts.len()),
    ]
}

/// The comparison as text for a terminal: one table per channel, then all channels together.
#[must_use]
pub fn comparison_text(comparison: &Comparison) -> String {
    let mut text = format!(
        "fitted on the first {:.2} s, judged on the remaining {:.2} s\n",
        comparison.fit_seconds, comparison.test_seconds
    );
    for channel in &comparison.channels {
        let (possible, not): (Vec<_>, Vec<_>) =
            channel.models.iter().map(cells).partition(|c| c.len() == HEAD.len());
        let mut head = HEAD;
        let name = channel.channel.to_string();
        head[0] = &name;
        text.push_str(&format!("\n{}\n", Table::text(&head, &possible)));
        for cells in not {
            text.push_str(&format!("{}\n", cells.join(": ")));
        }
    }
    let head = ["all channels", "RMSE kPa", "mean R2", "IAE kPa s", "1-step R2", "evaluation", "fit time"];
    let rows: Vec<Vec<String>> = comparison
        .overall
        .iter()
        .map(|o| {
            vec![
                o.model.name().to_owned(),
                number(o.rollout_rmse_kpa, 3),
                number(o.rollout_r2, 4),
                number(o.rollout_iae_kpa_s, 2),
                number(o.one_step_r2, 4),
                duration_text(o.evaluation_s),
                duration_text(o.fit_s),
            ]
        })
        .collect();
    text.push_str(&format!("\n{}\n", Table::text(&head, &rows)));
    text
}
