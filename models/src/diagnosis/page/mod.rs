//! `report.html`: the result for a person who knows valves and no statistics.

mod causes;
mod measured;
mod symptoms;

use super::json::Verdict;
use super::run::Diagnosis;
use crate::report::{Page, PlotError, html, notes, paragraph};

/// The page. `footer` names the program, the data and the date.
///
/// # Errors
/// [`PlotError`] when a plot cannot be drawn.
pub fn page(diagnosis: &Diagnosis, footer: &str) -> Result<String, PlotError> {
    let report = &diagnosis.report;
    let title = match report.verdict {
        Verdict::Adequate => "Diagnosis: the model is adequate",
        Verdict::Explained => "Diagnosis: explained",
        Verdict::PartlyExplained => "Diagnosis: partly explained",
        Verdict::Unexplained => "Diagnosis: something no name fits",
    };
    let mut page = Page::new(title, report.sentence.clone(), footer);
    if !report.causes.is_empty() {
        page.section("Causes", causes::markup(report));
    }
    if let Some(next) = &report.next_experiment {
        page.section(
            "Next experiment",
            html! {
                (paragraph(&next.instruction))
                p { "Command file: " code { (next.trajectory) } }
            },
        );
    }
    page.section("Measured and simulated", measured::markup(diagnosis)?);
    page.section("Symptoms of the model without causes", symptoms::markup(diagnosis, true)?);
    page.section("What stays unexplained", unexplained(diagnosis)?);
    page.section("How this was decided", method(diagnosis));
    Ok(page.html())
}

fn unexplained(diagnosis: &Diagnosis) -> Result<crate::report::Markup, PlotError> {
    let report = &diagnosis.report;
    let left = &report.unexplained;
    let words = if left.depends_on.is_empty() {
        "What remains shows no dependence on drive, direction, pressure, flow, time or neighbours beyond chance.".to_owned()
    } else {
        let list: Vec<String> = left
            .depends_on
            .iter()
            .map(|s| {
                let what = s.what.replace("the residual depends on ", "");
                format!(
                    "{what} (accounts for {:.0} % of the squared error on blocks not fitted, channel {})",
                    100.0 * s.share,
                    s.channel
                )
            })
            .collect();
        format!("What remains still depends on {}.", list.join("; "))
    };
    let share = format!(
        "Of the base model's squared error above the sensor noise, {:.0} % is left (slow wander of the supply by 1 % and uncertain start pressures set aside).",
        100.0 * left.share
    );
    let corrected = left.correction.as_ref().map(|g| {
        format!(
            "A smooth correction of it, fitted without a name, changes the error on the test blocks from {:.2} to {:.2} kPa ({:.0} % less, 95 % interval {:.0} to {:.0} %).",
            g.test_rmse_before_kpa,
            g.test_rmse_after_kpa,
            100.0 * g.reduction,
            100.0 * g.ci95[0],
            100.0 * g.ci95[1]
        )
    });
    let plots = if left.depends_on.is_empty() || report.causes.is_empty() {
        html! {}
    } else {
        symptoms::markup(diagnosis, false)?
    };
    Ok(html! {
        (paragraph(&words))
        (paragraph(&share))
        @if let Some(text) = corrected { (paragraph(&text)) }
        (plots)
    })
}

fn method(diagnosis: &Diagnosis) -> crate::report::Markup {
    let report = &diagnosis.report;
    let [fit, select, test] = report.checks.blocks;
    let lines = [
        format!(
            "The recording ({:.0} s, {} rows, {:.1} Hz) was cut into blocks of {:.1} s: {fit} to fit parameters, {select} to choose causes, {test} to measure the gain and nothing else.",
            report.data.seconds, report.data.rows, report.data.rate_hz, report.checks.block_s
        ),
        "Errors are those of simulations that run through the whole recording from drives or commands alone; in each block only the start pressure is taken from the data.".to_owned(),
        "An effect is named when random chance over the whole catalogue makes its trace in the error unlikely (p at most 0.05), when it makes blocks that were not fitted better beyond their differences, and by at least 1 %.".to_owned(),
        "Slow wander of the supply by about 1 % counts as normal and is not named.".to_owned(),
        format!("Halving the integration step changes the simulation by {:.3} kPa RMS.", report.checks.halved_step_rms_kpa),
    ];
    html! {
        (notes(&lines))
        @if !report.notes.is_empty() { h3 { "About the data" } (notes(&report.notes)) }
    }
}
