//! The table of causes.

use crate::diagnosis::json::{Cause, Report};
use crate::diagnosis::verdict;
use crate::effects::catalogue::{CATALOGUE, index_of};
use crate::report::{Align, Markup, Table, html, significant};

/// Table and, for every cause, what it is and where to look.
pub fn markup(report: &Report) -> Markup {
    let mut table = Table::new(&[
        ("Cause", Align::Left),
        ("Channels", Align::Left),
        ("Size (95 % interval)", Align::Left),
        ("Error before, kPa", Align::Right),
        ("after, kPa", Align::Right),
        ("Gain (95 % interval)", Align::Right),
        ("Fits as well", Align::Left),
    ]);
    for cause in &report.causes {
        let g = &cause.gain;
        table.markup_row(vec![
            html! { (verdict::title(&cause.effect)) br; code { (cause.effect) } },
            html! { (channels(report, cause)) },
            html! { @for line in sizes(cause) { (line) br; } },
            html! { (format!("{:.2}", g.test_rmse_before_kpa)) },
            html! { (format!("{:.2}", g.test_rmse_after_kpa)) },
            html! { (format!("{:.0} % ({:.0} to {:.0})", 100.0 * g.reduction, 100.0 * g.ci95[0], 100.0 * g.ci95[1])) },
            html! { @if cause.equivalent.is_empty() { "nothing else" } @else {
                @for id in &cause.equivalent { (verdict::title(id)) br; }
            } },
        ]);
    }
    html! {
        (table.markup())
        @for cause in &report.causes {
            @if let Some(info) = index_of(&cause.effect).map(|k| CATALOGUE[k]) {
                h3 { (info.title) }
                p { (info.physics) " " code { (info.equation) } }
                p { "Look at: " (info.check) "." }
                @if !cause.equivalent.is_empty() {
                    p { "This recording cannot tell it from " (rivals(cause)) ". What would: " (info.separated_by) "." }
                }
            }
        }
    }
}

fn rivals(cause: &Cause) -> String {
    cause.equivalent.iter().map(|id| verdict::title(id)).collect::<Vec<_>>().join(" or ")
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
            let unit = if e.unit == "1" { String::new() } else { format!(" {}", e.unit) };
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
                None => format!("{name} not identifiable here"),
            }
        })
        .collect()
}
