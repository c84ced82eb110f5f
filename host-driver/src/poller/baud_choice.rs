//! A line rate as users give it: a number, or whatever is fastest.

use super::LineRatePolicy;
use pneudrive_protocol::Baud;
use std::str::FromStr;
use thiserror::Error;

/// A line rate, or the fastest that all boards agree to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaudChoice {
    /// Begins at 1 Mbaud, and polls at the fastest that adapter and boards can do.
    Auto,
    /// bit/s, for boards that were compiled for it.
    Rate(u32),
}

/// A text that is no such choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("expected `auto`, or a whole number of bit/s such as 1000000")]
pub struct BaudChoiceError;

impl BaudChoice {
    /// Line rate with which it begins, bit/s; not checked.
    pub fn first(self) -> u32 {
        match self {
            Self::Auto => Baud::ORIGINAL.get(),
            Self::Rate(rate) => rate,
        }
    }

    /// The fastest that it may come to, bit/s: what a rate of cycles is checked against.
    pub fn fastest(self) -> u32 {
        match self {
            Self::Auto => Baud::THREE_MBAUD.get(),
            Self::Rate(rate) => rate,
        }
    }

    /// What a poller is to be given for it.
    pub fn policy(self) -> Option<LineRatePolicy> {
        (self == Self::Auto).then(LineRatePolicy::default)
    }
}

impl Default for BaudChoice {
    fn default() -> Self {
        Self::Rate(Baud::ORIGINAL.get())
    }
}

impl FromStr for BaudChoice {
    type Err = BaudChoiceError;

    fn from_str(text: &str) -> Result<Self, BaudChoiceError> {
        match text.parse() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(rate) => Ok(Self::Rate(rate)),
            Err(_) => Err(BaudChoiceError),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_begins_at_1_mbaud_and_may_come_to_3() {
        let auto: BaudChoice = "auto".parse().unwrap();
        assert_eq!((auto.first(), auto.fastest()), (1_000_000, 3_000_000));
        assert_eq!(auto.policy(), Some(LineRatePolicy::default()));
        let fixed: BaudChoice = "2000000".parse().unwrap();
        assert_eq!((fixed.first(), fixed.fastest(), fixed.policy()), (2_000_000, 2_000_000, None));
        assert_eq!(BaudChoice::default().first(), 1_000_000);
        for text in ["Auto", "", "1e6", "-1", "4294967296"] {
            assert_eq!(text.parse::<BaudChoice>(), Err(BaudChoiceError), "{text}");
        }
    }
}
