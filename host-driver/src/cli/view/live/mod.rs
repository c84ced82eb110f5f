//! Full screen: every chamber's command and pressure, loop rate, losses, board states.

mod draw;
mod keys;
mod model;

use super::{EndedBy, EventSender, Events, Session};
use crate::cli::failure::Failure;
use crate::cli::output::errln;
use keys::{Action, Input, Keys, Question};
use model::Model;
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::{Commanding, Poller};
use std::time::{Duration, Instant};

/// 20 pictures a second.
const FRAME: Duration = Duration::from_millis(50);
/// How often the bus thread is asked for its figures.
const FIGURES_EVERY: Duration = Duration::from_millis(500);

/// Draws until `stop`, the poller's own end, a key that ends the run, or the terminal closes. The terminal is put back in order on
/// every way out: `ratatui::init` also does so when something panics.
pub fn show(
    session: &Session,
    poller: &Poller,
    events: &Events,
    stop: impl Fn() -> bool,
) -> Result<EndedBy, Failure> {
    let terminal_error = |error| Failure::running(format!("terminal: {error}"));
    let mut terminal = ratatui::try_init().map_err(terminal_error)?;
    let keys = Keys::listen().map_err(terminal_error)?;
    let mut model = Model::new(session.clone());
    let mut figures = Instant::now();
    let ended = loop {
        if stop() {
            break EndedBy::Stop;
        }
        if poller.is_finished() {
            break EndedBy::Poller;
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
        if terminal.draw(|frame| draw::draw(frame, &model)).is_err() {
            break EndedBy::Terminal;
        }
        match keys.next(FRAME) {
            None => {}
            Some(Input::Gone) => break EndedBy::Terminal,
            Some(Input::Key(key)) => {
                let vented = session.overriding.commanding() == Commanding::Vented;
                if follow(keys::action(key, model.question.take(), vented), &mut model, &events.sender()) {
                    break EndedBy::Key;
                }
            }
        }
    };
    // A terminal that has closed cannot be put in order.
    let _ = ratatui::try_restore();
    if ended == EndedBy::Terminal {
        // When dropped it would show its cursor again, and panic where it cannot say that this failed.
        std::mem::forget(terminal);
    }
    model.events().for_each(|event| errln!("{event}"));
    Ok(ended)
}

/// Does what a key means; `true` if that is the end of the run.
fn follow(action: Action, model: &mut Model, events: &EventSender) -> bool {
    let note = |text: &str| events.note(&Notice::new(NoticeKind::Key, text));
    match action {
        Action::Nothing => {}
        Action::Vent => {
            model.session.overriding.vent();
            note("vented from the keyboard");
        }
        Action::Ask(question) => model.question = Some(question),
        Action::Release => {
            model.session.overriding.release();
            note("released from the keyboard");
        }
        Action::End => return true,
        Action::Scroll(boards) => model.scroll(boards),
    }
    false
}

/// The question in words. What a release does depends on who vented.
fn words(question: Question, session: &Session) -> &'static str {
    match question {
        Question::End => "End the run? Boards go to 0 kPa. y ends it, any other key goes on.",
        Question::Release if session.overriding.returns() => {
            "Release? Set points return by a ramp. y releases, any other key stays vented."
        }
        Question::Release => "Release? Set points stay at 0 kPa. y releases, any other key stays vented.",
    }
}
