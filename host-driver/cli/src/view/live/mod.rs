//! Full screen: every chamber's command and pressure, loop rate, losses, board states.

mod act;
mod draw;
mod jog;
mod keys;
mod model;

use super::{EndedBy, Events, Session, Watched};
use crate::failure::Failure;
use crate::output::errln;
use keys::{Input, Keys, Mode, Question};
use model::Model;
use std::time::{Duration, Instant};

/// 20 pictures a second.
const FRAME: Duration = Duration::from_millis(50);
/// How often the bus thread is asked for its figures.
const FIGURES_EVERY: Duration = Duration::from_millis(500);

/// Draws until `stop`, the poller's own end, a key that ends the run, or the terminal closes. The
/// terminal is put back in order on every way out: `ratatui::init` also does so when something
/// panics.
pub fn show(
    session: &Session,
    watched: Watched<'_>,
    events: &Events,
    stop: impl Fn() -> bool,
) -> Result<EndedBy, Failure> {
    let terminal_error = |error| Failure::running(format!("terminal: {error}"));
    let mut terminal = ratatui::try_init().map_err(terminal_error)?;
    let keys = Keys::listen().map_err(terminal_error)?;
    let monitor = watched.monitor();
    let mut model = Model::new(session.clone());
    model.is_recording = watched.recording().is_some();
    let mut figures = Instant::now();
    let ended = loop {
        if stop() {
            break EndedBy::Stop;
        }
        if watched.is_finished() {
            break EndedBy::Poller;
        }
        while let Some(event) = events.next() {
            model.happened(event);
        }
        if figures.elapsed() >= FIGURES_EVERY {
            figures = Instant::now();
            if let Some(statistics) = monitor.statistics() {
                model.figures(statistics);
            }
        }
        model.sample(monitor.latest(), session.clock.now_ns());
        act::step(&mut model);
        if terminal.draw(|frame| draw::draw(frame, &model)).is_err() {
            break EndedBy::Terminal;
        }
        match keys.next(FRAME) {
            None => {}
            Some(Input::Gone) => break EndedBy::Terminal,
            Some(Input::Key(key)) => {
                let mode = Mode {
                    open: model.question.take(),
                    vented: model.is_vented(),
                    armed: model.jog.armed().is_some(),
                    busy: model.help || !model.typed.is_empty(),
                    recording: watched.recording().is_some(),
                };
                let action = keys::action(key, mode);
                if let Some(player) = watched.recording() {
                    act::play(action, player);
                }
                if act::follow(action, &mut model, &events.sender()) {
                    break EndedBy::Key;
                }
            }
        }
    };
    // A terminal that has closed cannot be put in order.
    let _ = ratatui::try_restore();
    if ended == EndedBy::Terminal {
        // When dropped it would show its cursor again, and panic where it cannot say that this
        // failed.
        std::mem::forget(terminal);
    }
    model.events().for_each(|event| errln!("{event}"));
    Ok(ended)
}

/// The question in words. What a release does depends on who vented.
fn words(question: Question, model: &Model) -> &'static str {
    match question {
        Question::End if model.is_recording => "Leave the recording? y leaves, any other key stays.",
        Question::End => "End the run? Boards go to 0 kPa. y ends it, any other key goes on.",
        Question::Release if model.session.overriding.returns() => {
            "Release? Set points return by a ramp. y releases, any other key stays vented."
        }
        Question::Release => "Release? Set points stay at 0 kPa. y releases, any other key stays vented.",
    }
}
