use super::Entry;
use crate::{Baud, Counts};

/// A line rate that a host can ask a board for: page 9. A board obeys it in a session only.
///
/// A board starts with the rate that it was compiled for and goes back to it by itself: when it
/// hears no request at another rate for 100 ms, when too much comes damaged, and when its host
/// leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum LineRate {
    /// The rate that the board was compiled for: 1 Mbaud unless its owner changed it.
    Compiled = 1,
    /// 2 Mbaud.
    TwoMbaud = 2,
    /// 3 Mbaud.
    ThreeMbaud = 3,
}

impl LineRate {
    /// All, the slowest first.
    pub const ALL: [Self; 3] = [Self::Compiled, Self::TwoMbaud, Self::ThreeMbaud];

    /// The rate itself, where the board was compiled for `compiled`.
    pub const fn baud(self, compiled: Baud) -> Baud {
        match self {
            Self::Compiled => compiled,
            Self::TwoMbaud => Baud::TWO_MBAUD,
            Self::ThreeMbaud => Baud::THREE_MBAUD,
        }
    }

    /// The rate with this number, which is its entry in page 9.
    #[inline]
    pub const fn of_number(number: u8) -> Option<Self> {
        match number {
            1 => Some(Self::Compiled),
            2 => Some(Self::TwoMbaud),
            3 => Some(Self::ThreeMbaud),
            _ => None,
        }
    }
}

/// The line rate of a board: page 9, entry 0. Words: rate in effect, fastest one that it allows,
/// times that it went back by itself, and why it did last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LineRateState {
    /// The rate in effect.
    pub now: LineRate,
    /// The fastest that the board allows: its parameter `max_baud`.
    pub fastest: LineRate,
    /// How often it has gone back by itself since its start, at most 1023.
    pub returns: u16,
    /// Why it did so last; `None` if it never has.
    pub last_return: Option<RateReturn>,
}

/// Why a board went back to the rate that it was compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum RateReturn {
    /// No request came for 100 ms.
    Silence = 1,
    /// Too much came damaged.
    Damage = 2,
}

impl LineRateState {
    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        let why = self.last_return.map_or(0, |why| why as u16);
        [self.now as u16, self.fastest as u16, self.returns, why].map(Counts::saturating)
    }

    /// From a page answer; `None` if a word stands for nothing.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [now, fastest, returns, why] = entry.map(Counts::get);
        let rate = |word: u16| LineRate::of_number(u8::try_from(word).ok()?);
        let last_return = match why {
            0 => None,
            1 => Some(RateReturn::Silence),
            2 => Some(RateReturn::Damage),
            _ => return None,
        };
        Some(Self { now: rate(now)?, fastest: rate(fastest)?, returns, last_return })
    }
}

/// A board's answer to a request for a [`LineRate`]: word 0, the others are 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum LineRateAnswer {
    /// Taken: the rate changes when this answer has left the board.
    Taken = 0,
    /// Refused: the request was not part of a session.
    NeedsSession = 1,
    /// Refused: faster than the board's parameter `max_baud` allows.
    TooFast = 2,
}

impl LineRateAnswer {
    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        [Counts::saturating(self as u16), Counts::MIN, Counts::MIN, Counts::MIN]
    }

    /// From a page answer; `None` if it is none.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [word, Counts::MIN, Counts::MIN, Counts::MIN] = entry else { return None };
        [Self::Taken, Self::NeedsSession, Self::TooFast]
            .into_iter()
            .find(|answer| *answer as u16 == word.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_and_answers_come_back() {
        for now in LineRate::ALL {
            for fastest in LineRate::ALL {
                for last_return in [None, Some(RateReturn::Silence), Some(RateReturn::Damage)] {
                    let state = LineRateState { now, fastest, returns: 1_023, last_return };
                    assert_eq!(LineRateState::from_entry(state.to_entry()), Some(state));
                }
            }
        }
        for word in 0..3 {
            let entry = [word, 0, 0, 0].map(Counts::saturating);
            assert_eq!(LineRateAnswer::from_entry(entry).map(LineRateAnswer::to_entry), Some(entry));
        }
        assert_eq!(LineRateAnswer::from_entry([3, 0, 0, 0].map(Counts::saturating)), None);
        for words in [[0, 1, 0, 0], [1, 4, 0, 0], [1, 1, 0, 3], [1_023; 4]] {
            assert_eq!(LineRateState::from_entry(words.map(Counts::saturating)), None, "{words:?}");
        }
    }

    #[test]
    fn a_number_is_its_rate_in_mbaud() {
        for rate in LineRate::ALL {
            assert_eq!(LineRate::of_number(rate as u8), Some(rate));
            assert_eq!(rate.baud(Baud::ORIGINAL).get(), 1_000_000 * rate as u32);
        }
        let slow = Baud::new(115_200).unwrap();
        assert_eq!(LineRate::Compiled.baud(slow), slow);
        assert_eq!((LineRate::of_number(0), LineRate::of_number(4)), (None, None));
    }
}
