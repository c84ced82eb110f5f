use super::Entry;
use crate::Counts;

/// What a host does to bring a board a new program: page 39, and 40 to 55 with three bytes each. A
/// board obeys it in a session only.
///
/// The board keeps what comes in RAM: [`Begin`](Self::Begin), then [`Bytes`](Self::Bytes) of the
/// program and of its CRC-32 in order ([`program`](crate::program)), then [`Commit`](Self::Commit).
/// Only then, and only if all of it is right and no chamber has pressure, it writes to flash, into
/// the place of the two that it does not run from, and restarts with the new program, once. That
/// one stays only if a host finds it in a session within [`TRIAL_S`](Self::TRIAL_S) and says
/// [`Confirm`](Self::Confirm); after any reset before that the board is back with the old one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Update {
    /// Forgets what has come so far.
    Begin,
    /// The board checks what has come, writes it and restarts with it.
    Commit,
    /// The program that is being tried stays from now on. The board restarts.
    Confirm,
    /// The next three bytes; behind the end, zeros.
    Bytes([u8; 3]),
}

impl Update {
    /// A new program goes on trial for so long, s.
    pub const TRIAL_S: u64 = 10;
    pub(super) const PAGE: u8 = 39;
    const FIRST_BYTES_PAGE: u8 = 40;
    const BYTES_PAGES: u8 = 16;

    pub(super) const fn carries_value(page: u8) -> bool {
        page >= Self::FIRST_BYTES_PAGE && page < Self::FIRST_BYTES_PAGE + Self::BYTES_PAGES
    }

    /// The words of its request: page, entry and two digits, three digits of a number of 24 bits
    /// and the page a fourth.
    pub(super) const fn words(self) -> [u8; 4] {
        match self {
            Self::Begin => [Self::PAGE, 0, 0, 0],
            Self::Commit => [Self::PAGE, 1, 0, 0],
            Self::Confirm => [Self::PAGE, 2, 0, 0],
            Self::Bytes([low, middle, high]) => {
                let number = u32::from_le_bytes([low, middle, high, 0]);
                let (upper, low) = (number / DIGIT, number % DIGIT);
                let (upper, middle) = (upper / DIGIT, upper % DIGIT);
                let (top, high) = (upper / DIGIT, upper % DIGIT);
                [Self::FIRST_BYTES_PAGE + top as u8, high as u8, middle as u8, low as u8]
            }
        }
    }

    #[inline]
    pub(super) fn of_words(words: [u8; 4]) -> Option<Self> {
        let [page, high, middle, low] = words;
        if Self::carries_value(page) {
            // Spelt out: a board has 20 us for its answer.
            let upper = u32::from(page - Self::FIRST_BYTES_PAGE) * DIGIT + u32::from(high);
            let number = (upper * DIGIT + u32::from(middle)) * DIGIT + u32::from(low);
            let [low, middle, high, over] = number.to_le_bytes();
            if over != 0 || u32::from(words[1]) >= DIGIT {
                return None;
            }
            return Some(Self::Bytes([low, middle, high]));
        }
        match (page, high) {
            (Self::PAGE, 0) => Some(Self::Begin),
            (Self::PAGE, 1) => Some(Self::Commit),
            (Self::PAGE, 2) => Some(Self::Confirm),
            _ => None,
        }
    }
}

/// A page request's words are 0 to 101.
const DIGIT: u32 = Counts::ATMOSPHERE.get() as u32;

/// A board's answer to an [`Update`]. Words: what it did, and how many [`Update::Bytes`] it has
/// now, 10 bits each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct UpdateAnswer {
    /// What it did.
    pub reply: UpdateReply,
    /// How many [`Update::Bytes`] have come since [`Update::Begin`], modulo 2^20.
    pub received: u32,
}

/// What a board did about an [`Update`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum UpdateReply {
    /// Taken. What becomes of a commit or a confirmation tells [`UpdateState`].
    Taken = 0,
    /// Refused: the request was not part of a session.
    NeedsSession = 1,
    /// Refused: nothing has been begun, or there is nothing to confirm.
    NotBegun = 2,
    /// Refused: a commit is being worked on.
    Busy = 3,
    /// Refused: more than a program may have.
    TooLong = 4,
    /// Refused: this board cannot be updated so.
    Unsupported = 5,
}

impl UpdateAnswer {
    /// As it stands in a page answer.
    #[inline]
    pub fn to_entry(self) -> Entry {
        let part = |shift: u32| (self.received >> shift & 1_023) as u16;
        [self.reply as u16, part(10), part(0), 0].map(Counts::saturating)
    }

    /// From a page answer; `None` if it is none.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        use UpdateReply::{Busy, NeedsSession, NotBegun, Taken, TooLong, Unsupported};
        let [reply, high, low, 0] = entry.map(Counts::get) else { return None };
        let reply = [Taken, NeedsSession, NotBegun, Busy, TooLong, Unsupported]
            .into_iter()
            .find(|known| *known as u16 == reply)?;
        Some(Self { reply, received: u32::from(high) << 10 | u32::from(low) })
    }
}

/// Which program a board runs, and what became of the last update: page 38, entry 0.
///
/// Words: outcome, running, last trial, longest program in KiB.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct UpdateState {
    /// What has become of the last commit since the board's start.
    pub outcome: UpdateOutcome,
    /// Which program it runs.
    pub running: Running,
    /// How the last trial since power-on ended, if not by a confirmation.
    pub last_trial: LastTrial,
    /// The longest program that it takes, KiB; 0 if none.
    pub longest_kib: u16,
}

/// What has become of an update's commit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum UpdateOutcome {
    /// There has been none since the board's start.
    None = 0,
    /// It is being worked on; the board restarts.
    Pending = 1,
    /// Refused: a chamber has pressure, or a set point above 0 kPa.
    NotVented = 2,
    /// Refused: the CRC does not fit, or the end is missing.
    Damaged = 3,
    /// Refused: not a program of a PneuDrive board.
    NotAProgram = 4,
    /// Refused: a program for another chip.
    OtherChip = 5,
}

/// The program that a board runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Running {
    /// This board cannot be updated over the bus.
    Unsupported = 0,
    /// The one that was flashed with its boot stage, by a probe or as UF2.
    Flashed = 1,
    /// An update that was confirmed, from the first place.
    First = 2,
    /// An update that was confirmed, from the second place.
    Second = 3,
    /// An update on trial, in the first place.
    TrialFirst = 4,
    /// An update on trial, in the second place.
    TrialSecond = 5,
}

impl Running {
    const ALL: [Self; 6] =
        [Self::Unsupported, Self::Flashed, Self::First, Self::Second, Self::TrialFirst, Self::TrialSecond];

    /// Whether it goes again with the next reset, unless it is confirmed.
    pub const fn is_trial(self) -> bool {
        matches!(self, Self::TrialFirst | Self::TrialSecond)
    }
}

/// How a trial ended that was not confirmed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum LastTrial {
    /// There was none since power-on, or the last one was confirmed.
    None = 0,
    /// Flash does not hold what was to be tried; it was not started.
    Damaged = 1,
    /// A reset came before it was confirmed.
    NotConfirmed = 2,
}

impl UpdateState {
    /// Of a board that cannot be updated over the bus.
    pub const UNSUPPORTED: Self = Self {
        outcome: UpdateOutcome::None,
        running: Running::Unsupported,
        last_trial: LastTrial::None,
        longest_kib: 0,
    };

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        [self.outcome as u16, self.running as u16, self.last_trial as u16, self.longest_kib]
            .map(Counts::saturating)
    }

    /// From a page answer; `None` if a word stands for nothing.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        use UpdateOutcome::{Damaged, None, NotAProgram, NotVented, OtherChip, Pending};
        let [outcome, running, trial, longest_kib] = entry.map(Counts::get);
        Some(Self {
            outcome: [None, Pending, NotVented, Damaged, NotAProgram, OtherChip]
                .into_iter()
                .find(|known| *known as u16 == outcome)?,
            running: Running::ALL.into_iter().find(|known| *known as u16 == running)?,
            last_trial: [LastTrial::None, LastTrial::Damaged, LastTrial::NotConfirmed]
                .into_iter()
                .find(|known| *known as u16 == trial)?,
            longest_kib,
        })
    }
}

/// Entries of page 38.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum UpdateEntry {
    /// An [`UpdateState`].
    State = 0,
    /// How many [`Update::Bytes`] have come; a number.
    Received = 1,
    /// The CRC-32 of the running program, 0 if it is as flashed; a number.
    RunningCrc = 2,
}

impl UpdateEntry {
    pub(super) const PAGE: u8 = 38;

    #[inline]
    pub(super) const fn of_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::State),
            1 => Some(Self::Received),
            2 => Some(Self::RunningCrc),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_bytes_come_back_in_words_below_0_kpa() {
        let numbers = (0..1 << 24).step_by(997).chain([0xff_ffff]);
        for number in numbers {
            let [low, middle, high, _] = u32::to_le_bytes(number);
            let update = Update::Bytes([low, middle, high]);
            let words = update.words();
            assert!(words.iter().all(|word| u32::from(*word) < DIGIT), "{words:?}");
            assert_eq!(Update::of_words(words), Some(update));
        }
        assert_eq!(Update::of_words([55, 101, 101, 101]), None, "beyond three bytes");
    }

    #[test]
    fn states_and_answers_come_back() {
        for outcome in 0..6 {
            for running in 0..6 {
                for trial in 0..3 {
                    let entry = [outcome, running, trial, 127].map(Counts::saturating);
                    assert_eq!(UpdateState::from_entry(entry).map(UpdateState::to_entry), Some(entry));
                }
            }
        }
        for reply in 0..6 {
            let entry = [reply, 1_023, 7, 0].map(Counts::saturating);
            let answer = UpdateAnswer::from_entry(entry);
            assert_eq!(answer.map(UpdateAnswer::to_entry), Some(entry));
            assert_eq!(answer.map(|answer| answer.received), Some(1_023 << 10 | 7));
        }
        for words in [[6, 0, 0, 0], [0, 6, 0, 0], [0, 0, 3, 0], [1_023; 4]] {
            assert_eq!(UpdateState::from_entry(words.map(Counts::saturating)), None);
        }
        assert_eq!(UpdateAnswer::from_entry([6, 0, 0, 0].map(Counts::saturating)), None);
    }
}
