//! A channel: name, pressure, set point, deviation, a bar and its past.

use crate::view::live::model::Model;
use pneudrive_protocol::{CHANNELS, Counts};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Sparkline, SparklineBar};

/// Columns that numbers take beside the name: mark, channel, pressure, set point, deviation.
const NUMBERS: u16 = 34;
/// Terminals of fewer columns have pressures and set points only.
pub const NARROW: u16 = 40;
/// Deviations of more than this are coloured, kPa.
const FAR_KPA: f64 = 5.0;

/// Columns of the names on a terminal of this width: what the longest one takes, where there is
/// room.
fn name_columns(model: &Model, width: u16) -> u16 {
    let most = if width >= 100 { 24 } else { 12 };
    let setup = &model.session.setup;
    let names = model.snapshot.boards.iter().flat_map(|board| {
        (0..CHANNELS)
            .filter_map(|channel| setup.channel(board.board, channel))
            .map(|name| name.chars().count())
    });
    names.max().unwrap_or(0).min(most) as u16
}

/// Whether a terminal of this width has room for bars.
pub fn has_bars(model: &Model, width: u16) -> bool {
    width >= NUMBERS + name_columns(model, width) + 16
}

/// What stands in the columns below, for a terminal that is not narrow.
pub fn names(model: &Model, width: u16) -> Line<'static> {
    let columns = usize::from(name_columns(model, width));
    let dim = Style::new().add_modifier(Modifier::DIM);
    let mut line =
        Line::styled(format!("   {:<columns$} {:>6} {:<10} {:>7} ", "", "now", " set to", "off by"), dim);
    if has_bars(model, width) {
        line.push_span(Span::raw("now, and │ set to"));
    }
    line
}

/// What is known of a channel now.
struct Now {
    /// kPa; `None` where the board has not answered lately or calls the sensor faulty.
    pressure: Option<f64>,
    faulty: bool,
    command: f64,
    wanted: f64,
}

pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model, index: usize, channel: usize) {
    let Some(now) = now(model, index, channel) else { return };
    let numbers = numbers(model, index, channel, &now, area.width);
    if !has_bars(model, area.width) {
        return frame.render_widget(Paragraph::new(numbers), area);
    }
    let [label, bar, _, past] = Layout::horizontal([
        Constraint::Length(NUMBERS + name_columns(model, area.width)),
        Constraint::Fill(3),
        Constraint::Length(1),
        Constraint::Fill(2),
    ])
    .areas(area);
    frame.render_widget(Paragraph::new(numbers), label);
    let scale_kpa = model.scale_kpa(index);
    frame.render_widget(Paragraph::new(bar_line(&now, scale_kpa, usize::from(bar.width))), bar);
    let history = model.history(index, channel);
    let values = history.iter().skip(history.len().saturating_sub(usize::from(past.width)));
    // The smallest bar is 1: an empty cell means that there was no reading. In tenths of kPa, on
    // the board's scale.
    let tenths = |kpa: f64| (10.0 * kpa.max(0.0)) as u64 + 1;
    let bars: Vec<_> = values.map(|value| SparklineBar::from(value.map(tenths))).collect();
    let sparkline = Sparkline::default().data(bars).style(Style::new().fg(Color::Cyan));
    frame.render_widget(sparkline.max(tenths(scale_kpa)), past);
}

fn now(model: &Model, index: usize, channel: usize) -> Option<Now> {
    let board = model.snapshot.boards.get(index)?;
    let calibration = &model.session.setup.calibration;
    let fresh = board.reading.filter(|reading| reading.age(model.now_ns) <= Model::OLD);
    let faulty = fresh.is_some_and(|reading| [Counts::MIN, Counts::MAX].contains(&reading.counts[channel]));
    let wanted = calibration.command_kpa(board.board, board.wanted)[channel];
    Some(Now {
        pressure: fresh.filter(|_| !faulty).map(|reading| reading.kpa[channel]),
        faulty,
        command: calibration.command_kpa(board.board, board.command)[channel],
        wanted: model.jog.target((index, channel)).unwrap_or(wanted),
    })
}

fn numbers(model: &Model, index: usize, channel: usize, now: &Now, width: u16) -> Line<'static> {
    let setup = &model.session.setup;
    let unit = setup.unit;
    let selected = model.place() == (index, channel);
    let board = model.snapshot.boards.get(index).map_or(0, |board| board.board);
    let pressure = match now.pressure {
        Some(kpa) => unit.number(kpa),
        None if now.faulty => "FAULT".to_owned(),
        None => "---".to_owned(),
    };
    let command = unit.number(now.command);
    let mark = if selected { ">" } else { " " };
    if width < NARROW {
        return Line::raw(format!("{mark}{board}.{channel} {pressure:>6}/{command}"));
    }
    let columns = usize::from(name_columns(model, width));
    let name: String = setup.channel(board, channel).unwrap_or_default().chars().take(columns).collect();
    let moving = (now.wanted - now.command).abs() > 0.5;
    let command = if moving { format!("→{}", unit.number(now.wanted)) } else { format!(" {command}") };
    let deviation = now.pressure.map(|kpa| kpa - now.command);
    let shown = deviation.map_or_else(String::new, |kpa| {
        let text = unit.number(kpa);
        if text.starts_with('-') { text } else { format!("+{text}") }
    });
    let far = deviation.is_some_and(|kpa| kpa.abs() > FAR_KPA);
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let style = if selected { bold.add_modifier(Modifier::REVERSED) } else { Style::new() };
    Line::from(vec![
        Span::styled(format!("{mark}{channel} {name:<columns$}"), style),
        Span::styled(format!(" {pressure:>6}"), bold),
        Span::styled(format!(" {command:<7}"), Style::new().fg(Color::Yellow)),
        Span::raw(format!("{:<3}", unit.name())),
        Span::styled(
            format!(" {shown:>7} "),
            Style::new().fg(if far { Color::Yellow } else { Color::Reset }).add_modifier(if far {
                Modifier::BOLD
            } else {
                Modifier::DIM
            }),
        ),
    ])
}

/// The pressure as a bar up to the board's scale, and a mark at the command.
fn bar_line(now: &Now, scale_kpa: f64, width: usize) -> Line<'static> {
    let place = |kpa: f64| ((kpa / scale_kpa).clamp(0.0, 1.0) * width as f64) as usize;
    let filled = now.pressure.map_or(0, place);
    let mark = place(now.command).min(width.saturating_sub(1));
    let cells = (0..width).map(|at| match (at == mark, at < filled) {
        (true, _) => Span::styled("│", Style::new().fg(Color::Yellow)),
        (false, true) => Span::styled("█", Style::new().fg(Color::Blue)),
        (false, false) => Span::styled("·", Style::new().add_modifier(Modifier::DIM)),
    });
    cells.collect::<Vec<_>>().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_is_filled_up_to_the_pressure_with_a_mark_at_the_command() {
        let text = |pressure, command| {
            let line = bar_line(&Now { pressure, faulty: false, command, wanted: command }, 200.0, 10);
            line.spans.iter().map(|span| span.content.as_ref()).collect::<String>()
        };
        assert_eq!(text(Some(100.0), 160.0), "█████···│·");
        assert_eq!(text(None, 0.0), "│·········");
        assert_eq!(text(Some(400.0), 200.0), "█████████│");
    }
}
