//! Pages: what a board can be asked besides its pressures.
//!
//! A page request is a checked packet with a CRC of its own kind. It names a page and an entry in
//! it and commands nothing: a board that answers it goes on with the set points it has, its command
//! timeout runs on, and it forgets no host for it. The answer, of a fourth kind, has the request's
//! number and the entry's four words of 10 bits:
//!
//! ```text
//!  word      page request                   page answer
//!    0       page, 0 to 101                 the entry's word 0, 0 to 1023
//!    1       entry in the page, 0 to 101    word 1
//!    2       0; of a value 0 to 101         word 2
//!    3       0; of a value 0 to 101         word 3
//! ```
//!
//! The words of a request stay below 102 counts, 0 kPa: damage that makes a command of it (five
//! flipped bits of 68 at least) makes one that vents, or moves with the damage alone. A board that
//! does not have the entry answers with four words of 1023 ([`NO_SUCH_ENTRY`]), which no entry
//! contains. Boards of before pages and original ones do not answer.
//!
//! | page | entries | contents |
//! | --- | --- | --- |
//! | 0, now | 0 | state of the board and of each channel ([`NowState`]) |
//! | | 1 | drive of each valve ([`Drives`]) |
//! | 1, counters | 0 to 15 | [`Counter`]s since power-up, one each |
//! | 2, the board | 0 | chip and version ([`About`]) |
//! | 3, post-mortem | 0 to 12 | words of the [`PostMortem`], all 0 if there is none |
//! | 4, session | 0 to 101 | a [`SessionOffer`]; the entry is a number of the host's |
//! | 5, parameters | 0 to 19 | value in effect of a [`Parameter`] |
//! | 6, as compiled | 0 to 19 | value that its firmware was compiled with |
//! | 7, store | 0 | a [`StoreState`] |
//! | 8, change | 0 to 2 | begin, begin from what was compiled, commit: a [`ChangeAnswer`] |
//! | 9, line rate | 0 | a [`LineRateState`] |
//! | | 1 to 3 | go to that [`LineRate`]: a [`LineRateAnswer`] |
//! | 10 to 19, set | 0 to 19 | a [`Parameter`] to the value (page - 10) x 10,404 + word 2 x 102 + word 3: a [`ChangeAnswer`] |
//! | 30, sensors | 0 to 4 | what is on the I2C connector: see [`SensorEntry`] |
//! | 31, electronics | 0 | chip temperature and rail voltage ([`Electronics`]) |
//! | 38, program | 0 | an [`UpdateState`] |
//! | | 1, 2 | three-byte pieces received; CRC-32 of the running program ([`UpdateEntry`]) |
//! | 39, update | 0 to 2 | begin, commit, confirm: an [`UpdateAnswer`] |
//! | 40 to 55, bytes | 0 to 101 | three bytes of a program ([`Update::Bytes`]): an [`UpdateAnswer`] |
//!
//! Pages 8 to 19 and from 39 on change something, see [`Change`], [`LineRate`] and [`Update`]; a
//! board obeys them in a session only.
//!
//! Numbers of 32 bits stand in the words' 40 bits, most significant ones first ([`number_entry`]).
//! Entries of the same board may be of different moments; each by itself is of one.

mod about;
mod change;
mod counter;
mod electronics;
mod line_rate;
mod now;
mod packets;
mod parameter;
mod post_mortem;
mod sensors;
mod session;
mod update;

pub use about::{About, ChipKind};
pub use change::{Change, ChangeAnswer, CommitOutcome, ParameterSource, StoreState};
pub use counter::Counter;
pub use electronics::{Electronics, Temperature, Voltage};
pub use line_rate::{LineRate, LineRateAnswer, LineRateState, RateReturn};
pub use now::{ChannelNow, Drives, NowState, StateNow};
pub use packets::{PageAnswer, PageRequest};
pub use parameter::{Parameter, ParameterInfo};
pub use post_mortem::{FaultRegisters, FileName, PostMortem, StopCause};
pub use sensors::{
    Acceleration, AngularRate, GaugePressure, SensorEntry, SensorPart, SensorState, SensorStatus,
    SensorTimes, SupplyReading,
};
pub use session::SessionOffer;
pub use update::{
    LastTrial, Running, Update, UpdateAnswer, UpdateEntry, UpdateOutcome, UpdateReply, UpdateState,
};

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
    /// A [`SessionOffer`], with the host's number.
    Session(u8),
    /// The value in effect; a number.
    Parameter(Parameter),
    /// The value that the firmware was compiled with; a number.
    Compiled(Parameter),
    /// A [`StoreState`].
    Store,
    /// A [`ChangeAnswer`].
    Change(Change),
    /// A [`LineRateState`].
    LineRate,
    /// Go to this rate: a [`LineRateAnswer`].
    SetLineRate(LineRate),
    /// Of the sensors on the I2C connector.
    Sensor(SensorEntry),
    /// [`Electronics`].
    Electronics,
    /// Of the program: see [`UpdateEntry`].
    Program(UpdateEntry),
    /// An [`UpdateAnswer`].
    Update(Update),
}

impl PageEntry {
    const LINE_RATE_PAGE: u8 = 9;
    const ELECTRONICS_PAGE: u8 = 31;

    /// Page and entry in it, as they stand in a request.
    pub const fn numbers(self) -> (u8, u8) {
        let [page, entry, ..] = self.words();
        (page, entry)
    }

    /// The words of a request for it.
    pub(crate) const fn words(self) -> [u8; 4] {
        let (page, entry) = match self {
            Self::State => (0, 0),
            Self::Drives => (0, 1),
            Self::Counter(counter) => (1, counter as u8),
            Self::About => (2, 0),
            Self::PostMortemWord(word) => (3, word),
            Self::Session(host) => (4, host),
            Self::Parameter(parameter) => (5, parameter as u8),
            Self::Compiled(parameter) => (6, parameter as u8),
            Self::Store => (7, 0),
            Self::Change(change) => return change.words(),
            Self::LineRate => (Self::LINE_RATE_PAGE, 0),
            Self::SetLineRate(rate) => (Self::LINE_RATE_PAGE, rate as u8),
            Self::Sensor(entry) => (SensorEntry::PAGE, entry as u8),
            Self::Electronics => (Self::ELECTRONICS_PAGE, 0),
            Self::Program(entry) => (UpdateEntry::PAGE, entry as u8),
            Self::Update(update) => return update.words(),
        };
        [page, entry, 0, 0]
    }

    /// The entry with these numbers, if there is one. A value that is to be set has its last two
    /// digits 0.
    pub fn of_numbers(page: u8, entry: u8) -> Option<Self> {
        Self::of_words([page, entry, 0, 0])
    }

    /// Whether a request for an entry of this page has digits of a value in its last two words.
    pub(crate) const fn carries_value(page: u8) -> bool {
        page >= Change::FIRST_SET_PAGE && page < Change::FIRST_SET_PAGE + Change::SET_PAGES
            || Update::carries_value(page)
    }

    #[inline]
    pub(crate) fn of_words(words: [u8; 4]) -> Option<Self> {
        let [page, entry, ..] = words;
        // First what takes longest: a board has 20 us for its answer.
        if page >= Update::PAGE {
            return Update::of_words(words).map(Self::Update);
        }
        if page == Self::LINE_RATE_PAGE {
            return match entry {
                0 => Some(Self::LineRate),
                number => LineRate::of_number(number).map(Self::SetLineRate),
            };
        }
        if page == SensorEntry::PAGE {
            return SensorEntry::of_number(entry).map(Self::Sensor);
        }
        if page == Self::ELECTRONICS_PAGE {
            return if entry == 0 { Some(Self::Electronics) } else { None };
        }
        if page == UpdateEntry::PAGE {
            return UpdateEntry::of_number(entry).map(Self::Program);
        }
        if page >= Change::PAGE {
            return Change::of_words(words).map(Self::Change);
        }
        match (page, entry) {
            (0, 0) => Some(Self::State),
            (0, 1) => Some(Self::Drives),
            (1, number) => Counter::of_number(number).map(Self::Counter),
            (2, 0) => Some(Self::About),
            (3, word) if usize::from(word) < PostMortem::WORDS => Some(Self::PostMortemWord(word)),
            (4, host) if host < SessionOffer::HOST_NUMBERS => Some(Self::Session(host)),
            (5, number) => Parameter::of_number(number).map(Self::Parameter),
            (6, number) => Parameter::of_number(number).map(Self::Compiled),
            (7, 0) => Some(Self::Store),
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
        let parameters = 2 * Parameter::COUNT + 1 + 3 + 10 * Parameter::COUNT;
        let line_rate = 1 + LineRate::ALL.len();
        let sensors = SensorEntry::ALL.len();
        // Of the numbers with both digits 0 as many are three bytes.
        let update = 3 + 3 + (1 << 24) / (102 * 102) + 1;
        let entries = 2 + Counter::ALL.len() + 1 + PostMortem::WORDS + 102 + parameters + line_rate + 1;
        assert_eq!(known.len(), entries + sensors + update);
        for (numbers, entry) in known {
            assert_eq!(entry.numbers(), numbers);
            assert!(numbers.0 < 102 && numbers.1 < 102, "a request stays below 0 kPa");
        }
    }
}
