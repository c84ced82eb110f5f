use crate::frame::{FrameFinder, FrameStatistics};
use crate::{Address, CHANNELS, Counts};

/// A board's ear: finds the requests to its own address among everything that is said on the bus.
///
/// Feed it every byte in order; tell it when the line was silent for [`IDLE_GAP_CHARACTERS`](crate::IDLE_GAP_CHARACTERS)
/// and when the receiver flagged a byte as damaged.
#[derive(Debug, Clone)]
pub struct RequestDecoder {
    own: Address,
    finder: FrameFinder,
}

impl RequestDecoder {
    /// For the board with this address.
    pub fn new(own: Address) -> Self {
        Self { own, finder: FrameFinder::default() }
    }

    /// Takes one byte; gives the four commands of the request to this board that it completes.
    pub fn push(&mut self, byte: u8) -> Option<[Counts; CHANNELS]> {
        self.finder.push(byte).filter(|packet| packet.address == self.own).map(|packet| packet.values)
    }

    /// The line was silent: the next byte starts a frame.
    pub fn line_idle(&mut self) {
        self.finder.restart();
    }

    /// The receiver flagged a byte (framing, parity, overrun, break): the frame it belonged to is lost.
    pub fn line_error(&mut self) {
        self.finder.restart();
    }

    /// The address it listens to.
    pub fn address(&self) -> Address {
        self.own
    }

    /// Packets heard (for any board) and bytes discarded.
    pub fn statistics(&self) -> FrameStatistics {
        self.finder.statistics()
    }
}
