//! Which of the two packet formats a board is spoken to in.

use pneudrive_protocol::{Format, Sequence};
use serde::Serialize;

/// Which packet formats may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameMode {
    /// Checked with boards that understand it, unchecked with the original kind. Found out for each
    /// board.
    #[default]
    Negotiate,
    /// Only the original's format.
    Unchecked,
    /// Only the format with CRC and sequence number: boards of the original kind answer in their
    /// own, and obey nothing.
    Checked,
}

/// What is known of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Frames {
    /// It has not answered yet.
    Unknown,
    /// It understands checked packets. It is never asked otherwise again: what looks like an
    /// unchecked answer of such a board can only be a damaged one.
    Checked,
    /// It is of the original kind.
    Unchecked,
}

/// The host's side of the agreement with one board.
#[derive(Debug, Clone)]
pub(super) struct Dialect {
    mode: FrameMode,
    frames: Frames,
    sequence: Sequence,
    /// Requests in a row without an answer.
    silent: u32,
}

impl Dialect {
    /// A board that does not answer checked requests so often in a row is asked once in the
    /// original's format.
    ///
    /// A board of the original kind answers a checked request, in its own format, and drops the
    /// commands: that answer tells its kind at once, without this. A damaged answer of a board that
    /// checks can be taken for it only if all of its 20 spare bits have become 0. Then the board is
    /// asked in the original's format, which it ignores, because it has heard a checked request;
    /// after [`FORGOTTEN_AFTER`](Self::FORGOTTEN_AFTER) such requests it is unknown again. No
    /// answer of it is believed meanwhile.
    pub(super) const CHECKED_TRIES: u32 = 2;
    /// An original board that has been silent so often may have been exchanged for another.
    const FORGOTTEN_AFTER: u32 = 3;

    pub(super) fn new(mode: FrameMode) -> Self {
        let frames = match mode {
            FrameMode::Negotiate => Frames::Unknown,
            FrameMode::Unchecked => Frames::Unchecked,
            FrameMode::Checked => Frames::Checked,
        };
        Self { mode, frames, sequence: Sequence::default(), silent: 0 }
    }

    pub(super) fn frames(&self) -> Frames {
        self.frames
    }

    /// The format of the next request.
    pub(super) fn next(&mut self) -> Format {
        let checked = match self.frames {
            Frames::Checked => true,
            Frames::Unchecked => false,
            Frames::Unknown => self.silent % (Self::CHECKED_TRIES + 1) < Self::CHECKED_TRIES,
        };
        if checked { Format::Checked(self.next_sequence()) } else { Format::Unchecked }
    }

    /// The number of the next request with a CRC.
    pub(super) fn next_sequence(&mut self) -> Sequence {
        self.sequence = self.sequence.next();
        self.sequence
    }

    pub(super) fn answered(&mut self, format: Format) {
        self.silent = 0;
        self.frames = match format {
            Format::Checked(_) | Format::Sealed(_) => Frames::Checked,
            Format::Unchecked => Frames::Unchecked,
        };
    }

    pub(super) fn failed(&mut self) {
        self.silent = self.silent.saturating_add(1);
        let exchanged = self.frames == Frames::Unchecked && self.silent >= Self::FORGOTTEN_AFTER;
        if self.mode == FrameMode::Negotiate && exchanged {
            self.frames = Frames::Unknown;
            self.silent = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_checked(dialect: &mut Dialect) -> bool {
        matches!(dialect.next(), Format::Checked(_))
    }

    #[test]
    fn an_unknown_board_is_asked_in_both_formats_checked_first() {
        let mut dialect = Dialect::new(FrameMode::Negotiate);
        let asked: Vec<_> = (0..6)
            .map(|_| {
                let checked = is_checked(&mut dialect);
                dialect.failed();
                checked
            })
            .collect();
        assert_eq!(asked, [true, true, false, true, true, false]);
    }

    #[test]
    fn a_board_that_checks_is_never_asked_otherwise() {
        let mut dialect = Dialect::new(FrameMode::Negotiate);
        let format = dialect.next();
        dialect.answered(format);
        for _ in 0..100 {
            dialect.failed();
            assert!(is_checked(&mut dialect));
        }
    }

    #[test]
    fn an_original_board_that_goes_away_may_come_back_as_another() {
        let mut dialect = Dialect::new(FrameMode::Negotiate);
        dialect.answered(Format::Unchecked);
        for _ in 0..3 {
            assert!(!is_checked(&mut dialect));
            dialect.failed();
        }
        assert!(is_checked(&mut dialect));
    }

    #[test]
    fn requests_are_numbered() {
        let mut dialect = Dialect::new(FrameMode::Checked);
        assert_ne!(dialect.next(), dialect.next());
    }
}
