//! The page of a comparison.

mod curves;

use crate::data::{Channel, QualityReport, Recording};
use crate::fit::{Bound, Fit, Reason};
use crate::report::{Align, Markup, Page, PlotError, Table, html, notes, number, paragraph, significant};

use self::curves::Curves;
use super::table::{HEAD, cells};
use super::{ChannelComparison, Comparison, ModelResult};

/// Where a page comes from; said at its foot, so that it can be made again.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Origin {
    /// Program and version.
    pub program: String,
    /// Date and time, RFC 3339.
    pub created: String,
    /// The command line.
    pub command: String,
}

/// A judging part longer than this, s, gets a picture of its worst moment too.
const ZOOM_ABOVE_S: f64 = 40.0;

/// The page as HTML.
///
/// # Errors
/// [`PlotError`] when a plot cannot be drawn.
pub fn comparison_page(
    comparison: &Comparison,
    recording: &Recording,
    quality: &QualityReport,
    origin: &Origin,
) -> Result<String, PlotError> {
    let name = std::path::Path::new(&recording.source.file);
    let name = name.file_name().map_or(recording.source.file.clone(), |n| n.to_string_lossy().into_owned());
    let footer = format!(
        "{}, {}. Data: {} (SHA-256 {}). Command: {}",
        origin.program, origin.created, recording.source.file, recording.source.sha256, origin.command
    );
    let mut page = Page::new(format!("Pressure models on {name}"), lead(comparison), footer);
    if comparison.channels.len() > 1 {
        page.section("All channels", overall(comparison));
    }
    for result in &comparison.channels {
        let Ok(channel) = recording.channel(result.channel) else { continue };
        page.section(
            &format!("Channel {}", result.channel),
            channel_section(result, channel, comparison, recording)?,
        );
    }
    page.section("Parameters", parameters(comparison));
    page.section("How to read this", notes(&READING));
    page.section("Data quality", notes(&quality.sentences()));
    Ok(page.html())
}

const READING: [&str; 6] = [
    "Rollout: the model gets the commands or drives alone and one measured pressure at the start; everything after that is its own prediction. This is what a controller or a learner that plans ahead lives on.",
    "One-step: the model gets the measured pressure of every row and predicts only the next one. R2 is that of the pressure's change, because the pressure itself hardly changes in one step; sensor noise limits it.",
    "RMSE: root mean square error. IAE: integral of the absolute error over time, which grows with the length of the judged part.",
    "Evaluation: one evaluation of the model's right-hand side at one measured sample, in double precision on one core, inputs prepared included.",
    "Starts agreeing: how many of the fit's random starts ended within a ten-thousandth of the least sum of squares. Few mean that the surface has many valleys.",
    "Intervals are 95 % and allow for residuals that are correlated in time. They assume the model's form: where the residuals show structure, they say how well the number is determined, not how true it is.",
];

fn lead(comparison: &Comparison) -> String {
    let mut parts: Vec<String> = Vec::new();
    for (place, model) in comparison.ranking.iter().enumerate() {
        let Some(o) = comparison.overall.iter().find(|o| o.model == *model) else { continue };
        let kpa = number(o.rollout_rmse_kpa, 3);
        parts.push(if place == 0 {
            format!(
                "Fitted on the first {:.1} s and left alone for the following {:.1} s, the {} model stays within {kpa} kPa (root mean square)",
                comparison.fit_seconds,
                comparison.test_seconds,
                model.name()
            )
        } else {
            format!("the {} model within {kpa} kPa", model.name())
        });
    }
    let stopped =
        if comparison.stopped { " The fits were stopped early; the best found so far is shown." } else { "" };
    format!("{}.{stopped}", parts.join(", "))
}

fn overall(comparison: &Comparison) -> Markup {
    let (l, r) = (Align::Left, Align::Right);
    let mut table = Table::new(&[
        ("model", l),
        ("channels", r),
        ("rollout RMSE (kPa)", r),
        ("mean R2", r),
        ("sum of IAE (kPa s)", r),
        ("mean one-step R2", r),
        ("evaluation", r),
        ("time of all fits", r),
    ]);
    for o in &comparison.overall {
        let row = [
            o.model.name().to_owned(),
            o.channels.to_string(),
            number(o.rollout_rmse_kpa, 3),
            number(o.rollout_r2, 4),
            number(o.rollout_iae_kpa_s, 2),
            number(o.one_step_r2, 4),
            crate::report::duration_text(o.evaluation_s),
            crate::report::duration_text(o.fit_s),
        ];
        if comparison.ranking.first() == Some(&o.model) { table.highlighted_row(row) } else { table.row(row) }
    }
    table.markup()
}

fn channel_section(
    result: &ChannelComparison,
    channel: &Channel,
    comparison: &Comparison,
    recording: &Recording,
) -> Result<Markup, PlotError> {
    let mut heads: Vec<(&str, Align)> = HEAD.iter().map(|h| (*h, Align::Right)).collect();
    heads[0].1 = Align::Left;
    let mut table = Table::new(&heads);
    let rmse = |m: &ModelResult| m.rollout.map_or(f64::INFINITY, |s| s.rmse_kpa);
    let best = result.models.iter().min_by(|a, b| rmse(a).total_cmp(&rmse(b)));
    let mut impossible = Vec::new();
    for model in &result.models {
        let row = cells(model);
        if row.len() < HEAD.len() {
            impossible.push(row.join(": "));
        } else if best.is_some_and(|b| b.model == model.model) {
            table.highlighted_row(row);
        } else {
            table.row(row);
        }
    }
    let curves = Curves { result, channel, recording, from: comparison.test_from_row };
    let end = recording.rows();
    let judged = recording.time_s[end - 1] - recording.time_s[curves.from];
    let zoom = match best.filter(|_| judged > ZOOM_ABOVE_S) {
        Some(best) => Some(curves.pressures(
            &format!("Around the largest error of the {} model", best.model.name()),
            curves.worst(best),
        )?),
        None => None,
    };
    Ok(html! {
        (table.caption("Judged part. The best model is shaded.").markup())
        (notes(&impossible))
        (curves.pressures("Judged part: measured and simulated", (curves.from, end))?)
        (curves.errors((curves.from, end))?)
        @if let Some(zoom) = zoom { (zoom) }
        (curves.whole()?)
        @if channel.drive.is_some() { (curves.drives()?) }
    })
}

fn parameters(comparison: &Comparison) -> Markup {
    let (l, r) = (Align::Left, Align::Right);
    let heads = [
        ("channel", l),
        ("model", l),
        ("parameter", l),
        ("value", r),
        ("unit", l),
        ("95 % interval", l),
        ("remark", l),
    ];
    let mut table = Table::new(&heads);
    let mut remarks = Vec::new();
    for channel in &comparison.channels {
        for model in &channel.models {
            let Some(fit) = &model.fit else { continue };
            for p in &fit.parameters {
                let interval = p.ci95.map_or_else(String::new, |[low, high]| {
                    format!("{} to {}", significant(low, 4), significant(high, 4))
                });
                table.row([
                    channel.channel.to_string(),
                    model.model.name().to_owned(),
                    p.name.clone(),
                    significant(p.value, 4),
                    p.unit.to_owned(),
                    interval,
                    if p.fixed {
                        "fixed: the volume does not change here".to_owned()
                    } else {
                        remark(fit, &p.name, p.at_bound)
                    },
                ]);
            }
            remarks.push(format!(
                "{} {}: condition number {}, {} of {} starts agree.",
                channel.channel,
                model.model.name(),
                significant(fit.condition, 2),
                fit.agreeing_starts,
                fit.starts.len()
            ));
        }
    }
    html! {
        (paragraph("A parameter that the data do not determine is marked: its value serves the simulation, but says nothing about the rig."))
        (table.markup())
        (notes(&remarks))
    }
}

/// What keeps a parameter from being taken as a property of the rig.
fn remark(fit: &Fit, name: &str, at_bound: Option<Bound>) -> String {
    if let Some(bound) = at_bound {
        return format!("at its {} bound", if bound == Bound::Lower { "lower" } else { "upper" });
    }
    match fit.undetermined.iter().find(|u| u.name == name).map(|u| &u.reason) {
        None => String::new(),
        Some(Reason::NoEffect) => "not determined: no effect in this recording".to_owned(),
        Some(Reason::Confounded(with)) => format!("not determined: {} can make up for it", with.join(", ")),
        Some(Reason::Wide) => "not determined: its interval is as wide as its range".to_owned(),
    }
}
