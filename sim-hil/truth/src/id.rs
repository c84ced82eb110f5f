//! Names of channels.

use core::fmt;

/// Channels on one board.
pub const CHANNELS_PER_BOARD: usize = 4;

/// One valve, chamber and sensor: channel `channel` (0 to 3) of board `board`.
///
/// Written `b0c2`, as in the measured-data columns `b0_p2_kpa`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ChannelId {
    /// Board number, from 0.
    pub board: u8,
    /// Channel on the board, 0 to 3.
    pub channel: u8,
}

impl ChannelId {
    /// The `index`-th channel of a rig, counting through the boards; `None` beyond 256 boards.
    #[must_use]
    pub fn from_index(index: usize) -> Option<Self> {
        let board = u8::try_from(index / CHANNELS_PER_BOARD).ok()?;
        let channel = u8::try_from(index % CHANNELS_PER_BOARD).ok()?;
        Some(Self { board, channel })
    }

    /// Position in a rig, counting through the boards; the inverse of [`ChannelId::from_index`].
    ///
    /// `None` when `channel` is not 0 to 3.
    #[must_use]
    pub fn index(self) -> Option<usize> {
        let channel = usize::from(self.channel);
        (channel < CHANNELS_PER_BOARD).then_some(usize::from(self.board) * CHANNELS_PER_BOARD + channel)
    }
}

impl fmt::Display for ChannelId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "b{}c{}", self.board, self.channel)
    }
}
