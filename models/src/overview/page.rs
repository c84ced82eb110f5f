//! The page of a recording.

use super::channel::{ChannelFigures, figures};
use super::plots::BoardPlots;
use crate::data::{Event, Loaded, Recording};
use crate::report::{
    Align, Markup, Page, PlotError, Table, duration_text, folded, html, notes, number, paragraph, significant,
};

/// Boards that are drawn openly; more are folded.
const OPEN_BOARDS: usize = 4;

/// Events in the table; of more, the first and a word.
const EVENTS_SHOWN: usize = 200;

/// Kinds of events that are ordinary.
const ORDINARY: [&str; 4] = ["end", "key", "page", "information"];

/// The page of a recording: figures of every channel, plots of every board, events, and what was
/// noticed about the data. `footer` names program, data and date.
///
/// # Errors
/// [`PlotError`] when a plot cannot be drawn.
pub fn recording_page(loaded: &Loaded, events: &[Event], footer: &str) -> Result<String, PlotError> {
    let recording = &loaded.recording;
    let found = figures(recording);
    let name = std::path::Path::new(&recording.source.file);
    let name =
        name.file_name().map_or_else(|| recording.source.file.clone(), |n| n.to_string_lossy().into_owned());
    let mut page = Page::new(format!("Recording {name}"), lead(recording, &found, events), footer);
    page.section("Channels", channels(&found));
    let boards = boards(recording);
    let mut drawn = Vec::new();
    for &board in &boards {
        drawn.push((board, BoardPlots { recording, board, events }.markup()?));
    }
    let pictures = html! {
        @for (k, (board, markup)) in drawn.iter().enumerate() {
            @if k < OPEN_BOARDS { (markup) } @else { (folded(&format!("Board {board}"), markup)) }
        }
    };
    page.section("Over time", pictures);
    if !events.is_empty() {
        page.section("Events", event_table(events));
    }
    page.section("About the data", html! { (notes(&loaded.quality.sentences())) });
    Ok(page.html())
}

/// The pressures of the first board, to look at beside its figures.
///
/// # Errors
/// [`PlotError`] when there is nothing to draw.
pub fn first_board(loaded: &Loaded, events: &[Event]) -> Result<Markup, PlotError> {
    let recording = &loaded.recording;
    let board = boards(recording).first().copied().unwrap_or(0);
    BoardPlots { recording, board, events }.first()
}

fn boards(recording: &Recording) -> Vec<u8> {
    let mut boards: Vec<u8> = recording.channels.iter().map(|channel| channel.id.board).collect();
    boards.dedup();
    boards
}

fn lead(recording: &Recording, found: &[ChannelFigures], events: &[Event]) -> String {
    let boards = boards(recording);
    let mut text = format!(
        "{} at {} Hz: {}, {}.",
        duration_text(recording.duration_s()),
        number(recording.rate_hz(), 1),
        counted(boards.len(), "board"),
        counted(found.len(), "channel"),
    );
    let worst = found.iter().filter_map(|f| Some((f.settled_rms_kpa?, f.channel)));
    if let Some((rms, channel)) = worst.max_by(|a, b| a.0.total_cmp(&b.0)) {
        text += &format!(
            " Set points that stand still are held to {} kPa or better (root mean square; the worst is {channel}).",
            number(rms, 2)
        );
    }
    let lost: usize = boards.iter().map(|board| recording.lost_exchanges(*board).len()).sum();
    let exchanges = recording.rows() * boards.len();
    // What a host recorded ends with an event at least. Simulations and what others recorded know
    // of no exchanges.
    let hosts = !events.is_empty();
    let share = significant(100.0 * lost as f64 / exchanges.max(1) as f64, 2);
    text += &match lost {
        0 if hosts => " No exchange was lost.".to_owned(),
        0 => String::new(),
        _ if hosts => format!(" {lost} of {exchanges} exchanges were lost ({share} %)."),
        _ => format!(" {lost} of {exchanges} rows have no pressure ({share} %)."),
    };
    let remarkable = events.iter().filter(|event| !ORDINARY.contains(&event.kind.as_str())).count();
    if remarkable > 0 {
        text += &format!(" {} to look at.", counted(remarkable, "event"));
    }
    text
}

fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn channels(found: &[ChannelFigures]) -> Markup {
    let mut table = Table::new(&[
        ("Channel", Align::Left),
        ("set points, kPa", Align::Right),
        ("pressures, kPa", Align::Right),
        ("deviation RMS, kPa", Align::Right),
        ("largest, kPa", Align::Right),
        ("settled: mean, kPa", Align::Right),
        ("settled: RMS, kPa", Align::Right),
        ("rows missing", Align::Right),
        ("rows masked", Align::Right),
    ])
    .stacked();
    let range = |range: Option<[f64; 2]>| {
        range.map_or_else(
            || "-".to_owned(),
            |[low, high]| format!("{} to {}", number(low, 1), number(high, 1)),
        )
    };
    let value = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| number(value, 2));
    for f in found {
        table.row([
            f.channel.to_string(),
            range(f.command_kpa),
            range(f.pressure_kpa),
            value(f.deviation_rms_kpa),
            value(f.deviation_largest_kpa),
            value(f.settled_mean_kpa),
            value(f.settled_rms_kpa),
            f.missing.to_string(),
            f.masked.to_string(),
        ]);
    }
    html! {
        (table.markup())
        p.caption { "Deviation: measured - set point. Settled: the set point has stood still for 1 s." }
    }
}

fn event_table(events: &[Event]) -> Markup {
    let mut table =
        Table::new(&[("time, s", Align::Right), ("what", Align::Left), ("in words", Align::Left)]).stacked();
    for event in events.iter().take(EVENTS_SHOWN) {
        table.row([number(event.t_s, 3), event.kind.replace('_', " "), event.text.clone()]);
    }
    html! {
        (table.markup())
        @if events.len() > EVENTS_SHOWN {
            (paragraph(&format!("And {} more.", events.len() - EVENTS_SHOWN)))
        }
    }
}
