//! Keys of the terminal, and whether it is still there.
//!
//! They are read on a thread of their own: crossterm's reader never returns from a terminal that has
//! closed, and the run must go on to vent its boards.

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
    /// Show other boards, so many further down.
    Scroll(isize),
}

/// The meaning of `key` while `open` is the open question. Whatever may be meant to vent vents.
pub fn action(key: KeyEvent, open: Option<Question>, vented: bool) -> Action {
    match (key.code, open) {
        (KeyCode::Char('v' | 'V' | ' '), _) => Action::Vent,
        (KeyCode::Char('c'), _) if key.modifiers.contains(KeyModifiers::CONTROL) => Action::End,
        (KeyCode::Char('q' | 'Q'), _) => Action::End,
        (KeyCode::Char('y' | 'Y'), Some(Question::End)) => Action::End,
        (KeyCode::Char('y' | 'Y'), Some(Question::Release)) => Action::Release,
        (KeyCode::Esc, None) => Action::Ask(Question::End),
        (KeyCode::Char('r' | 'R'), _) if vented => Action::Ask(Question::Release),
        (KeyCode::Down, None) => Action::Scroll(1),
        (KeyCode::Up, None) => Action::Scroll(-1),
        _ => Action::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(code: KeyCode, open: Option<Question>) -> Action {
        action(KeyEvent::from(code), open, true)
    }

    #[test]
    fn whatever_may_mean_it_vents_whatever_is_asked() {
        for key in ['v', 'V', ' '] {
            for open in [None, Some(Question::End), Some(Question::Release)] {
                assert_eq!(meaning(KeyCode::Char(key), open), Action::Vent, "{key:?}, {open:?}");
            }
        }
    }

    #[test]
    fn escape_asks_and_only_a_yes_ends() {
        assert_eq!(meaning(KeyCode::Esc, None), Action::Ask(Question::End));
        assert_eq!(meaning(KeyCode::Char('y'), Some(Question::End)), Action::End);
        for other in [KeyCode::Esc, KeyCode::Char('n'), KeyCode::Enter] {
            assert_eq!(meaning(other, Some(Question::End)), Action::Nothing, "{other:?}");
        }
        assert_eq!(meaning(KeyCode::Char('y'), None), Action::Nothing);
    }

    #[test]
    fn a_release_takes_two_keys_and_a_vent_to_be_released() {
        let release = KeyEvent::from(KeyCode::Char('r'));
        assert_eq!(action(release, None, false), Action::Nothing);
        assert_eq!(action(release, None, true), Action::Ask(Question::Release));
        assert_eq!(meaning(KeyCode::Char('r'), Some(Question::Release)), Action::Ask(Question::Release));
        assert_eq!(meaning(KeyCode::Char('y'), Some(Question::Release)), Action::Release);
    }

    #[test]
    fn ctrl_c_ends_and_c_does_not() {
        let key = |modifiers| action(KeyEvent::new(KeyCode::Char('c'), modifiers), None, false);
        assert_eq!(key(KeyModifiers::CONTROL), Action::End);
        assert_eq!(key(KeyModifiers::NONE), Action::Nothing);
    }
}
