//! Figures of the run.

use crate::view::live::model::Model;
use pneudrive_record::watch::WatchStatus;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};

/// One or two lines of figures: what does not fit into `width` is left out from the end.
pub fn lines(model: &Model, width: u16, count: u16) -> Vec<Line<'static>> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let rate = model.loop_hz().map_or_else(|| "- Hz".to_owned(), |hz| format!("{hz:.1} Hz"));
    let vented = model.is_vented();
    let state = Span::styled("VENTED (r releases)", bold.fg(Color::Red).add_modifier(Modifier::REVERSED));
    let lost = model.statistics.as_ref().map_or(0, |statistics| statistics.lost);
    let lost_color = if lost == 0 { Color::Green } else { Color::Yellow };
    let recording = recording(model);
    if count < 2 {
        let first = if vented { Span::styled("VENTED", state.style) } else { Span::styled(rate, bold) };
        return vec![fitted(width, vec![first, Span::raw(format!(" {lost} lost"))])];
    }
    let seconds = model.snapshot.since_start_ns as f64 * 1e-9;
    let mut first = vec![Span::styled("PneuDrive", bold)];
    if vented {
        first.extend([Span::raw("  "), state]);
    }
    if let Some(watch) = model.session.watch.as_ref().map(WatchStatus::state) {
        let colour = if watch.is_warning() { Color::Red } else { Color::Green };
        first.push(Span::styled(format!("  {}", watch.words()), Style::new().fg(colour)));
    }
    if let Some(file) = recording {
        first.push(Span::styled(format!("  REC {file}"), Style::new().fg(Color::Red)));
    }
    first.push(Span::raw(format!("  {seconds:.1} s")));
    first.push(Span::raw(format!("  {}", model.session.port)));
    let mut second = vec![Span::styled(rate, bold), Span::raw("  ")];
    if let Some(statistics) = &model.statistics {
        let cycle = &statistics.cycle_us;
        second.push(Span::styled(format!("{lost} lost"), Style::new().fg(lost_color)));
        // Recordings do not know.
        if !model.is_recording {
            second.push(Span::raw(format!(", {} rejected", statistics.rejected)));
        }
        if let Some(baud) = statistics.baud {
            second.push(Span::raw(format!("  {} Mbaud", f64::from(baud) * 1e-6)));
        }
        second.push(Span::raw(format!("  cycle {:.0} us, 99 % {:.0} us", cycle.p50, cycle.p99)));
        second.push(Span::raw(format!(", longest {:.0} us", cycle.max)));
        if !model.is_recording {
            second.push(Span::raw(format!("  bus thread {:.0} %", 100.0 * statistics.cpu_share)));
        }
    }
    vec![fitted(width, first), fitted(width, second)]
}

/// As many of the parts as there is room for: none is cut in the middle.
fn fitted(width: u16, parts: Vec<Span<'static>>) -> Line<'static> {
    let mut line = Line::default();
    for (place, part) in parts.into_iter().enumerate() {
        if place > 0 && line.width() + part.width() > usize::from(width) {
            break;
        }
        line.push_span(part);
    }
    line
}

/// What is being recorded.
fn recording(model: &Model) -> Option<String> {
    let by_key = model.session.recorder.as_ref().and_then(|recorder| recorder.running());
    let file = model.session.recording.clone().or(by_key)?;
    Some(file.file_name().unwrap_or_default().to_string_lossy().into_owned())
}
