//! Finding packets in a stream of bytes: what board and host have in common.
//!
//! Two things align a frame: an idle gap before it, and a whole valid frame right before it. Only when neither holds
//! (a byte was lost or added) is the next frame searched for byte by byte, and then every one of its ten bytes must
//! fit. That is why an address that follows a data word ending in 0xFF is not mistaken for 0xFFFF: at the only
//! position where it could be, either the stream is aligned to another byte, or the next address word stands where
//! a data word with bit 15 clear is required.

use crate::spare_bits::Kind;
use crate::{Address, CheckedPacket, Direction, PACKET_LEN, Packet, PageAnswer, PageRequest};

/// A line that was silent for this many characters starts a new frame.
///
/// Longer than any pause inside a request or answer that is written at once (a UART sends its FIFO back to back),
/// shorter than the silence after a request that nobody answers.
pub const IDLE_GAP_CHARACTERS: u16 = 3;

/// What a decoder has seen, since it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameStatistics {
    /// Valid packets of either format, whoever's they were.
    pub packets: u32,
    /// Bytes that belonged to no valid packet.
    pub discarded_bytes: u32,
}

/// Ten bytes that are a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// In the original's format: nothing tells a request from an answer.
    Unchecked(Packet),
    /// With a CRC that fits this direction.
    Checked(CheckedPacket, Direction),
    /// A host asks for an entry of a page.
    PageRequest(PageRequest),
    /// A board answers with an entry of a page.
    PageAnswer(PageAnswer),
}

impl Frame {
    /// Address and values, as they stand in the packet: in a page request and its answer they are no pressures.
    pub fn packet(&self) -> Packet {
        match self {
            Self::Unchecked(packet) => *packet,
            Self::Checked(checked, _) => checked.packet,
            Self::PageRequest(request) => request.packet(),
            Self::PageAnswer(answer) => Packet { address: answer.address, values: answer.words },
        }
    }

    /// Reads ten bytes as a packet of any kind. The spare bits of an unchecked packet are 0, and then no CRC is looked for.
    fn decode(bytes: &[u8; PACKET_LEN]) -> Option<Self> {
        if let Ok(packet) = Packet::decode(bytes) {
            return Some(Self::Unchecked(packet));
        }
        let (checked, kind) = CheckedPacket::decode_any(bytes).ok()?;
        Some(match kind {
            Kind::Request => Self::Checked(checked, Direction::Request),
            Kind::Answer => Self::Checked(checked, Direction::Answer),
            Kind::PageRequest => Self::PageRequest(PageRequest::of_packet(&checked)?),
            Kind::PageAnswer => Self::PageAnswer(PageAnswer::of_packet(&checked)),
        })
    }
}

/// Up to one packet's worth of bytes that may still become a packet: the part that all decoders share, and an ear for
/// whatever is said on the bus.
#[derive(Debug, Clone, Default)]
pub struct FrameFinder {
    bytes: [u8; PACKET_LEN],
    len: usize,
    statistics: FrameStatistics,
}

impl FrameFinder {
    /// Nothing heard yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes one byte; gives the packet that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        self.bytes[self.len] = byte;
        self.len += 1;
        // The bytes before it could become a packet, so only the new one needs a look.
        let mut fits = fits_at(self.len - 1, byte);
        loop {
            while !fits {
                self.drop_first();
                fits = self.could_become_a_packet();
            }
            if self.len < PACKET_LEN {
                return None;
            }
            if let Some(frame) = Frame::decode(&self.bytes) {
                self.len = 0;
                self.statistics.packets = self.statistics.packets.saturating_add(1);
                return Some(frame);
            }
            fits = false;
        }
    }

    /// The line was silent, or a byte arrived damaged: what has been collected is not the start of a packet.
    pub fn restart(&mut self) {
        self.count_discarded(self.len);
        self.len = 0;
    }

    /// Packets and discarded bytes so far.
    pub fn statistics(&self) -> FrameStatistics {
        self.statistics
    }

    /// Bytes that wait for the rest of their packet, 0 to 9.
    pub fn pending(&self) -> usize {
        self.len
    }

    fn could_become_a_packet(&self) -> bool {
        self.bytes[..self.len].iter().enumerate().all(|(position, &byte)| fits_at(position, byte))
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

/// Whether a packet of either format can have this byte at this position.
fn fits_at(position: usize, byte: u8) -> bool {
    match position {
        0 => byte == Address::HIGH_BYTE,
        high if high % 2 == 0 => byte <= CheckedPacket::DATA_HIGH_BYTE_MAX,
        _ => true,
    }
}
