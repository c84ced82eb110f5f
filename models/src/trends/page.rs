//! The page of trends.

use crate::order::descending;
use std::collections::BTreeMap;

use super::changes::{Change, FEWEST_RECORDINGS};
use super::date::TimeScale;
use super::point::Point;
use super::series::Trend;
use super::words::{conclusion, counted, time_scale, too_few};
use crate::data::ChannelId;
use crate::report::{
    Align, Colour, Markup, Page, Plot, PlotError, Table, folded, html, notes, paragraph, significant,
};

/// The page: what has changed, and every parameter over time, those that have changed first.
/// `left_out` says what was not used and why; `footer` names program and date.
///
/// # Errors
/// [`PlotError`] when a plot cannot be drawn.
pub fn trends_page(
    title: &str,
    trends: &[Trend],
    left_out: &[String],
    footer: &str,
) -> Result<String, PlotError> {
    let mut page = Page::new(title, format!("{}.", conclusion(trends)), footer);
    let scale = time_scale(trends);
    page.section("Changes", changes(trends, scale));
    // Where nothing stands out, there is nothing to fold the rest away for.
    let all_open = trends.iter().all(|trend| trend.levels.changes.is_empty());
    let mut channels: BTreeMap<ChannelId, Vec<&Trend>> = BTreeMap::new();
    for trend in trends {
        channels.entry(trend.channel).or_default().push(trend);
    }
    for (channel, own) in channels {
        let (changed, same): (Vec<&Trend>, Vec<&Trend>) =
            own.into_iter().partition(|trend| !trend.levels.changes.is_empty());
        let (open, rest) = (drawn(&changed, scale)?, drawn(&same, scale)?);
        let heading = format!("{} without a change", counted(same.len(), "parameter"));
        let rest = match same.len() {
            0 => html! {},
            _ if all_open => rest,
            _ => folded(&heading, &rest),
        };
        page.section(&format!("Channel {channel}"), html! { (open) (rest) });
    }
    if !left_out.is_empty() {
        page.section("Not used", notes(left_out));
    }
    page.section(
        "How to read this",
        html! {
            (paragraph("Each dot is the parameter as it was fitted to one recording, the upright line through it its 95 % interval. \
                A recording's own interval does not know of what differs from day to day (temperature, supply, movements); so a \
                change is marked by how recordings scatter: where the means before and behind differ by so much that one page in \
                twenty would show it by chance (Student's t, corrected for all places that were looked at). Bold lines are the \
                means. Between two recordings nothing is known of when."))
            (paragraph(&format!("Fewer than {FEWEST_RECORDINGS} recordings show no change. A slow drift is marked as steps.")))
        },
    );
    Ok(page.html())
}

fn changes(trends: &[Trend], scale: TimeScale) -> Markup {
    let mut found: Vec<(&Trend, &Change)> = trends
        .iter()
        .flat_map(|trend| trend.levels.changes.iter().map(move |change| (trend, change)))
        .collect();
    if too_few(trends) {
        return paragraph(&format!("Fewer than {FEWEST_RECORDINGS} recordings show none."));
    }
    if found.is_empty() {
        return paragraph("None.");
    }
    descending(&mut found, |item| item.1.between_unix_s[1]);
    let mut table = Table::new(&[
        ("channel", Align::Left),
        ("parameter", Align::Left),
        ("between", Align::Left),
        ("and", Align::Left),
        ("before", Align::Right),
        ("after", Align::Right),
        ("unit", Align::Left),
    ])
    .stacked();
    for (trend, change) in found {
        table.row([
            trend.channel.to_string(),
            trend.parameter.clone(),
            scale.said(change.between_unix_s[0]),
            scale.said(change.between_unix_s[1]),
            significant(change.before, 3),
            significant(change.after, 3),
            unit(trend).to_owned(),
        ]);
    }
    table.markup()
}

fn drawn(trends: &[&Trend], scale: TimeScale) -> Result<Markup, PlotError> {
    let plots = trends.iter().map(|trend| plot(trend, scale).markup()).collect::<Result<Vec<_>, _>>()?;
    Ok(html! { @for plot in &plots { (plot) } })
}

fn plot(trend: &Trend, scale: TimeScale) -> Plot {
    let Trend { parameter, points, levels, .. } = trend;
    let first_s = points.first().map_or(0.0, |point| point.unix_s);
    let since = |unix_s: f64| (unix_s - first_s) / scale.seconds();
    let with_unit = match unit(trend) {
        "" => parameter.clone(),
        unit => format!("{parameter} ({unit})"),
    };
    // A line that is broken behind each interval.
    let intervals = points.iter().filter_map(|point| {
        let [low, high] = point.ci95.filter(|ends| ends.iter().all(|end| end.is_finite()))?;
        let x = since(point.unix_s);
        Some([(x, low), (x, high), (x, f64::NAN)])
    });
    let mut from = 0;
    let mut means = Vec::new();
    let ends = levels.changes.iter().map(|change| change.at).chain([points.len()]);
    for to in ends {
        if let [first, .., last] = &points[from..to] {
            let mean = points[from..to].iter().map(|p| p.value).sum::<f64>() / (to - from) as f64;
            means.extend([
                (since(first.unix_s), mean),
                (since(last.unix_s), mean),
                (since(last.unix_s), f64::NAN),
            ]);
        }
        from = to;
    }
    let middles = levels.changes.iter().map(|change| {
        let [before, after] = change.between_unix_s;
        since(0.5 * (before + after))
    });
    let axis = format!("{} since {}", scale.name(), scale.said(first_s));
    Plot::new(format!("{}: {parameter}", trend.channel), axis, with_unit)
        .bold_line("mean", Colour::Orange, means)
        .line("95 % interval", Colour::Blue, intervals.flatten().collect())
        .points(
            "fitted value",
            Colour::Measured,
            points.iter().map(|p: &Point| (since(p.unix_s), p.value)).collect(),
        )
        .moments_called("change", middles)
}

fn unit(trend: &Trend) -> &str {
    if trend.unit == "1" { "" } else { &trend.unit }
}
