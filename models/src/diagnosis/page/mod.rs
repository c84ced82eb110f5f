//! `report.html`: the result for a person who knows valves and no statistics.

pub mod alternatives;
mod causes;
mod headline;
mod measured;
mod symptoms;
mod whole;

use crate::diagnosis::json::NextExperiment;
use crate::diagnosis::report::verdict;
use crate::diagnosis::run::Diagnosis;
use crate::diagnosis::settings::{self, SETTINGS};
use crate::report::{
    Align, Markup, Page, PlotError, Table, folded, html, notes, paragraph, significant, with_code,
};

/// The page. `footer` names the program, the data and the date.
///
/// # Errors
/// [`PlotError`] when a plot cannot be drawn.
pub fn page(diagnosis: &Diagnosis, footer: &str) -> Result<String, PlotError> {
    let report = &diagnosis.report;
    let mut page = Page::new(headline::title(report), report.sentence.clone(), footer);
    page.section("How large the error is", error_bars(diagnosis));
    if !report.causes.is_empty() {
        page.section("Causes", causes::markup(report));
    }
    if !report.imperfections.is_empty() {
        page.section("Modelled, but not named", causes::unnamed(report));
    }
    page.section("How probable each explanation is", alternatives::markup(report, "blocks"));
    if let Some(next) = &report.next_experiment {
        page.section("Next experiment", next_experiment(next));
    }
    page.section("The recording", whole::markup(diagnosis)?);
    page.section("Measured and simulated", measured::markup(diagnosis)?);
    page.section("Symptoms of the model without causes", symptoms::markup(diagnosis, true)?);
    page.section("What stays unexplained", unexplained(diagnosis)?);
    page.section("How this was decided", method(diagnosis));
    Ok(page.html())
}

/// The error before and after beside the sensor's noise, as bars.
fn error_bars(diagnosis: &Diagnosis) -> Markup {
    let report = &diagnosis.report;
    let mut bars = vec![("the model as it was", "before", report.baseline.test_rmse_kpa)];
    if !report.causes.is_empty() {
        bars.push(("with the causes", "after", report.unexplained.test_rmse_kpa));
    } else if !report.imperfections.is_empty() {
        bars.push(("with what has no name", "after", report.unexplained.test_rmse_kpa));
    }
    if let Some(corrected) = &report.unexplained.correction {
        bars.push(("with the smooth correction", "after", corrected.gain.test_rmse_after_kpa));
    }
    let allowed_kpa = report.checks.allowed_rmse_kpa;
    if allowed_kpa > 1.05 * report.baseline.noise_floor_kpa {
        bars.push(("noise and a usual wander of the supply", "noise", allowed_kpa));
    }
    bars.push(("sensor noise", "noise", report.baseline.noise_floor_kpa));
    self::bars(&bars)
}

/// Errors as bars: what, its class (`before`, `after`, `noise`), kPa.
pub fn bars(lines: &[(&str, &str, f64)]) -> Markup {
    let longest = lines.iter().map(|b| b.2).fold(f64::MIN_POSITIVE, f64::max);
    html! {
        div.bars {
            @for (what, class, kpa) in lines {
                div.bar {
                    span.what { (what) }
                    span.track {
                        i class=(class) style=(format!("width:{:.1}%", 68.0 * kpa / longest)) {}
                        b { (significant(*kpa, 2)) " kPa" }
                    }
                }
            }
        }
        p.caption {
            "Root mean square difference between measured and simulated pressure on test data. No simulation can be better than the noise of the sensor."
        }
    }
}

fn next_experiment(next: &NextExperiment) -> Markup {
    let mut table = Table::new(&[
        ("Considered", Align::Left),
        ("length, s", Align::Right),
        ("difference, kPa", Align::Right),
        ("over the noise", Align::Right),
    ]);
    let noise = next.separation_kpa / next.separation_noise;
    for c in &next.considered {
        let row = [
            c.excitation.replace('_', " "),
            format!("{:.0}", c.seconds),
            significant(c.separation_kpa, 2),
            significant(c.separation_kpa / noise, 2),
        ];
        if c.excitation == next.excitation { table.highlighted_row(row) } else { table.row(row) }
    }
    html! {
        div.todo { (with_code(&next.reason)) (with_code(&next.instruction)) }
        (table.caption("How far the predictions of the two nearest rivals would be apart after each is refitted:").markup())
    }
}

fn unexplained(diagnosis: &Diagnosis) -> Result<Markup, PlotError> {
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
    let corrected = left.correction.as_ref().map(|corrected| {
        let g = &corrected.gain;
        let along: std::collections::BTreeSet<&str> = corrected.along.values().map(String::as_str).collect();
        let along = along.into_iter().collect::<Vec<_>>().join(", ");
        format!(
            "A smooth correction of it ({along}), fitted without a name and part of the extended model, changes the error on the test blocks from {:.2} to {:.2} kPa ({:.0} % less, 95 % interval {:.0} to {:.0} %).",
            g.test_rmse_before_kpa,
            g.test_rmse_after_kpa,
            100.0 * g.reduction,
            100.0 * g.ci95[0],
            100.0 * g.ci95[1]
        )
    });
    let band = report.checks.band_holds.map(|held| {
        format!(
            "The extended model has a 95 % band around what it simulates (`simulate --band`). It holds {:.1} % of the readings of the test blocks.",
            100.0 * held
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
        @if let Some(text) = band { (paragraph(&text)) }
        (plots)
    })
}

fn method(diagnosis: &Diagnosis) -> Markup {
    let report = &diagnosis.report;
    let [fit, select, test] = report.checks.blocks;
    let of = if report.asked.is_empty() { "the whole catalogue" } else { "what was asked about" };
    let lines = [
        format!(
            "The recording ({:.0} s, {} rows, {:.1} Hz) was cut into blocks of {:.1} s: {fit} to fit parameters, {select} to choose causes, {test} to measure the gain and nothing else.",
            report.data.seconds, report.data.rows, report.data.rate_hz, report.checks.block_s
        ),
        "Errors are those of simulations that run through the whole recording from drives or commands alone; in each block only the start pressure is taken from the data.".to_owned(),
        format!(
            "An effect is named when random chance over {of} makes its trace in the error unlikely (p at most {}), when it makes blocks that were not fitted better beyond their differences, and by at least {:.0} % ({:.0} % beside a loop that hunts, {:.0} % in a loop whose samples come late).",
            SETTINGS.level,
            100.0 * SETTINGS.practical,
            100.0 * SETTINGS.practical_limit_cycle,
            100.0 * SETTINGS.practical_roughly_timed
        ),
        format!(
            "Slow wander of the supply by about {:.0} % counts as normal and is not named; with the noise it leaves an error of {:.2} kPa where the model is right. More than {} times that counts as unexplained.",
            100.0 * SETTINGS.supply_level,
            report.checks.allowed_rmse_kpa,
            SETTINGS.beyond
        ),
        format!("Halving the integration step changes the simulation by {:.3} kPa RMS.", report.checks.halved_step_rms_kpa),
    ];
    html! {
        (notes(&lines))
        @if !report.asked.is_empty() {
            (paragraph(&format!("{} Probabilities are among these, nothing, and something without a name; whether it is another effect was not tried.", verdict::asked_about(&report.asked).trim())))
        }
        @if !report.notes.is_empty() { h3 { "About the data" } (notes(&report.notes)) }
        (folded("Every level, prior and threshold", &settings_table()))
    }
}

/// What decides the result, with reasons.
pub fn settings_table() -> Markup {
    let columns = [("Setting", Align::Left), ("value", Align::Right), ("what it is, and why", Align::Left)];
    let mut table = Table::new(&columns).stacked();
    for setting in settings::list() {
        let words = format!("{} {}", setting.meaning, setting.reason);
        table.markup_row(vec![
            html! { code { (setting.name) } },
            html! { (setting.value) },
            html! { (words) },
        ]);
    }
    table.markup()
}
