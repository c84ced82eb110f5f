//! Keys of the terminal, and whether it is still there.
//!
//! They are read on a thread of their own: crossterm's reader never returns from a terminal that
//! has closed, and the run must go on to vent its boards.

use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use std::io::stdin;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// What the terminal has to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// A key was pressed.
    Key(KeyEvent),
    /// The terminal has closed.
    Gone,
}

/// The terminal's keys.
pub struct Keys(Receiver<KeyEvent>);

impl Keys {
    /// Reads keys from now on.
    pub fn listen() -> std::io::Result<Self> {
        let (sender, receiver) = channel();
        std::thread::Builder::new().name("pneudrive-keys".into()).spawn(move || read(&sender))?;
        Ok(Self(receiver))
    }

    /// The next key, waited for at most this long.
    pub fn next(&self, patience: Duration) -> Option<Input> {
        match self.0.recv_timeout(patience) {
            Ok(key) => Some(Input::Key(key)),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(Input::Gone),
        }
    }
}

/// Until the terminal closes or nobody listens.
fn read(sender: &Sender<KeyEvent>) {
    loop {
        let stdin = stdin();
        let mut files = [PollFd::new(&stdin, PollFlags::IN)];
        match poll(&mut files, None) {
            Err(Errno::INTR) => continue,
            Err(_) => return,
            Ok(_) => {}
        }
        if files[0].revents().intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL) {
            return;
        }
        // Some keys may have come together.
        loop {
            match crossterm::event::read() {
                Ok(Event::Key(key)) if key.kind == KeyEventKind::Press => {
                    if sender.send(key).is_err() {
                        return;
                    }
                }
                Ok(_) => {}
                Err(_) => return,
            }
            if !crossterm::event::poll(Duration::ZERO).unwrap_or(false) {
                break;
            }
        }
    }
}

/// Something to be confirmed by another key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Whether the run is to end.
    End,
    /// Whether vented boards are to be released.
    Release,
}

/// What a key means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Nothing; an open question is answered with no.
    Nothing,
    /// Vent all boards.
    Vent,
    /// Put this question.
    Ask(Question),
    /// Release vented boards.
    Release,
    /// End the run.
    End,
    /// Select a channel, so many further down.
    Select(isize),
    /// Arm the selected channel's board, or disarm it.
    Arm,
    /// Disarm, close the help, give up a number.
    Back,
    /// Change the selected set point, kPa.
    Jog(i32),
    /// A character of a set point that is typed.
    Type(char),
    /// Take the last character back.
    Rub,
    /// Send what was typed.
    Enter,
    /// Start or stop a recording.
    Record,
    /// Show the keys, or hide them.
    Help,
    /// Older events, so many lines.
    Events(isize),
    /// A recording stands still, or goes on.
    Pause,
    /// A recording goes so many seconds forward, or back.
    Skip(i32),
}

/// What the meaning of a key depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Mode {
    /// The open question.
    pub open: Option<Question>,
    /// The boards are vented.
    pub vented: bool,
    /// A board is armed.
    pub armed: bool,
    /// A number is being typed, or the help is shown.
    pub busy: bool,
    /// It is a recording: there is nothing to vent, to arm or to record.
    pub recording: bool,
}

/// The meaning of `key`. Whatever may be meant to vent vents, whatever is open.
pub fn action(key: KeyEvent, mode: Mode) -> Action {
    let Mode { open, vented, armed, busy, recording } = mode;
    if recording {
        match (key.code, open) {
            (KeyCode::Char(' ' | 'p' | 'P'), None) => return Action::Pause,
            (KeyCode::Right, None) => return Action::Skip(5),
            (KeyCode::Left, None) => return Action::Skip(-5),
            (KeyCode::Char('v' | 'V' | ' ' | 'a' | 'A' | 'r' | 'R' | 'w' | 'W'), _) => {
                return Action::Nothing;
            }
            _ => {}
        }
    }
    match (key.code, open) {
        (KeyCode::Char('v' | 'V' | ' '), _) => Action::Vent,
        (KeyCode::Char('c'), _) if key.modifiers.contains(KeyModifiers::CONTROL) => Action::End,
        (KeyCode::Char('q' | 'Q'), _) => Action::End,
        (KeyCode::Char('y' | 'Y'), Some(Question::End)) => Action::End,
        (KeyCode::Char('y' | 'Y'), Some(Question::Release)) => Action::Release,
        (KeyCode::Char('r' | 'R'), _) if vented => Action::Ask(Question::Release),
        (_, Some(_)) => Action::Nothing,
        (KeyCode::Esc, None) if armed || busy => Action::Back,
        (KeyCode::Esc, None) => Action::Ask(Question::End),
        (KeyCode::Down | KeyCode::Tab, None) => Action::Select(1),
        (KeyCode::Up | KeyCode::BackTab, None) => Action::Select(-1),
        (KeyCode::PageDown, None) => Action::Events(-1),
        (KeyCode::PageUp, None) => Action::Events(1),
        (KeyCode::Char('?' | 'h'), None) => Action::Help,
        (KeyCode::Char('w' | 'W'), None) => Action::Record,
        (KeyCode::Char('a' | 'A'), None) => Action::Arm,
        (KeyCode::Right, None) if armed => Action::Jog(1),
        (KeyCode::Left, None) if armed => Action::Jog(-1),
        (KeyCode::Char('+'), None) if armed => Action::Jog(10),
        (KeyCode::Char('-'), None) if armed => Action::Jog(-10),
        (KeyCode::Char(c @ ('0'..='9' | '.')), None) if armed => Action::Type(c),
        (KeyCode::Char(','), None) if armed => Action::Type('.'),
        (KeyCode::Backspace, None) if armed => Action::Rub,
        (KeyCode::Enter, None) if armed => Action::Enter,
        _ => Action::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(code: KeyCode, open: Option<Question>) -> Action {
        action(KeyEvent::from(code), Mode { open, vented: true, ..Mode::default() })
    }

    #[test]
    fn whatever_may_mean_it_vents_whatever_is_asked() {
        for key in ['v', 'V', ' '] {
            for open in [None, Some(Question::End), Some(Question::Release)] {
                for (armed, busy) in [(false, false), (true, false), (true, true)] {
                    let mode = Mode { open, armed, busy, ..Mode::default() };
                    assert_eq!(
                        action(KeyEvent::from(KeyCode::Char(key)), mode),
                        Action::Vent,
                        "{key:?}, {mode:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn escape_asks_and_only_a_yes_ends() {
        assert_eq!(meaning(KeyCode::Esc, None), Action::Ask(Question::End));
        assert_eq!(meaning(KeyCode::Char('y'), Some(Question::End)), Action::End);
        for other in [KeyCode::Esc, KeyCode::Char('n'), KeyCode::Enter, KeyCode::Char('1')] {
            assert_eq!(meaning(other, Some(Question::End)), Action::Nothing, "{other:?}");
        }
        assert_eq!(meaning(KeyCode::Char('y'), None), Action::Nothing);
        // With something open, Esc closes that first.
        for (armed, busy) in [(true, false), (false, true)] {
            let mode = Mode { armed, busy, ..Mode::default() };
            assert_eq!(action(KeyEvent::from(KeyCode::Esc), mode), Action::Back);
        }
    }

    #[test]
    fn a_release_takes_two_keys_and_a_vent_to_be_released() {
        let release = KeyEvent::from(KeyCode::Char('r'));
        assert_eq!(action(release, Mode::default()), Action::Nothing);
        assert_eq!(meaning(KeyCode::Char('r'), None), Action::Ask(Question::Release));
        assert_eq!(meaning(KeyCode::Char('r'), Some(Question::Release)), Action::Ask(Question::Release));
        assert_eq!(meaning(KeyCode::Char('y'), Some(Question::Release)), Action::Release);
    }

    #[test]
    fn set_points_move_only_on_an_armed_board() {
        for code in [KeyCode::Right, KeyCode::Left, KeyCode::Char('+'), KeyCode::Char('5'), KeyCode::Enter] {
            assert_eq!(action(KeyEvent::from(code), Mode::default()), Action::Nothing, "{code:?}");
            let armed = Mode { armed: true, ..Mode::default() };
            assert_ne!(action(KeyEvent::from(code), armed), Action::Nothing, "{code:?}");
        }
    }

    #[test]
    fn a_recording_commands_nothing() {
        let mode = Mode { recording: true, ..Mode::default() };
        let meaning = |code| action(KeyEvent::from(code), mode);
        assert_eq!(meaning(KeyCode::Char(' ')), Action::Pause);
        assert_eq!((meaning(KeyCode::Left), meaning(KeyCode::Right)), (Action::Skip(-5), Action::Skip(5)));
        for key in ['v', 'V', 'a', 'r', 'w', '5'] {
            assert_eq!(meaning(KeyCode::Char(key)), Action::Nothing, "{key}");
        }
        assert_eq!(meaning(KeyCode::Char('q')), Action::End);
    }

    #[test]
    fn ctrl_c_ends_and_c_does_not() {
        let key = |modifiers| action(KeyEvent::new(KeyCode::Char('c'), modifiers), Mode::default());
        assert_eq!(key(KeyModifiers::CONTROL), Action::End);
        assert_eq!(key(KeyModifiers::NONE), Action::Nothing);
    }
}
