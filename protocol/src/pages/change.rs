use super::{Entry, Parameter};
use crate::Counts;

/// What a host does to a board's parameters: pages 8 and 10 to 19. A board obeys it in a session
/// only.
///
/// A change is collected first and takes effect as a whole: [`Begin`](Self::Begin), any number of
/// [`Set`](Self::Set), then [`Commit`](Self::Commit). What was not committed is forgotten when the
/// host leaves or falls silent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Change {
    /// Starts from the values in effect.
    Begin,
    /// Starts from the values that the firmware was compiled with.
    BeginFromDefaults,
    /// The board checks what was collected, keeps it in flash and restarts, if its chambers are
    /// vented. [`StoreState`] says what became of it.
    Commit,
    /// This parameter shall have this value, whose range is checked with the commit; at most
    /// [`VALUE_MAX`](Self::VALUE_MAX).
    Set(Parameter, u32),
}

impl Change {
    /// The largest value that a request can carry.
    pub const VALUE_MAX: u32 = Self::SET_PAGES as u32 * DIGIT * DIGIT - 1;
    pub(super) const PAGE: u8 = 8;
    pub(super) const FIRST_SET_PAGE: u8 = 10;
    pub(super) const SET_PAGES: u8 = 10;

    /// The words of its request: page, entry, and the two digits of a value below those that the
    /// page carries.
    pub(super) const fn words(self) -> [u8; 4] {
        match self {
            Self::Begin => [Self::PAGE, 0, 0, 0],
            Self::BeginFromDefaults => [Self::PAGE, 1, 0, 0],
            Self::Commit => [Self::PAGE, 2, 0, 0],
            Self::Set(parameter, value) => {
                let value = if value > Self::VALUE_MAX { Self::VALUE_MAX } else { value };
                let high = Self::FIRST_SET_PAGE + (value / (DIGIT * DIGIT)) as u8;
                [high, parameter as u8, (value / DIGIT % DIGIT) as u8, (value % DIGIT) as u8]
            }
        }
    }

    /// The change with these words.
    #[inline]
    pub(super) fn of_words([page, entry, high, low]: [u8; 4]) -> Option<Self> {
        // First what takes longest: a board has 20 us for its answer.
        if page >= Self::FIRST_SET_PAGE {
            let top = page.checked_sub(Self::FIRST_SET_PAGE).filter(|top| *top < Self::SET_PAGES)?;
            let value = (u32::from(top) * DIGIT + u32::from(high)) * DIGIT + u32::from(low);
            return Some(Self::Set(Parameter::of_number(entry)?, value));
        }
        match (page, entry) {
            (Self::PAGE, 0) => Some(Self::Begin),
            (Self::PAGE, 1) => Some(Self::BeginFromDefaults),
            (Self::PAGE, 2) => Some(Self::Commit),
            _ => None,
        }
    }
}

/// A page request's words are 0 to 101.
const DIGIT: u32 = Counts::ATMOSPHERE.get() as u32;

/// A board's answer to a [`Change`]: word 0, the others are 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ChangeAnswer {
    /// Taken. A commit is being worked on: [`StoreState`] tells how it ended.
    Taken = 0,
    /// Refused: the request was not part of a session.
    NeedsSession = 1,
    /// Refused: nothing has been begun.
    NotBegun = 2,
    /// Refused: a commit is being worked on.
    Busy = 3,
}

impl ChangeAnswer {
    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        [Counts::saturating(self as u16), Counts::MIN, Counts::MIN, Counts::MIN]
    }

    /// From a page answer; `None` if it is none.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [word, Counts::MIN, Counts::MIN, Counts::MIN] = entry else { return None };
        [Self::Taken, Self::NeedsSession, Self::NotBegun, Self::Busy]
            .into_iter()
            .find(|answer| *answer as u16 == word.get())
    }
}

/// What has become of the last commit, and where the values in effect come from: page 7, entry 0.
///
/// Words: outcome, parameter of a refusal, source, number of the record modulo 1024.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StoreState {
    /// What has become of the last commit since the board's start.
    pub outcome: CommitOutcome,
    /// Whether values from flash are in effect.
    pub source: ParameterSource,
    /// Number of the record in flash that they come from, modulo 1024; it grows with every one that
    /// is written. 0 without one.
    pub record: u16,
}

/// What has become of a commit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CommitOutcome {
    /// There has been none since the board's start.
    None,
    /// It is being worked on. The board restarts with the new values; if it comes back with the old
    /// record, flash could not be written.
    Pending,
    /// Refused: a chamber has pressure, or a set point above 0 kPa.
    NotVented,
    /// Refused: this value is outside its range, or does not go together with the others.
    Refused(Parameter),
    /// Nothing was to be changed.
    Unchanged,
}

/// Where the values in effect come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParameterSource {
    /// All as compiled.
    Compiled,
    /// Some from flash.
    Stored,
}

impl StoreState {
    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        let (outcome, parameter) = match self.outcome {
            CommitOutcome::None => (0, 0),
            CommitOutcome::Pending => (1, 0),
            CommitOutcome::NotVented => (2, 0),
            CommitOutcome::Refused(parameter) => (3, parameter as u16),
            CommitOutcome::Unchanged => (4, 0),
        };
        let source = u16::from(self.source == ParameterSource::Stored);
        [outcome, parameter, source, self.record % 1024].map(Counts::saturating)
    }

    /// From a page answer; `None` if a word stands for nothing.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [outcome, parameter, source, record] = entry.map(Counts::get);
        let outcome = match outcome {
            0 => CommitOutcome::None,
            1 => CommitOutcome::Pending,
            2 => CommitOutcome::NotVented,
            3 => CommitOutcome::Refused(Parameter::of_number(u8::try_from(parameter).ok()?)?),
            4 => CommitOutcome::Unchanged,
            _ => return None,
        };
        let source = match source {
            0 => ParameterSource::Compiled,
            1 => ParameterSource::Stored,
            _ => return None,
        };
        Some(Self { outcome, source, record })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_comes_back_in_words_below_0_kpa() {
        for parameter in Parameter::ALL {
            for value in (0..=Change::VALUE_MAX).step_by(101).chain([Change::VALUE_MAX]) {
                let words = Change::Set(parameter, value).words();
                assert!(words.iter().all(|word| u32::from(*word) < DIGIT), "{words:?}");
                assert_eq!(Change::of_words(words), Some(Change::Set(parameter, value)));
            }
        }
    }

    #[test]
    fn states_and_answers_come_back() {
        use CommitOutcome::{None, NotVented, Pending, Refused, Unchanged};
        for outcome in [None, Pending, NotVented, Refused(Parameter::SensorMargin), Unchanged] {
            for source in [ParameterSource::Compiled, ParameterSource::Stored] {
                let state = StoreState { outcome, source, record: 1_023 };
                assert_eq!(StoreState::from_entry(state.to_entry()), Some(state));
            }
        }
        for number in 0..4 {
            let entry = [number, 0, 0, 0].map(Counts::saturating);
            assert_eq!(ChangeAnswer::from_entry(entry).map(ChangeAnswer::to_entry), Some(entry));
        }
        assert_eq!(ChangeAnswer::from_entry([4, 0, 0, 0].map(Counts::saturating)), Option::None);
    }
}
