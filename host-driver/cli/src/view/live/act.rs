//! What keys do.

use super::keys::Action;
use super::model::Model;
use crate::view::EventSender;
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::{Commanding, VENTED};
use pneudrive_host::replay::Player;

/// Does what a key means; `true` if that is the end of the run.
pub fn follow(action: Action, model: &mut Model, events: &EventSender) -> bool {
    let note = |text: &str| events.note(&Notice::new(NoticeKind::Key, text));
    match action {
        Action::Nothing | Action::Pause | Action::Skip(_) => {}
        Action::Vent => {
            model.session.overriding.vent();
            disarm(model);
            note("vented from the keyboard");
        }
        Action::Ask(question) => model.question = Some(question),
        Action::Release => {
            model.session.overriding.release();
            note("released from the keyboard");
        }
        Action::End => return true,
        Action::Select(channels) => model.select(channels),
        Action::Arm => arm(model),
        Action::Back if model.help => model.help = false,
        Action::Back if !model.typed.is_empty() => model.typed.clear(),
        Action::Back => disarm(model),
        Action::Jog(kpa) => {
            let at = aimed(model);
            aim(model, at + f64::from(kpa), events);
        }
        Action::Type(c) if model.typed.len() < 8 => model.typed.push(c),
        Action::Type(_) => {}
        Action::Rub => drop(model.typed.pop()),
        Action::Enter => enter(model, events),
        Action::Record => record(model, events),
        Action::Help => model.help = !model.help,
        Action::Events(lines) => model.scroll_events(lines),
    }
    false
}

/// What a key does to a recording.
pub fn play(action: Action, player: &Player) {
    match action {
        Action::Pause => player.pause(),
        Action::Skip(seconds) => player.skip(f64::from(seconds)),
        _ => {}
    }
}

/// Moves set points on their way; called for every picture.
pub fn step(model: &mut Model) {
    if model.is_vented() && model.jog.armed().is_some() {
        disarm(model);
        return;
    }
    for ((index, channel), kpa) in model.jog.step(model.now_ns) {
        let Some(board) = model.snapshot.boards.get(index) else { continue };
        let scale = model.session.setup.calibration.channel(board.board, channel);
        let counts = scale.counts(kpa).map_err(|error| error.to_string());
        let set = counts.and_then(|counts| {
            model.session.overriding.set(index, channel, counts).map_err(|refused| refused.to_string())
        });
        if let Err(refused) = set {
            disarm(model);
            model.say(refused);
            return;
        }
    }
}

fn disarm(model: &mut Model) {
    model.jog.disarm();
    model.typed.clear();
}

fn arm(model: &mut Model) {
    let (board, _) = model.place();
    if model.jog.armed() == Some(board) {
        return disarm(model);
    }
    match model.session.overriding.commanding() {
        Commanding::Vented => model.say("vented: release with r, then arm"),
        Commanding::Following => {
            model.say("a trajectory commands the boards: vent and release to command by hand")
        }
        Commanding::Manual => model.jog.arm(board, model.now_ns),
    }
}

/// Where the selected set point is, or is going, kPa.
fn aimed(model: &Model) -> f64 {
    let place @ (index, channel) = model.place();
    model.jog.target(place).unwrap_or_else(|| set_point(model, index, channel))
}

/// The set point as it is, kPa.
fn set_point(model: &Model, index: usize, channel: usize) -> f64 {
    let Some(board) = model.snapshot.boards.get(index) else { return 0.0 };
    // What is commanded now is where a ramp has to begin: after a release that is 0 kPa.
    let command = model.session.overriding.set_point(index).unwrap_or(VENTED);
    model.session.setup.calibration.command_kpa(board.board, command)[channel]
}

/// The highest set point of the selected channel, kPa.
fn highest(model: &Model) -> f64 {
    let (index, channel) = model.place();
    let Some(board) = model.snapshot.boards.get(index) else { return 0.0 };
    let limit = model.session.limits.of(board.board)[channel].max_kpa;
    limit.min(model.session.setup.calibration.channel(board.board, channel).full_scale_kpa())
}

fn aim(model: &mut Model, kpa: f64, events: &EventSender) {
    let place @ (index, channel) = model.place();
    let highest = highest(model);
    let (from, to, now_ns) = (set_point(model, index, channel), kpa.clamp(0.0, highest), model.now_ns);
    if !model.jog.aim(place, from, to, now_ns) {
        return model.say("not armed: a arms the selected board");
    }
    let Some(board) = model.snapshot.boards.get(index) else { return };
    let text = format!("board {}, channel {channel} to {to:.1} kPa, from the keyboard", board.board);
    events.note(&Notice::new(NoticeKind::Key, text));
}

/// Sends the number that was typed.
fn enter(model: &mut Model, events: &EventSender) {
    let typed = std::mem::take(&mut model.typed);
    if typed.is_empty() {
        return;
    }
    let unit = model.session.setup.unit;
    let highest = highest(model);
    match typed.parse::<f64>() {
        Ok(number) if number * unit.kpa() <= highest + 1e-9 => aim(model, number * unit.kpa(), events),
        Ok(_) => model.say(format!(
            "{typed} {} is above the highest set point of this channel, {} {}",
            unit.name(),
            unit.number(highest),
            unit.name()
        )),
        Err(_) => model.say(format!("\"{typed}\" is no number")),
    }
}

fn record(model: &mut Model, events: &EventSender) {
    let said = match &model.session.recorder {
        Some(recorder) => recorder.toggle(),
        None => Err("no recording here: the run is recorded anyway, or the view has no folder".to_owned()),
    };
    match said {
        Ok(text) => events.happened(Notice::new(NoticeKind::Key, text)),
        Err(text) => model.say(text),
    }
}
