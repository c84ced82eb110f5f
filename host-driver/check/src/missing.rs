//! Why something could not be measured.

use std::fmt;

/// Why a quantity has no value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Missing {
    /// Rows are missing or late where the value depends on when they were: the machine was busy, or
    /// answers were lost. That says nothing about the board, and another try may do.
    Busy,
    /// The board or its limits did not allow it, in words for people.
    Because(String),
}

impl Missing {
    /// Too few readings that nobody prevented.
    pub(crate) fn few() -> Self {
        Self::Because("too few readings: the pressure did not go there, or the rate is too low".to_owned())
    }
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy => f.write_str("rows are late or missing: the machine was busy, or answers were lost"),
            Self::Because(why) => f.write_str(why),
        }
    }
}
