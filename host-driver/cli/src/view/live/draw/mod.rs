//! The picture: figures above, boards, events, keys below. What there is no room for is left out
//! from the bars on: a terminal of 20 columns and 4 lines still has numbers.

mod channel;
mod foot;
mod head;

use super::model::Model;
use pneudrive_host::poller::{BoardRow, BoardState};
use pneudrive_protocol::CHANNELS;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

/// A board: its title and a line for each channel.
const BOARD_HEIGHT: u16 = CHANNELS as u16 + 1;
/// Most lines of events, beside boards that take the rest.
const MOST_EVENTS: u16 = 12;

pub fn draw(frame: &mut Frame<'_>, model: &Model) {
    let area = frame.area();
    let count = model.snapshot.boards.len() as u16;
    // Two lines of figures from 8 lines on; keys from 4 lines on; events where there is room.
    let head = if area.height >= 8 { 2 } else { 1.min(area.height) };
    let foot = if area.height >= 4 { 1 } else { 0 };
    let rest = area.height.saturating_sub(head + foot);
    let events = match rest.saturating_sub(count * BOARD_HEIGHT) {
        // Where not all boards have room, events keep a line.
        0 if rest > BOARD_HEIGHT => 1,
        0 => 0,
        spare => spare.min(MOST_EVENTS),
    };
    // The columns are named where two lines of events are left.
    let named = u16::from(events > 2 && !model.help && area.width >= channel::NARROW);
    let events = events - named;
    let [top, names, boards, happened, bottom] = Layout::vertical([
        Constraint::Length(head),
        Constraint::Length(named),
        Constraint::Min(0),
        Constraint::Length(events),
        Constraint::Length(foot),
    ])
    .areas(area);
    frame.render_widget(Paragraph::new(head::lines(model, area.width, head)), top);
    frame.render_widget(Paragraph::new(channel::names(model, area.width)), names);
    if model.help {
        frame.render_widget(Paragraph::new(foot::help(model.is_recording)), boards);
    } else {
        draw_boards(frame, boards, model);
    }
    draw_events(frame, happened, model);
    if foot > 0 {
        frame.render_widget(foot::line(model, area.width), bottom);
    }
}

fn draw_events(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let back = model.events_back;
    let newest: Vec<_> = model.events().rev().skip(back).take(usize::from(area.height)).collect();
    let mut lines: Vec<_> = newest.into_iter().rev().map(|event| Line::raw(event.as_str())).collect();
    if back > 0
        && let Some(last) = lines.last_mut()
    {
        last.push_span(Span::styled(
            format!("  ({back} newer, PgDn)"),
            Style::new().add_modifier(Modifier::DIM),
        ));
    }
    // At the bottom, where the newest has been all the time.
    let top = area.height.saturating_sub(lines.len() as u16);
    let area = Rect { y: area.y + top, height: area.height - top, ..area };
    frame.render_widget(Paragraph::new(lines).style(Style::new().fg(Color::Yellow)), area);
}

fn draw_boards(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let boards = &model.snapshot.boards;
    // A title is worth a line where a channel has one too.
    let titled = area.height > CHANNELS as u16;
    let height = if titled { BOARD_HEIGHT } else { CHANNELS as u16 };
    let room = usize::from((area.height / height).max(1));
    let first = first_board(model.selected / CHANNELS, boards.len(), room);
    for (place, (index, board)) in boards.iter().enumerate().skip(first).take(room).enumerate() {
        let top = area.y + place as u16 * height;
        if titled {
            let line = Rect { y: top, height: 1, ..area };
            frame.render_widget(Paragraph::new(title(board, model, index, area.width)), line);
        }
        // Where a board has less than its four lines, the selected channel is among them.
        let lines = (area.bottom() - top - u16::from(titled)).min(CHANNELS as u16);
        let (of, selected) = model.place();
        let from = if of == index { selected.saturating_sub(usize::from(lines.max(1)) - 1) } else { 0 };
        for (line, channel) in (from..CHANNELS).take(usize::from(lines)).enumerate() {
            let line = Rect { y: top + u16::from(titled) + line as u16, height: 1, ..area };
            channel::draw(frame, line, model, index, channel);
        }
    }
}

/// The first board shown, so that the selected one is.
fn first_board(selected: usize, boards: usize, room: usize) -> usize {
    (selected + 1).saturating_sub(room).min(boards.saturating_sub(room))
}

fn title(board: &BoardRow, model: &Model, index: usize, width: u16) -> Line<'static> {
    let state = match board.state {
        BoardState::Unseen => "NEVER ANSWERED",
        BoardState::Present => "present",
        BoardState::Doubtful => "did not answer",
        BoardState::Missing => "MISSING",
    };
    let color = color(board.state);
    let name = model.session.setup.board(board.board);
    let armed = model.jog.armed() == Some(index);
    let mut line = Line::from(Span::styled(
        format!("{name}: {state}"),
        Style::new().fg(color).add_modifier(Modifier::BOLD),
    ));
    if armed {
        line.push_span(Span::styled(
            " ARMED",
            Style::new().fg(Color::Yellow).add_modifier(Modifier::REVERSED),
        ));
    }
    if let Some(age) = board.reading.map(|reading| reading.age(model.now_ns)).filter(|&age| age > Model::OLD)
    {
        line.push_span(Span::raw(format!(", last seen {:.1} s ago", age.as_secs_f64())));
    }
    if let Some(kpa) = board.sensors.supply.and_then(|supply| supply.shown_kpa(model.now_ns)) {
        let unit = model.session.setup.unit;
        line.push_span(Span::raw(format!(", supply {} {}", unit.number(kpa), unit.name())));
    }
    if let Some(chip_c) = board.sensors.electronics.and_then(|e| e.chip_c).filter(|_| width >= 100) {
        line.push_span(Span::raw(format!(", chip {chip_c:.0} C")));
    }
    let figures = model.statistics.as_ref().and_then(|s| s.boards.iter().find(|b| b.board == board.board));
    if let Some(figures) = figures.filter(|figures| figures.lost + figures.rows_without_reading > 0) {
        let without = match figures.rows_without_reading {
            rows if rows > 0 && width >= 100 => format!(", rows without a reading: {rows}"),
            _ => String::new(),
        };
        line.push_span(Span::raw(format!(", {} lost{without}", figures.lost)));
    }
    // Where bars end, above their ends.
    if channel::has_bars(model, width) {
        let unit = model.session.setup.unit;
        let scale = format!("scale 0 to {} {}", unit.number(model.scale_kpa(index)), unit.name());
        let used = line.width() + scale.len();
        if usize::from(width) > used + 2 {
            let gap = " ".repeat(usize::from(width) - used);
            line.push_span(Span::raw(gap));
            line.push_span(Span::styled(scale, Style::new().add_modifier(Modifier::DIM)));
        }
    }
    line
}

fn color(state: BoardState) -> Color {
    match state {
        BoardState::Present => Color::Green,
        BoardState::Doubtful => Color::Yellow,
        BoardState::Unseen | BoardState::Missing => Color::Red,
    }
}

#[cfg(test)]
mod tests;
