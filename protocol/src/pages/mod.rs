//! Pages: what a board can be asked besides its pressures.
//!
//! A page request is a checked packet with a CRC of its own kind. It names a page and an entry in it and commands nothing: a
//! board that answers it goes on with the set points it has, its command timeout runs on, and it forgets no host for it. The
//! answer, of a fourth kind, has the request's number and the entry's four words of 10 bits:
//!
//! ```text
//!  word      page request                   page answer
//!    0       page, 0 to 101                 the entry's word 0, 0 to 1023
//!    1       entry in the page, 0 to 101    word 1
//!    2       0                              word 2
//!    3       0                              word 3
//! ```
//!
//! The words of a request stay below 102 counts, 0 kPa: damage that makes a command of it (five flipped bits of 68 at
//! least) makes one that vents, or moves with the damage alone. A board that does not have the entry answers with four words of 1023
//! ([`NO_SUCH_ENTRY`]), which no entry contains. Boards of before pages and original ones do not answer.
//!
//! | page | entries | contents |
//! | --- | --- | --- |
//! | 0, now | 0 | state of the board and of each channel ([`NowState`]) |
//! | | 1 | drive of each valve ([`Drives`]) |
//! | 1, counters | 0 to 13 | [`Counter`]s since power-up, one each |
//! | 2, the board | 0 | chip and version ([`About`]) |
//! | 3, post-mortem | 0 to 12 | words of the [`PostMortem`], all 0 if there is none |
//!
//! Numbers of 32 bits stand in the words' 40 bits, most significant ones first ([`number_entry`]). Entries of the same board may be of
//! different moments; each by itself is of one.

mod about;
mod counter;
mod now;
mod packets;
mod post_mortem;

pub use about::{About, ChipKind};
pub use counter::Counter;
pub use now::{ChannelNow, Drives, NowState, StateNow};
pub use packets::{PageAnswer, PageRequest};
pub use post_mortem::{FaultRegisters, FileName, PostMortem, StopCause};

use crate::{CHANNELS, Counts};

/// The four words of an entry, 10 bits each.
pub type Entry = [Counts; CHANNELS];

/// The answer to a request for an entry that the board does not have.
pub const NO_SUCH_ENTRY: Entry = [Counts::MAX; CHANNELS];

/// What can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PageEntry {
    /// A [`NowState`].
    State,
    /// [`Drives`].
    Drives,
    /// A number: see [`Counter`].
    Counter(Counter),
    /// An [`About`].
    About,
    /// A word of the [`PostMortem`], 0 to [`PostMortem::WORDS`] - 1; a number.
    PostMortemWord(u8),
}

impl PageEntry {
    /// Page and entry in it, as they stand in a request.
    pub const fn numbers(self) -> (u8, u8) {
        match self {
            Self::State => (0, 0),
            Self::Drives => (0, 1),
            Self::Counter(counter) => (1, counter as u8),
            Self::About => (2, 0),
            Self::PostMortemWord(word) => (3, word),
        }
    }

    /// The entry with these numbers, if there is one.
    pub fn of_numbers(page: u8, entry: u8) -> Option<Self> {
        match (page, entry) {
            (0, 0) => Some(Self::State),
            (0, 1) => Some(Self::Drives),
            (1, number) => Counter::of_number(number).map(Self::Counter),
            (2, 0) => Some(Self::About),
            (3, word) if usize::from(word) < PostMortem::WORDS => Some(Self::PostMortemWord(word)),
            _ => None,
        }
    }
}

/// A number of 32 bits as an entry: 2, 10, 10 and 10 bits, most significant first.
pub const fn number_entry(number: u32) -> Entry {
    const fn word(number: u32, shift: u32) -> Counts {
        Counts::saturating((number >> shift) as u16 & Counts::MAX.get())
    }
    [word(number, 30), word(number, 20), word(number, 10), word(number, 0)]
}

/// The number in an entry; `None` if it holds more than 32 bits.
pub fn number_in(entry: Entry) -> Option<u32> {
    let [first, ..] = entry.map(Counts::get);
    (first < 4).then(|| entry.iter().fold(0, |number, word| number << 10 | u32::from(word.get())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        for number in [0, 1, 1023, 1024, 0x1234_5678, u32::MAX] {
            assert_eq!(number_in(number_entry(number)), Some(number));
        }
        assert_eq!(number_in(NO_SUCH_ENTRY), None);
    }

    #[test]
    fn every_entry_has_its_own_numbers() {
        let all: std::vec::Vec<_> =
            (0..=u8::MAX).flat_map(|page| (0..=u8::MAX).map(move |entry| (page, entry))).collect();
        let known: std::vec::Vec<_> = all
            .into_iter()
            .filter_map(|(page, entry)| Some(((page, entry), PageEntry::of_numbers(page, entry)?)))
            .collect();
        assert_eq!(known.len(), 2 + Counter::ALL.len() + 1 + PostMortem::WORDS);
        for (numbers, entry) in known {
            assert_eq!(entry.numbers(), numbers);
            assert!(numbers.0 < 102 && numbers.1 < 102, "a request stays below 0 kPa");
        }
    }
}
