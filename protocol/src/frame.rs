//! Finding packets in a stream of bytes: what board and host have in common.
//!
//! Two things align a frame: an idle gap before it, and a whole valid frame right before it. Only when neither holds
//! (a byte was lost or added) is the next frame searched for byte by byte, and then every one of its ten bytes must
//! fit. That is why an address that follows a data word ending in 0xFF is not mistaken for 0xFFFF: at the only
//! position where it could be, either the stream is aligned to another byte, or the next address word stands where
//! a value of at most 1023 is required.

use crate::{PACKET_LEN, Packet};

/// A line that was silent for this many characters starts a new frame.
///
/// Longer than any pause inside a request or answer that is written at once (a UART sends its FIFO back to back),
/// shorter than the silence after a request that nobody answers.
pub const IDLE_GAP_CHARACTERS: u16 = 3;

/// What a decoder has seen, since it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameStatistics {
    /// Valid packets, whoever's they were.
    pub packets: u32,
    /// Bytes that belonged to no valid packet.
    pub discarded_bytes: u32,
}

/// Up to one packet's worth of bytes that may still become a packet.
#[derive(Debug, Clone, Default)]
pub(crate) struct FrameFinder {
    bytes: [u8; PACKET_LEN],
    len: usize,
    statistics: FrameStatistics,
}

impl FrameFinder {
    /// Largest high byte of a value word (1023 = 0x03FF).
    const VALUE_HIGH_BYTE_MAX: u8 = 0x03;

    /// Takes one byte; gives the packet that it completes.
    pub(crate) fn push(&mut self, byte: u8) -> Option<Packet> {
        self.bytes[self.len] = byte;
        self.len += 1;
        while !self.could_become_a_packet() {
            self.drop_first();
        }
        if self.len < PACKET_LEN {
            return None;
        }
        // All high bytes have been looked at, so this is a packet; `ok` only spares us a panic path.
        let packet = Packet::decode(&self.bytes).ok();
        self.len = 0;
        self.statistics.packets = self.statistics.packets.saturating_add(1);
        packet
    }

    /// The line was silent, or a byte arrived damaged: what has been collected is not the start of a packet.
    pub(crate) fn restart(&mut self) {
        self.count_discarded(self.len);
        self.len = 0;
    }

    pub(crate) fn statistics(&self) -> FrameStatistics {
        self.statistics
    }

    /// Bytes that wait for the rest of their packet.
    pub(crate) fn pending(&self) -> usize {
        self.len
    }

    fn could_become_a_packet(&self) -> bool {
        self.bytes[..self.len].iter().enumerate().all(|(position, &byte)| match position {
            0 => byte == crate::Address::HIGH_BYTE,
            high if high % 2 == 0 => byte <= Self::VALUE_HIGH_BYTE_MAX,
            _ => true,
        })
    }

    fn drop_first(&mut self) {
        self.bytes.copy_within(1..self.len, 0);
        self.len -= 1;
        self.count_discarded(1);
    }

    fn count_discarded(&mut self, count: usize) {
        self.statistics.discarded_bytes = self.statistics.discarded_bytes.saturating_add(count as u32);
    }
}
