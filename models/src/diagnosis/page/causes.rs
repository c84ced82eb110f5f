//! The table of causes, and for each what it is, how large, and where to look.

use std::collections::BTreeMap;

use crate::diagnosis::json::{Cause, Estimate, Report, Unnamed};
use crate::diagnosis::report::verdict;
use crate::effects::catalogue::{CATALOGUE, index_of};
use crate::effects::{EffectInfo, EffectParameter};
use crate::report::{Align, Interval, Intervals, Markup, Table, behind, html, paragraph, significant};

/// Table and, for every cause, what it is and where to look.
pub fn markup(report: &Report) -> Markup {
    html! {
        (table(report, report.causes.iter()))
        @for cause in &report.causes {
            @if let Some(info) = index_of(&cause.effect).map(|k| CATALOGUE[k]) { (details(info, cause)) }
        }
    }
}

/// What is modelled without a name, and why it has none.
pub fn unnamed(report: &Report) -> Markup {
    html! {
        (paragraph("Some effect of the catalogue always describes a part of what a model lacks. These make the simulation better, and the extended model has them; but they are no larger than sound rigs show, may be nothing, have no gain on the test blocks that is sure and worth a name, do no more than any smooth correction would, are improbable, or of a size that the recording does not tell."))
        (table(report, report.imperfections.iter().map(|i| &i.cause)))
        @for i in &report.imperfections {
            p { (verdict::title(&i.cause.effect)) ": " (match i.why {
                Unnamed::Usual => "no larger than usual, or, in closed loop, maybe nothing; or another effect that is no larger than usual fits as well.",
                Unnamed::Imitated => "beside what is named, a smooth function of one measured variable does as much.",
                Unnamed::Improbable => "it is less probable than not, or, where several others do as well, than 80 %.",
                Unnamed::Undetermined => "as far as this recording tells its size it may be nothing, and in closed loop it then may be what another cause leaves.",
                Unnamed::Gainless => "no gain of more than 1 % on the test blocks, neither gain nor size is surely more than nothing, or beside a larger cause neither the gain is surely more than 1 % nor the cause itself is sure, or the gain is less than 1 % of the whole error.",
            }) }
        }
    }
}

fn table<'a>(report: &Report, causes: impl Iterator<Item = &'a Cause>) -> Markup {
    let mut table = Table::new(&[
        ("Cause", Align::Left),
        ("Channels", Align::Left),
        ("Size (95 % interval)", Align::Left),
        ("Error without it, kPa", Align::Right),
        ("with it, kPa", Align::Right),
        ("Error less by (95 % interval)", Align::Right),
        ("Fits as well", Align::Left),
    ])
    .stacked();
    // What was not in question was not tried.
    let none = if report.asked.is_empty() { "nothing else" } else { "nothing else that was asked about" };
    for cause in causes {
        let g = &cause.gain;
        // Adding zero makes -0 a 0.
        let [low, high] = g.ci95.map(|part| (100.0 * part).round() + 0.0);
        table.markup_row(vec![
            html! { (verdict::title(&cause.effect)) br; code { (cause.effect) } },
            html! { (channels(report, cause)) },
            html! { @for line in sizes(cause) { (line) br; } },
            html! { (format!("{:.2}", g.test_rmse_before_kpa)) },
            html! { (format!("{:.2}", g.test_rmse_after_kpa)) },
            html! { (format!("{:.0} %", 100.0 * g.reduction)) br; (format!("({low:.0} to {high:.0})")) },
            html! { @if cause.equivalent.is_empty() { (none) } @else {
                @for id in &cause.equivalent { (verdict::title(id)) br; }
            } },
        ]);
    }
    table.markup()
}

fn details(info: &EffectInfo, cause: &Cause) -> Markup {
    html! {
        h3 { (info.title) }
        p { (info.physics) }
        p { "Look at: " (info.check) "." }
        @if !cause.equivalent.is_empty() {
            p { "This recording cannot tell it from " (rivals(cause)) ". What would: " (info.separated_by) "." }
        }
        @for parameter in info.parameters { (intervals(parameter, cause)) }
        p.caption { "As it is simulated: " code { (info.equation) } }
    }
}

/// The values of one parameter on all channels; where there is only one, the table says it all.
fn intervals(parameter: &EffectParameter, cause: &Cause) -> Markup {
    let line = |label: &str, estimates: &BTreeMap<String, Estimate>, bold: bool| {
        let e = estimates.get(parameter.name)?;
        Some(Interval { label: label.to_owned(), value: e.value, range: e.ci95, bold })
    };
    let mut lines: Vec<Interval> =
        cause.by_channel.iter().filter_map(|(id, estimates)| line(id, estimates, false)).collect();
    if lines.len() > 1 {
        lines.extend(line("all", &cause.parameters, true));
    }
    // Where the effect is absent belongs in the picture unless that is at infinity, which the
    // bounds only stand for.
    let first = index_of(&cause.effect).is_some_and(|k| CATALOGUE[k].parameters[0].name == parameter.name);
    let absent = first && (parameter.null <= parameter.lower || parameter.null >= parameter.upper);
    let near = lines.iter().all(|l| (l.value - parameter.null).abs() <= 20.0 * l.value.abs());
    Intervals {
        title: format!("{}{}", capitalised(parameter.meaning), unit(parameter.unit)),
        lines,
        mark: (absent && near).then(|| (parameter.null, "where the effect would be absent".to_owned())),
    }
    .markup()
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn unit(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(", {unit}") }
}

fn rivals(cause: &Cause) -> String {
    cause.equivalent.iter().map(|id| format!("\"{}\"", verdict::title(id))).collect::<Vec<_>>().join(" or ")
}

fn channels(report: &Report, cause: &Cause) -> String {
    if cause.channels.len() == report.baseline.channels.len() && cause.channels.len() > 1 {
        "all".to_owned()
    } else {
        cause.channels.join(", ")
    }
}

fn sizes(cause: &Cause) -> Vec<String> {
    cause
        .parameters
        .iter()
        .map(|(name, e)| {
            let unit = behind(&e.unit);
            let name = name.replace('_', " ");
            match e.ci95 {
                Some([low, high]) => {
                    format!(
                        "{name} {}{unit} ({} to {})",
                        significant(e.value, 3),
                        significant(low, 3),
                        significant(high, 3)
                    )
                }
                None => format!("{name} not determined here"),
            }
        })
        .collect()
}
