//! The last line, and the help: keys, questions, messages.

use crate::view::live::model::Model;
use crate::view::live::words;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::Paragraph;

/// What the keys do, the important ones first; the rest is on `?`. Of several the longest that
/// fits.
const KEYS: [&str; 4] = [
    "? keys  v or Space vent all  r release  a arm  w record  Up/Down select  q end",
    "? keys  v or Space vent all  r release  q end",
    "? keys  v vent  q end",
    "v vent  q end",
];

const PLAYING: [&str; 2] =
    ["? keys  Space pause  Left/Right 5 s back, forward  Up/Down select  q end", "Space pause  q end"];

const ARMED: [&str; 3] = [
    "ARMED  Left/Right 1 kPa  -/+ 10 kPa  or a number and Enter  Esc disarm  v vent",
    "ARMED  number, Enter  Esc disarm  v vent",
    "ARMED  v vent",
];

/// The question that is open, what was typed, what the last key led to, or the keys.
pub fn line(model: &Model, width: u16) -> Paragraph<'static> {
    let loud = Style::new().fg(Color::Yellow).add_modifier(Modifier::REVERSED);
    let fits = |texts: &[&'static str]| {
        texts
            .iter()
            .find(|text| text.len() <= usize::from(width))
            .or(texts.last())
            .copied()
            .unwrap_or_default()
    };
    if let Some(question) = model.question {
        return Paragraph::new(words(question, model)).style(loud);
    }
    if !model.typed.is_empty() {
        let unit = model.session.setup.unit.name();
        return Paragraph::new(format!("set point: {}_ {unit}  Enter sends, Esc gives up", model.typed))
            .style(loud);
    }
    if let Some(message) = model.message() {
        return Paragraph::new(message.to_owned()).style(Style::new().fg(Color::Yellow));
    }
    if model.is_recording {
        return Paragraph::new(fits(&PLAYING)).style(Style::new().fg(Color::DarkGray));
    }
    if model.jog.armed().is_some() {
        return Paragraph::new(fits(&ARMED)).style(Style::new().fg(Color::Yellow));
    }
    Paragraph::new(fits(&KEYS)).style(Style::new().add_modifier(Modifier::DIM))
}

/// What stands beside a channel, where there is no room to name it above.
const COLUMNS: (&str, &str) = ("columns", "pressure now, set point (→ on its way to), what it is off by");

/// All keys of a recording.
const PLAYING_HELP: [(&str, &str); 8] = [
    ("Space p", "pause, go on"),
    ("Left Right", "5 s back, forward"),
    ("Up Down Tab", "select a channel"),
    ("PgUp PgDn", "older, newer events"),
    ("Esc", "close this; else asks whether to leave"),
    ("? h", "these keys"),
    ("q Ctrl-C", "leave the recording; no board is commanded meanwhile"),
    COLUMNS,
];

/// All keys.
pub fn help(is_recording: bool) -> Vec<Line<'static>> {
    let commanding = [
        ("v V Space", "vent all boards, at once, whatever is open"),
        ("r, then y", "release vented boards"),
        ("Up Down Tab", "select a channel"),
        ("a", "arm the selected board: only then do keys change its set points"),
        ("Left Right", "set point 1 kPa down, up; by a ramp of 100 kPa/s"),
        ("- +", "10 kPa down, up"),
        ("number Enter", "set point, in the unit shown"),
        ("Esc", "give up a number, disarm, close this; else asks whether to end"),
        ("w", "start, stop a recording in the working folder"),
        ("PgUp PgDn", "older, newer events"),
        ("? h", "these keys"),
        ("q Ctrl-C", "end the run: boards go to 0 kPa"),
        COLUMNS,
    ];
    let keys: &[(&str, &str)] = if is_recording { &PLAYING_HELP } else { &commanding };
    let bold = Style::new().add_modifier(Modifier::BOLD);
    keys.iter()
        .map(|&(key, text)| {
            let mut line = Line::styled(format!(" {key:<14}"), bold);
            line.push_span(ratatui::text::Span::styled(text, Style::new().remove_modifier(Modifier::BOLD)));
            line
        })
        .collect()
}
