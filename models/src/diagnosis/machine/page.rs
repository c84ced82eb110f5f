//! `report.html` of a machine.

use super::report::short;
use super::run::MachineDiagnosis;
use super::search::NamedCause;
use crate::diagnosis::channel::Role;
use crate::diagnosis::json::{Estimate, Report, Verdict};
use crate::diagnosis::page::{alternatives, bars, settings_table};
use crate::diagnosis::report::verdict;
use crate::effects::catalogue::CATALOGUE;
use crate::report::{
    Align, Colour, Interval, Intervals, Markup, Page, Plot, PlotError, Table, folded, html, notes, paragraph,
    significant,
};

/// The page. `footer` names the program, the data and the date.
///
/// # Errors
/// [`PlotError`] when a plot cannot be drawn.
pub fn page(diagnosis: &MachineDiagnosis, footer: &str) -> Result<String, PlotError> {
    let report = &diagnosis.report;
    let mut page = Page::new(title(report), report.sentence.clone(), footer);
    page.section("How large the error is", error_bars(report));
    for (named, cause) in diagnosis.findings.causes.iter().zip(&report.causes) {
        page.section(verdict::title(&cause.effect), details(diagnosis, named));
    }
    page.section("How probable each explanation is", alternatives::markup(report, "recordings"));
    page.section("The loads", loads(diagnosis));
    page.section("Measured and simulated", measured(diagnosis)?);
    page.section("How this was decided", method(diagnosis));
    Ok(page.html())
}

fn title(report: &Report) -> String {
    let recordings = report.machine.as_ref().map_or(&[][..], |machine| &machine.recordings[..]);
    let which = match recordings {
        [one] => short(&one.file),
        several => format!("{} recordings of one machine", several.len()),
    };
    let names = report.causes.iter().map(|c| {
        let sure = c.probability.is_some_and(|p| p >= 0.95) && c.equivalent.is_empty();
        format!("{}{}", if sure { "" } else { "probably " }, verdict::title(&c.effect).to_lowercase())
    });
    let names = names.collect::<Vec<_>>().join("; ");
    match report.verdict {
        Verdict::Adequate => format!("{which}: the model is adequate"),
        Verdict::Explained => format!("{which}: {names}"),
        Verdict::PartlyExplained => format!("{which}: {names}; and something more"),
        Verdict::Unexplained => format!("{which}: something that no name fits"),
    }
}

fn error_bars(report: &Report) -> Markup {
    let mut lines = vec![("the model as it was", "before", report.baseline.test_rmse_kpa)];
    if !report.causes.is_empty() {
        lines.push(("with the causes", "after", report.unexplained.test_rmse_kpa));
    }
    lines.push(("sensor noise", "noise", report.baseline.noise_floor_kpa));
    let mut table = Table::new(&[
        ("Recording", Align::Left),
        ("error before, kPa", Align::Right),
        ("after, kPa", Align::Right),
        ("discrepancy before, kPa", Align::Right),
        ("after, kPa", Align::Right),
    ]);
    for r in report.machine.iter().flat_map(|machine| &machine.recordings) {
        let kpa = |value: f64| significant(value, 2);
        table.row([
            short(&r.file),
            kpa(r.test_rmse_before_kpa),
            kpa(r.test_rmse_after_kpa),
            kpa(r.discrepancy_before_kpa),
            kpa(r.discrepancy_after_kpa),
        ]);
    }
    html! {
        (bars(&lines))
        (table.caption("Errors are those of rollouts over the last third of each recording. The discrepancy is what the likelihood needs beside the noise, as a deviation of the reading that lasts 0.3 s: what the simulation gets wrong.").markup())
    }
}

fn details(diagnosis: &MachineDiagnosis, named: &NamedCause) -> Markup {
    let info = CATALOGUE[named.effect];
    let gain = &named.gain;
    let [low, high] = gain.ci95.map(|g| 100.0 * g);
    let words = format!(
        "With it the error falls from {:.3} to {:.3} kPa, {:.0} % less (95 % interval {low:.0} to {high:.0} %). Probability of all explanations with it: {:.2}.",
        gain.test_rmse_before_kpa,
        gain.test_rmse_after_kpa,
        100.0 * gain.reduction,
        named.probability
    );
    let rivals: Vec<&str> = named.equivalent.iter().map(|&e| CATALOGUE[e].title).collect();
    html! {
        p { (info.physics) }
        (paragraph(&words))
        @if !rivals.is_empty() {
            p { "These recordings cannot tell it from: " (rivals.join(", ")) ". What would: " (info.separated_by) "." }
        }
        p { "Look at: " (info.check) "." }
        @if let Some(size) = info.derived() {
            (sizes(diagnosis, &format!("{}.{}", info.id, size.name), size.meaning, size.unit))
        }
        @for p in info.parameters { (sizes(diagnosis, &format!("{}.{}", info.id, p.name), p.meaning, p.unit)) }
        p.caption { "As it is simulated: " code { (info.equation) } }
    }
}

/// The values of one parameter in all recordings.
fn sizes(diagnosis: &MachineDiagnosis, name: &str, meaning: &str, unit: &str) -> Markup {
    let several = diagnosis.channels.len() > 1;
    let line = |label: String, e: &Estimate| Interval { label, value: e.value, range: e.ci95, bold: false };
    let files: Vec<String> = diagnosis
        .report
        .machine
        .iter()
        .flat_map(|machine| &machine.recordings)
        .map(|r| short(&r.file))
        .collect();
    let mut lines = Vec::new();
    for (channel, sizes) in diagnosis.channels.iter().zip(&diagnosis.findings.sizes) {
        let place = |what: &str| if several { format!("{what} {}", channel.id) } else { what.to_owned() };
        lines.extend(sizes.machine.get(name).map(|e| line(place("machine"), e)));
        let loads = files.iter().zip(&sizes.loads);
        lines.extend(loads.filter_map(|(file, load)| load.get(name).map(|e| line(place(file), e))));
    }
    let unit = if unit == "1" { String::new() } else { format!(", {unit}") };
    html! { @if !lines.is_empty() { (Intervals { title: format!("{meaning}{unit}"), lines, mark: None }.markup()) } }
}

fn loads(diagnosis: &MachineDiagnosis) -> Markup {
    let scale = super::fit::scale_of_load().map(|effect| CATALOGUE[effect]);
    let known = diagnosis.findings.known;
    let words = if known {
        "The volume behind the valves, over that with which the machine was calibrated."
    } else {
        "The volume behind the valves, over that of the first recording: absolute volumes and openings cannot be told from pressures and drives alone, ratios can."
    };
    html! {
        (paragraph(words))
        @if let Some(info) = scale {
            @for p in info.parameters { (sizes(diagnosis, &format!("{}.{}", info.id, p.name), "Volume, relative", p.unit)) }
        }
    }
}

fn measured(diagnosis: &MachineDiagnosis) -> Result<Markup, PlotError> {
    let findings = &diagnosis.findings;
    let mut figures = Vec::new();
    for (k, channel) in diagnosis.channels.iter().enumerate() {
        for (r, data) in channel.recorded.iter().enumerate() {
            let Some(span) = data.blocks.iter().zip(&data.spans).find(|(b, _)| b.role == Role::Test) else {
                continue;
            };
            let span = span.1.clone();
            let record = diagnosis.report.machine.as_ref().and_then(|machine| machine.recordings.get(r));
            let name = record.map_or_else(String::new, |record| short(&record.file));
            let time = |row: usize| data.inputs.time_s[data.rows[row] as usize];
            let line = |values: &[f64]| span.clone().map(|row| (time(row), values[row])).collect::<Vec<_>>();
            let before = data.readings(&findings.base.models[k].models[r]);
            let mut plot =
                Plot::new(format!("{name} {}: the last third", channel.id), "time, s", "pressure, kPa gauge")
                    .line("measured", Colour::Measured, line(&data.measured_kpa))
                    .line("simulated, base model", Colour::Orange, line(&before));
            if !findings.causes.is_empty() {
                let after = data.readings(&findings.sizes[k].models.models[r]);
                plot = plot.line("causes modelled", Colour::Blue, line(&after));
            }
            figures.push(plot.markup()?);
        }
    }
    Ok(html! {
        (paragraph("Rollouts from the recording's first row on, given the drives and nothing else."))
        @for figure in figures { (figure) }
    })
}

fn method(diagnosis: &MachineDiagnosis) -> Markup {
    let report = &diagnosis.report;
    let curves = if diagnosis.findings.known {
        "Valves, supply and sensor were taken from the calibrated model; only the load was fitted."
    } else {
        "Valves, supply and sensor are alike in all recordings; volume, tube and walls are each recording's own."
    };
    let lines = [
        curves.to_owned(),
        "The first 45 % of every recording fit, the next 19 % choose causes, the rest measures the gain and nothing else. For that each recording is left out once: the machine is fitted to the others, the load to the first part of the recording.".to_owned(),
        "A cause is named when it is the likeliest of the catalogue, likelier than a smooth correction without a name, and takes at least 20 % of the error with a 95 % interval above 1 %. A second cause must be the only one that does so beside the first.".to_owned(),
        "Intervals of sizes count how long errors last, and how far estimates move when one recording is left out.".to_owned(),
        format!("Halving the integration step changes the simulation by {:.3} kPa RMS.", report.checks.halved_step_rms_kpa),
    ];
    html! {
        (notes(&lines))
        @if !report.notes.is_empty() { h3 { "About the data" } (notes(&report.notes)) }
        (folded("Every level, prior and threshold", &settings_table()))
    }
}
