//! The page of trends.

use std::collections::BTreeMap;

use super::changes::{Change, FEWEST_RECORDINGS};
use super::date::day;
use super::point::Point;
use super::series::Trend;
use crate::data::ChannelId;
use crate::report::{
    Align, Colour, Markup, Page, Plot, PlotError, Table, folded, html, notes, paragraph, significant,
};

const DAY_S: f64 = 86_400.0;

/// The page: what has changed, and every parameter over time, those that have changed first. `left_out` says what was not used and
/// why; `footer` names program and date.
///
/// # Errors
/// [`PlotError`] when a plot cannot be drawn.
pub fn trends_page(
    title: &str,
    trends: &[Trend],
    left_out: &[String],
    footer: &str,
) -> Result<String, PlotError> {
    let mut page = Page::new(title, lead(trends), footer);
    page.section("Changes", changes(trends));
    let mut channels: BTreeMap<ChannelId, Vec<&Trend>> = BTreeMap::new();
    for trend in trends {
        channels.entry(trend.channel).or_default().push(trend);
    }
    for (channel, own) in channels {
        let (changed, same): (Vec<&Trend>, Vec<&Trend>) =
            own.into_iter().partition(|trend| !trend.levels.changes.is_empty());
        let open = drawn(&changed)?;
        let rest = drawn(&same)?;
        let fewer = if too_few(trends) { "" } else { " without a change" };
        let heading = format!("{}{fewer}", counted(same.len(), "parameter"));
        page.section(
            &format!("Channel {channel}"),
            html! { (open) @if !same.is_empty() { (folded(&heading, &rest)) } },
        );
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
            (paragraph("Fewer than five recordings show no change. A slow drift is marked as steps."))
        },
    );
    Ok(page.html())
}

fn most_points(trends: &[Trend]) -> usize {
    trends.iter().map(|trend| trend.points.len()).max().unwrap_or(0)
}

/// That nothing has changed cannot be said then either.
fn too_few(trends: &[Trend]) -> bool {
    most_points(trends) < FEWEST_RECORDINGS
}

fn lead(trends: &[Trend]) -> String {
    let times = || trends.iter().flat_map(|trend| &trend.points).map(|point| point.unix_s);
    let first = times().fold(f64::INFINITY, f64::min);
    let last = times().fold(f64::NEG_INFINITY, f64::max);
    let recordings = most_points(trends);
    let changes: usize = trends.iter().map(|trend| trend.levels.changes.len()).sum();
    let found = match changes {
        _ if too_few(trends) => format!("too few to tell a change ({FEWEST_RECORDINGS} at least)"),
        0 => "no parameter has changed".to_owned(),
        _ => counted(changes, "change"),
    };
    format!("{} from {} to {}: {found}.", counted(recordings, "recording"), day(first), day(last))
}

fn changes(trends: &[Trend]) -> Markup {
    let mut found: Vec<(&Trend, &Change)> = trends
        .iter()
        .flat_map(|trend| trend.levels.changes.iter().map(move |change| (trend, change)))
        .collect();
    if too_few(trends) {
        return paragraph("Fewer than five recordings show none.");
    }
    if found.is_empty() {
        return paragraph("None.");
    }
    found.sort_by(|a, b| b.1.between_unix_s[1].total_cmp(&a.1.between_unix_s[1]));
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
            day(change.between_unix_s[0]),
            day(change.between_unix_s[1]),
            significant(change.before, 3),
            significant(change.after, 3),
            unit(trend).to_owned(),
        ]);
    }
    table.markup()
}

fn drawn(trends: &[&Trend]) -> Result<Markup, PlotError> {
    let plots = trends.iter().map(|trend| plot(trend).markup()).collect::<Result<Vec<_>, _>>()?;
    Ok(html! { @for plot in &plots { (plot) } })
}

fn plot(trend: &Trend) -> Plot {
    let Trend { parameter, points, levels, .. } = trend;
    let first_s = points.first().map_or(0.0, |point| point.unix_s);
    let days = |unix_s: f64| (unix_s - first_s) / DAY_S;
    let with_unit = match unit(trend) {
        "" => parameter.clone(),
        unit => format!("{parameter} ({unit})"),
    };
    // A line that is broken behind each interval.
    let intervals = points.iter().filter_map(|point| {
        let [low, high] = point.ci95.filter(|ends| ends.iter().all(|end| end.is_finite()))?;
        let x = days(point.unix_s);
        Some([(x, low), (x, high), (x, f64::NAN)])
    });
    let mut from = 0;
    let mut means = Vec::new();
    let ends = levels.changes.iter().map(|change| change.at).chain([points.len()]);
    for to in ends {
        if let [first, .., last] = &points[from..to] {
            let mean = points[from..to].iter().map(|p| p.value).sum::<f64>() / (to - from) as f64;
            means.extend([
                (days(first.unix_s), mean),
                (days(last.unix_s), mean),
                (days(last.unix_s), f64::NAN),
            ]);
        }
        from = to;
    }
    let middles = levels.changes.iter().map(|change| {
        let [before, after] = change.between_unix_s;
        days(0.5 * (before + after))
    });
    Plot::new(format!("{}: {parameter}", trend.channel), format!("days since {}", day(first_s)), with_unit)
        .bold_line("mean", Colour::Orange, means)
        .line("95 % interval", Colour::Blue, intervals.flatten().collect())
        .points(
            "fitted value",
            Colour::Measured,
            points.iter().map(|p: &Point| (days(p.unix_s), p.value)).collect(),
        )
        .moments_called("change", middles)
}

fn unit(trend: &Trend) -> &str {
    if trend.unit == "1" { "" } else { &trend.unit }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
