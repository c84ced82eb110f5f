use super::{Entry, number_entry, number_in};
use crate::Counts;

/// A board's answer to a host that asks for a [`Session`](crate::Session): page 4. The entry that
/// is asked for is a number of the host's, which goes into the session's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SessionOffer {
    /// The number of the session. The board's last request number in it is 0, so the host's first
    /// is 1.
    Number(u32),
    /// The board is in a session. It has another one to give when that host leaves, or has been
    /// silent for the command timeout.
    Busy,
}

impl SessionOffer {
    /// How many numbers a host can choose from.
    pub const HOST_NUMBERS: u8 = 102;
    const BUSY: Entry = [Counts::saturating(4), Counts::MIN, Counts::MIN, Counts::MIN];

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        match self {
            Self::Number(number) => number_entry(number),
            Self::Busy => Self::BUSY,
        }
    }

    /// From a page answer; `None` if it is no offer.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        if entry == Self::BUSY { Some(Self::Busy) } else { number_in(entry).map(Self::Number) }
    }
}
