use super::model::Model;
use pneudrive_host::poller::{BoardRow, BoardState, Commanding};
use pneudrive_protocol::{CHANNELS, SensorScale};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Sparkline, SparklineBar};

/// A board's box: a line for each channel and the frame.
const BOARD_HEIGHT: u16 = CHANNELS as u16 + 2;
const EVENT_LINES: u16 = 3;
/// `0 100.0 kPa  cmd 100.0 `
const LABEL_WIDTH: u16 = 24;
/// Least full scale of the picture of the last pressures, kPa.
const SMALLEST_SCALE_KPA: f64 = 50.0;

/// Fits into 80 columns.
const KEYS: &str = "v or Space vent all   r release   q or Ctrl-C end   up/down other boards";

pub fn draw(frame: &mut Frame<'_>, model: &Model) {
    let [head, boards, events, foot] = Layout::vertical([
        Constraint::Length(3),
        Constraint::Min(BOARD_HEIGHT),
        Constraint::Length(EVENT_LINES),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    frame.render_widget(Paragraph::new(summary(model)), head);
    draw_boards(frame, boards, model);
    let newest: Vec<_> = model.events().rev().take(usize::from(EVENT_LINES)).collect();
    let lines: Vec<_> = newest.into_iter().rev().map(|event| Line::raw(event.as_str())).collect();
    frame.render_widget(Paragraph::new(lines).style(Style::new().fg(Color::Yellow)), events);
    let keys = match model.question {
        Some(question) => Paragraph::new(super::words(question, &model.session))
            .style(Style::new().fg(Color::Yellow).add_modifier(Modifier::REVERSED)),
        None => Paragraph::new(KEYS).style(Style::new().add_modifier(Modifier::DIM)),
    };
    frame.render_widget(keys, foot);
}

fn summary(model: &Model) -> Vec<Line<'static>> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let rate = model.loop_hz().map_or_else(|| "-".to_owned(), |hz| format!("{hz:.1} Hz"));
    let seconds = model.snapshot.since_start_ns as f64 * 1e-9;
    let mut first =
        format!("  {}  {} board(s)  {seconds:.1} s", model.session.port, model.snapshot.boards.len());
    if let Some(file) = &model.session.recording {
        first += &format!("  recording {}", file.display());
    }
    let mut lines =
        vec![Line::from(vec![Span::styled("PneuDrive", bold), Span::raw(first)]), Line::styled(rate, bold)];
    if model.session.overriding.commanding() == Commanding::Vented {
        lines[0].push_span(Span::styled("  VENTED (r releases)", bold.fg(Color::Red)));
    }
    if let Some(statistics) = &model.statistics {
        let cycle = &statistics.cycle_us;
        lines[1].push_span(Span::styled(
            format!("   cycle {:.0} us, 99 % {:.0} us, longest {:.0} us", cycle.p50, cycle.p99, cycle.max),
            Style::new(),
        ));
        let lost = format!("{} lost", statistics.lost);
        let color = if statistics.lost == 0 { Color::Green } else { Color::Yellow };
        lines.push(Line::from(vec![
            Span::raw(format!("{} exchanges, ", statistics.exchanges)),
            Span::styled(lost, Style::new().fg(color)),
            Span::raw(format!(
                ", {} rejected   bus thread {:.0} % of a core",
                statistics.rejected,
                100.0 * statistics.cpu_share
            )),
        ]));
    }
    lines
}

fn draw_boards(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let room = usize::from(area.height / BOARD_HEIGHT);
    let shown = model.snapshot.boards.iter().enumerate().skip(model.first_board).take(room);
    for (place, (index, board)) in (0..).zip(shown) {
        let top = Rect { y: area.y + place * BOARD_HEIGHT, height: BOARD_HEIGHT, ..area };
        let title = title(board, model);
        let frame_style = Style::new().fg(color(board.state));
        let block = Block::bordered().title(title).border_style(frame_style);
        let inside = block.inner(top);
        frame.render_widget(block, top);
        for channel in 0..CHANNELS {
            let line = Rect { y: inside.y + channel as u16, height: 1, ..inside };
            draw_channel(frame, line, model, index, board, channel);
        }
    }
}

fn title(board: &BoardRow, model: &Model) -> String {
    let state = match board.state {
        BoardState::Unseen => "never answered",
        BoardState::Present => "present",
        BoardState::Doubtful => "did not answer",
        BoardState::Missing => "MISSING",
    };
    let figures = model.statistics.as_ref().and_then(|s| s.boards.iter().find(|b| b.board == board.board));
    let figures = figures.map_or_else(String::new, |b| {
        let without = match b.rows_without_reading {
            0 => String::new(),
            rows => format!(", {rows} rows without a reading"),
        };
        format!(", {} answered, {} lost{without}", b.answered, b.lost)
    });
    let age = match board.reading.map(|reading| reading.age_ns(model.now_ns)) {
        Some(age_ns) if age_ns > Model::OLD_NS => format!(", last seen {:.1} s ago", age_ns as f64 * 1e-9),
        _ => String::new(),
    };
    format!(" board {}: {state}{figures}{age} ", board.board)
}

fn color(state: BoardState) -> Color {
    match state {
        BoardState::Present => Color::Green,
        BoardState::Doubtful => Color::Yellow,
        BoardState::Unseen | BoardState::Missing => Color::Red,
    }
}

fn draw_channel(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    index: usize,
    board: &BoardRow,
    channel: usize,
) {
    let [label, bar, past] =
        Layout::horizontal([Constraint::Length(LABEL_WIDTH), Constraint::Fill(3), Constraint::Fill(2)])
            .areas(area);
    let command = model.session.setup.calibration.command_kpa(board.board, board.command)[channel];
    let fresh = board.reading.filter(|reading| reading.age_ns(model.now_ns) <= Model::OLD_NS);
    let pressure = fresh.map(|reading| reading.kpa[channel]);
    let shown = pressure.map_or_else(|| "   ---".to_owned(), |kpa| format!("{kpa:>6.1}"));
    frame.render_widget(Paragraph::new(format!("{channel} {shown} kPa cmd {command:>5.1}")), label);
    frame.render_widget(Paragraph::new(bar_line(pressure, command, usize::from(bar.width))), bar);
    let history = model.history(index, channel);
    let values = history.iter().skip(history.len().saturating_sub(usize::from(past.width)));
    let values: Vec<_> = values.copied().collect();
    // Scaled to the highest value shown, but not so far that noise looks like motion.
    let top = values.iter().flatten().fold(command.max(SMALLEST_SCALE_KPA), |top, &kpa| top.max(kpa));
    // The smallest bar is 1: an empty cell means that there was no reading.
    let bars = values.iter().map(|value| SparklineBar::from(value.map(|kpa| kpa.max(0.0) as u64 + 1)));
    let sparkline = Sparkline::default().data(bars.collect::<Vec<_>>()).style(Style::new().fg(Color::Cyan));
    frame.render_widget(sparkline.max(top as u64 + 1), past);
}

/// The pressure as a bar over the sensor's range, and a mark at the command.
fn bar_line(pressure: Option<f64>, command: f64, width: usize) -> Line<'static> {
    let width = width.saturating_sub(1);
    let place =
        |kpa: f64| ((kpa / SensorScale::ORIGINAL.full_scale_kpa()).clamp(0.0, 1.0) * width as f64) as usize;
    let filled = pressure.map_or(0, place);
    let mark = place(command).min(width.saturating_sub(1));
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
    use crate::cli::view::Session;
    use pneudrive_host::line::Clock;
    use pneudrive_host::poller::{Outcome, Override, Reading, Snapshot};
    use pneudrive_protocol::Counts;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn screen(now_ns: u64, width: u16, height: u16) -> String {
        let overriding = Override::following(1);
        let session = Session {
            port: "sim".into(),
            recording: Some("run.csv".into()),
            clock: Clock,
            overriding,
            setup: crate::cli::setup::Setup::default(),
            keep_running: false,
        };
        let mut model = Model::new(session);
        let command = [SensorScale::ORIGINAL.counts(344.7).unwrap(); CHANNELS];
        let reading = Reading { counts: [Counts::MIN; 4], kpa: [100.0, 200.0, 300.0, 689.0], asked_ns: 0 };
        let state = if now_ns > Model::OLD_NS { BoardState::Missing } else { BoardState::Present };
        let board = BoardRow {
            board: 0,
            command,
            wanted: command,
            outcome: Outcome::Fresh,
            reading: Some(reading),
            state,
        };
        for cycle in [0, 500] {
            let since_start_ns = cycle * 1_000_000;
            let snapshot = Snapshot { cycle: Some(cycle), at_ns: 0, since_start_ns, boards: vec![board] };
            model.sample(snapshot, now_ns);
        }
        model.happened("board 0 answers".into());
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, &model)).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn every_chamber_is_there_with_command_and_pressure() {
        let screen = screen(1_000, 100, 14);
        for part in
            ["PneuDrive", "recording run.csv", "1000.0 Hz", "board 0: present", "0.5 s: board 0 answers"]
        {
            assert!(screen.contains(part), "{part} is not in\n{screen}");
        }
        for part in ["0  100.0 kPa cmd 344.7", "1  200.0 kPa", "2  300.0 kPa", "3  689.0 kPa"] {
            assert!(screen.contains(part), "{part} is not in\n{screen}");
        }
    }

    #[test]
    fn old_pressures_are_not_shown() {
        let screen = screen(2_000_000_000, 100, 14);
        assert!(
            screen.contains("MISSING, last seen 2.0 s ago") && screen.contains("0    --- kPa"),
            "{screen}"
        );
        assert!(!screen.contains("100.0 kPa"), "{screen}");
    }

    #[test]
    fn tiny_terminals_do_not_panic() {
        for (width, height) in [(1, 1), (10, 3), (30, 8), (200, 60)] {
            screen(1_000, width, height);
        }
    }

    #[test]
    fn the_bar_is_filled_up_to_the_pressure_with_a_mark_at_the_command() {
        let full = SensorScale::ORIGINAL.full_scale_kpa();
        let text = |pressure, command| {
            let line = bar_line(pressure, command, 11);
            line.spans.iter().map(|span| span.content.as_ref()).collect::<String>()
        };
        assert_eq!(text(Some(0.5 * full), 0.8 * full), "█████···│·");
        assert_eq!(text(None, 0.0), "│·········");
        assert_eq!(text(Some(2.0 * full), full), "█████████│");
    }
}
