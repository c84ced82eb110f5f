//! Sessions: requests that a board obeys once, and from one host.
//!
//! A board gives its host a session number ([`SessionOffer`](crate::pages::SessionOffer)). From
//! then on the session number, the board's number and a consecutive number of the request go into
//! the CRC of every request and answer without being sent, as the virtual consecutive number of
//! PROFIsafe does (IEC 61784-3-3). Sent are the consecutive number's lowest four bits, the
//! [`Sequence`]. A board obeys a request only if its number is one of the
//! [`WINDOW`](RequestNumber::WINDOW) that follow the last one that it obeyed: so a repeated
//! request, one of an earlier session, of another host, or one that was meant for another board has
//! another CRC than the board expects.
//!
//! ```text
//!  consecutive number, 19 bits
//!  +--------------------------------+-------------+
//!  | round, 15 bits: in the CRC     | sequence: 4 |
//!  +--------------------------------+-------------+
//! ```
//!
//! **Hamming distance.** What is not sent cannot be damaged, but damage to the sequence can make
//! the board expect the round after or before the right one, and so another CRC. Of the window's
//! eight numbers all that lie in one round have the same highest bit of the sequence on one side of
//! the round's end, and the other on the other side: such damage flips that bit. Two rounds that
//! follow each other differ, as in a Gray code, by one of 15 CRC differences, and each of these is
//! one that this bit and up to four other flipped bits cannot make. So every error of up to five
//! bits is found, as without sessions (`tests/session_distance.rs` tries them all). The 15
//! differences are linearly independent: all 32,768 rounds have different CRCs, and a request fits
//! again 524,288 requests later at the earliest.

use crate::spare_bits::session_crc;
use crate::{Address, Sequence};

/// The place of a request in its session, 0 to 524,287; 0 follows on the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct RequestNumber(u32);

impl RequestNumber {
    /// How many different ones there are.
    pub const MODULUS: u32 = 1 << (15 + Self::SEQUENCE_BITS);
    /// How far a request's number may be ahead of that of the last one that was obeyed: up to seven
    /// can be lost in a row.
    pub const WINDOW: u8 = 8;
    const SEQUENCE_BITS: u32 = 4;

    /// `number` modulo [`MODULUS`](Self::MODULUS).
    pub const fn new(number: u32) -> Self {
        Self(number % Self::MODULUS)
    }

    /// 0 to 524,287.
    pub const fn get(self) -> u32 {
        self.0
    }

    /// The one after it.
    #[must_use]
    pub const fn next(self) -> Self {
        Self::new(self.0 + 1)
    }

    /// The part of it that is sent.
    pub const fn sequence(self) -> Sequence {
        Sequence::new(self.0 as u8 % Sequence::MODULUS)
    }

    /// How many requests it is after `earlier`.
    pub const fn since(self, earlier: Self) -> u32 {
        (self.0 + Self::MODULUS - earlier.0) % Self::MODULUS
    }

    /// The number that a request with this sequence has if `self` was obeyed last; `None` outside
    /// the window.
    pub fn following(self, sequence: Sequence) -> Option<Self> {
        let ahead = sequence.get().wrapping_sub(self.sequence().get()) % Sequence::MODULUS;
        (1..=Self::WINDOW).contains(&ahead).then(|| Self::new(self.0 + u32::from(ahead)))
    }

    /// The last number with this sequence that is not after `self`.
    pub const fn latest(self, sequence: Sequence) -> Self {
        let back = self.sequence().get().wrapping_sub(sequence.get()) % Sequence::MODULUS;
        Self::new(self.0 + Self::MODULUS - back as u32)
    }

    const fn round(self) -> u32 {
        self.0 >> Self::SEQUENCE_BITS
    }
}

/// What host and board have agreed on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Session {
    crc_difference: u16,
}

impl Session {
    /// The session with this number of the board with this address.
    pub fn new(address: Address, number: u32) -> Self {
        let crc = session_crc(address, number);
        // Odd, and rounds differ evenly: a request of a session never is one without.
        let crc_difference = if crc.count_ones().is_multiple_of(2) { crc ^ 1 } else { crc };
        Self { crc_difference }
    }

    /// The seal of the request with this number, and of its answer.
    pub fn seal(&self, number: RequestNumber) -> Seal {
        Seal { number, crc_difference: self.crc_difference ^ round_crc(number.round()) }
    }
}

/// What a session and a request's number in it change in the CRCs of request and answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Seal {
    number: RequestNumber,
    crc_difference: u16,
}

impl Seal {
    /// The request's number.
    pub const fn number(self) -> RequestNumber {
        self.number
    }

    /// The CRC with this seal is that without it, exclusive or this.
    pub const fn crc_difference(self) -> u16 {
        self.crc_difference
    }
}

/// By which of these a round differs from the one before it is told by its number of trailing
/// zeros. Found by trying all 65,536; the first 15 linearly independent ones that the module's
/// front page allows.
const ROUND_STEPS: [u16; 15] = [
    0x000C, 0x001E, 0x0024, 0x0035, 0x003C, 0x0044, 0x0084, 0x0110, 0x0202, 0x0404, 0x0808, 0x1015, 0x2004,
    0x4001, 0x8007,
];

/// The sum of the steps up to this round.
fn round_crc(round: u32) -> u16 {
    let gray = round ^ round >> 1;
    ROUND_STEPS
        .iter()
        .enumerate()
        .fold(0, |crc, (bit, step)| if gray >> bit & 1 == 1 { crc ^ step } else { crc })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn all_rounds_have_different_crcs_and_the_first_follows_on_the_last() {
        let rounds = RequestNumber::MODULUS >> RequestNumber::SEQUENCE_BITS;
        let crcs: HashSet<u16> = (0..rounds).map(round_crc).collect();
        assert_eq!(crcs.len(), 32_768);
        assert!(ROUND_STEPS.contains(&(round_crc(rounds - 1) ^ round_crc(0))));
        assert!(crcs.iter().all(|crc| crc.count_ones().is_multiple_of(2)));
    }

    #[test]
    fn the_window_is_the_eight_numbers_that_follow() {
        for last in [0, 7, 8, 15, 16, 12_345, RequestNumber::MODULUS - 1, RequestNumber::MODULUS - 5] {
            let last = RequestNumber::new(last);
            let mut allowed: std::vec::Vec<_> = (0..Sequence::MODULUS)
                .filter_map(|sequence| Some(last.following(Sequence::new(sequence))?.since(last)))
                .collect();
            allowed.sort_unstable();
            assert_eq!(allowed, [1, 2, 3, 4, 5, 6, 7, 8], "after {last:?}");
        }
    }

    #[test]
    fn the_latest_number_with_a_sequence_is_one_of_the_last_sixteen() {
        for now in [0, 3, 15, 16, 400_000] {
            let now = RequestNumber::new(now);
            for sequence in (0..16).map(Sequence::new) {
                let latest = now.latest(sequence);
                assert!(latest.sequence() == sequence && now.since(latest) < 16);
            }
        }
    }

    #[test]
    fn sessions_differ_by_number_and_by_board() {
        let session = |board, number| Session::new(Address::of_board(board), number);
        for board in 0..4 {
            assert!((0..4).all(|other| other == board || session(board, 77) != session(other, 77)));
        }
        let different: HashSet<u16> = (0..1_000).map(|number| session(0, number).crc_difference).collect();
        assert!(different.len() > 950, "{}", different.len());
    }
}
