//! Which of the two packet formats a board is spoken to in.

use pneudrive_protocol::{PacketFormat, Sequence};
use serde::Serialize;

/// Which packet formats may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FormatPolicy {
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

/// Which packet format a board understands, as far as that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BoardFormat {
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
pub(super) struct FormatNegotiation {
    policy: FormatPolicy,
    known: BoardFormat,
    sequence: Sequence,
    /// Requests in a row without an answer.
    silent: u32,
}

impl FormatNegotiation {
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

    pub(super) fn new(policy: FormatPolicy) -> Self {
        let known = match policy {
            FormatPolicy::Negotiate => BoardFormat::Unknown,
            FormatPolicy::Unchecked => BoardFormat::Unchecked,
            FormatPolicy::Checked => BoardFormat::Checked,
        };
        Self { policy, known, sequence: Sequence::default(), silent: 0 }
    }

    /// Which it understands.
    pub(super) fn known(&self) -> BoardFormat {
        self.known
    }

    /// The format of the next request.
    pub(super) fn next(&mut self) -> PacketFormat {
        let checked = match self.known {
            BoardFormat::Checked => true,
            BoardFormat::Unchecked => false,
            BoardFormat::Unknown => self.silent % (Self::CHECKED_TRIES + 1) < Self::CHECKED_TRIES,
        };
        if checked { PacketFormat::Checked(self.next_sequence()) } else { PacketFormat::Unchecked }
    }

    /// The number of the next request with a CRC.
    pub(super) fn next_sequence(&mut self) -> Sequence {
        self.sequence = self.sequence.next();
        self.sequence
    }

    pub(super) fn answered(&mut self, format: PacketFormat) {
        self.silent = 0;
        self.known = match format {
            PacketFormat::Checked(_) | PacketFormat::Sealed(_) => BoardFormat::Checked,
            PacketFormat::Unchecked => BoardFormat::Unchecked,
        };
    }

    pub(super) fn failed(&mut self) {
        self.silent = self.silent.saturating_add(1);
        let exchanged = self.known == BoardFormat::Unchecked && self.silent >= Self::FORGOTTEN_AFTER;
        if self.policy == FormatPolicy::Negotiate && exchanged {
            self.known = BoardFormat::Unknown;
            self.silent = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_checked(negotiation: &mut FormatNegotiation) -> bool {
        matches!(negotiation.next(), PacketFormat::Checked(_))
    }

    #[test]
    fn an_unknown_board_is_asked_in_both_formats_checked_first() {
        let mut negotiation = FormatNegotiation::new(FormatPolicy::Negotiate);
        let asked: Vec<_> = (0..6)
            .map(|_| {
                let checked = is_checked(&mut negotiation);
                negotiation.failed();
                checked
            })
            .collect();
        assert_eq!(asked, [true, true, false, true, true, false]);
    }

    #[test]
    fn a_board_that_checks_is_never_asked_otherwise() {
        let mut negotiation = FormatNegotiation::new(FormatPolicy::Negotiate);
        let format = negotiation.next();
        negotiation.answered(format);
        for _ in 0..100 {
            negotiation.failed();
            assert!(is_checked(&mut negotiation));
        }
    }

    #[test]
    fn an_original_board_that_goes_away_may_come_back_as_another() {
        let mut negotiation = FormatNegotiation::new(FormatPolicy::Negotiate);
        negotiation.answered(PacketFormat::Unchecked);
        for _ in 0..3 {
            assert!(!is_checked(&mut negotiation));
            negotiation.failed();
        }
        assert!(is_checked(&mut negotiation));
    }

    #[test]
    fn requests_are_numbered() {
        let mut negotiation = FormatNegotiation::new(FormatPolicy::Checked);
        assert_ne!(negotiation.next(), negotiation.next());
    }
}
