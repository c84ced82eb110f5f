//! Full screen: every chamber's command and pressure, loop rate, losses, board states.

mod draw;
mod model;

use super::{Events, Session};
use crate::cli::failure::Failure;
use crossterm::event::{Event, KeyCode, KeyEventKind, KeyModifiers};
use model::Model;
use pneudrive_host::poller::Poller;
use std::time::{Duration, Instant};

/// 20 pictures a second.
const FRAME: Duration = Duration::from_millis(50);
/// How often the bus thread is asked for its figures.
const FIGURES_EVERY: Duration = Duration::from_millis(500);

/// Draws until `stop`, the poller's own end, q or Ctrl-C. The terminal is put back in order on every way out: `ratatui::init`
/// also does so when something panics.
pub fn show(
    session: &Session,
    poller: &Poller,
    events: &Events,
    stop: impl Fn() -> bool,
) -> Result<(), Failure> {
    let mut terminal = ratatui::try_init().map_err(|error| Failure::running(format!("terminal: {error}")))?;
    let mut model = Model::new(session.clone());
    let mut figures = Instant::now();
    let result = loop {
        if stop() || poller.is_finished() {
            break Ok(());
        }
        while let Some(event) = events.next() {
            model.happened(event);
        }
        if figures.elapsed() >= FIGURES_EVERY {
            figures = Instant::now();
            if let Some(statistics) = poller.statistics() {
                model.figures(statistics);
            }
        }
        model.sample(poller.latest(), session.clock.now_ns());
        if let Err(error) = terminal.draw(|frame| draw::draw(frame, &model)) {
            break Err(error);
        }
        match wants_to_quit(&mut model) {
            Ok(false) => {}
            Ok(true) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    ratatui::restore();
    model.events().for_each(|event| eprintln!("{event}"));
    result.map_err(|error| Failure::running(format!("terminal: {error}")))
}

/// Waits for a key until the next picture is due.
fn wants_to_quit(model: &mut Model) -> std::io::Result<bool> {
    if !crossterm::event::poll(FRAME)? {
        return Ok(false);
    }
    let Event::Key(key) = crossterm::event::read()? else { return Ok(false) };
    if key.kind != KeyEventKind::Press {
        return Ok(false);
    }
    match key.code {
        KeyCode::Char('q') | KeyCode::Esc => return Ok(true),
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => return Ok(true),
        KeyCode::Char('v') => {
            model.session.overriding.vent();
            model.happened("all boards vented (v)".into());
        }
        KeyCode::Down => model.scroll(1),
        KeyCode::Up => model.scroll(-1),
        _ => {}
    }
    Ok(false)
}
