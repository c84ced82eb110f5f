//! Finding packets in a stream of bytes: what board and host have in common.
//!
//! Two things align a frame: an idle gap before it, and a whole valid frame right before it. Only
//! when neither holds (a byte was lost or added) is the next frame searched for byte by byte, and
//! then every one of its ten bytes must fit. That is why an address that follows a data word ending
//! in 0xFF is not mistaken for 0xFFFF: at the only position where it could be, either the stream is
//! aligned to another byte, or the next address word stands where a data word with bit 15 clear is
//! required.

use crate::spare_bits::Kind;
use crate::{Address, CheckedPacket, Direction, PACKET_LEN, Packet, PageAnswer, PageRequest, Seal, Sequence};

/// What a decoder has seen, since it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameStatistics {
    /// Valid packets of either format, whoever's they were.
    pub packets: u32,
    /// Bytes that belonged to no packet.
    pub discarded_bytes: u32,
    /// Ten bytes of a packet's form whose CRC fits nothing that the listener knows: of others'
    /// sessions, or damaged.
    pub unverified: u32,
}

/// Ten bytes that are a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// In the original's format: nothing tells a request from an answer.
    Unchecked(Packet),
    /// With a CRC that fits this direction.
    Checked(CheckedPacket, Direction),
    /// The same in a session that the listener knows.
    Sealed(CheckedPacket, Direction, Seal),
    /// A host asks for an entry of a page.
    PageRequest(PageRequest),
    /// A board answers with an entry of a page.
    PageAnswer(PageAnswer),
}

impl Frame {
    /// Address and values, as they stand in the packet: in a page request and its answer they are
    /// no pressures.
    pub fn packet(&self) -> Packet {
        match self {
            Self::Unchecked(packet) => *packet,
            Self::Checked(checked, _) | Self::Sealed(checked, _, _) => checked.packet,
            Self::PageRequest(request) => request.packet(),
            Self::PageAnswer(answer) => Packet { address: answer.address, values: answer.words },
        }
    }

    fn is_checked_of(&self, own: Address) -> bool {
        self.packet().address == own && !matches!(self, Self::Unchecked(_))
    }

    /// Reads ten bytes as a packet of any kind. The spare bits of an unchecked packet are 0.
    #[inline]
    fn decode(
        bytes: &[u8; PACKET_LEN],
        seal: impl FnOnce(Address, Sequence) -> Option<Seal>,
    ) -> Result<Self, Option<Address>> {
        let address = Address::from_word(u16::from_be_bytes([bytes[0], bytes[1]]));
        if let Ok(packet) = Packet::decode(bytes) {
            // Without a session, spare bits of 0 say that there is no CRC. In one, number and CRC
            // may be 0.
            let Some(seal) = seal(packet.address, Sequence::default()) else {
                return Ok(Self::Unchecked(packet));
            };
            return match CheckedPacket::decode_any(bytes, |_, _| Some(seal)) {
                Ok((checked, kind, Some(seal))) => Self::with_crc(checked, kind, Some(seal)),
                _ => Ok(Self::Unchecked(packet)),
            };
        }
        let (checked, kind, seal) = CheckedPacket::decode_any(bytes, seal).map_err(|_| address)?;
        Self::with_crc(checked, kind, seal)
    }

    #[inline]
    fn with_crc(checked: CheckedPacket, kind: Kind, seal: Option<Seal>) -> Result<Self, Option<Address>> {
        let checked_packet = |direction| match seal {
            Some(seal) => Self::Sealed(checked, direction, seal),
            None => Self::Checked(checked, direction),
        };
        Ok(match kind {
            Kind::Request => checked_packet(Direction::Request),
            Kind::Answer => checked_packet(Direction::Answer),
            Kind::PageRequest => Self::PageRequest(PageRequest::of_packet(&checked, seal).ok_or(None)?),
            Kind::PageAnswer => Self::PageAnswer(PageAnswer::of_packet(&checked, seal)),
        })
    }
}

/// Up to one packet's worth of bytes that may still become a packet: the part that all decoders
/// share, and an ear for whatever is said on the bus.
#[derive(Debug, Clone, Default)]
pub struct FrameFinder {
    bytes: [u8; PACKET_LEN],
    len: usize,
    statistics: FrameStatistics,
    /// How many of the ten bytes that were last found to be unverified are still to be dropped.
    unverified_left: usize,
    /// The address of the last ten bytes that were unverified.
    unverified: Option<Address>,
    /// An idle gap or a whole packet was right before the first of the bytes.
    aligned: bool,
}

impl FrameFinder {
    /// Nothing heard yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes one byte; gives the packet that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        self.push_with(byte, None, |_, _| None)
    }

    /// The same for a listener that knows sessions: `seal` gives the seal that a packet with this
    /// address and sequence has.
    ///
    /// Such a listener cannot verify the packets of others' sessions, so that nothing aligns the
    /// next frame. Of board 0's all bytes but the first, and the first of the next frame, can look
    /// like a packet to nobody's board. Who searches for a frame with a CRC and the address `only`
    /// takes none but these; such an address begins nowhere inside frames that are whole (see
    /// `fits_at`).
    pub fn push_with(
        &mut self,
        byte: u8,
        only: Option<Address>,
        seal: impl Fn(Address, Sequence) -> Option<Seal>,
    ) -> Option<Frame> {
        self.bytes[self.len] = byte;
        self.len += 1;
        // The bytes before it could become a packet, so only the new one needs a look.
        let mut fits = fits_at(self.len - 1, byte);
        loop {
            if !fits {
                self.aligned = false;
                self.drop_to_the_next_start();
            }
            if self.len < PACKET_LEN {
                return None;
            }
            match Frame::decode(&self.bytes, &seal) {
                Ok(frame) if !self.aligned && only.is_some_and(|own| !frame.is_checked_of(own)) => {
                    fits = false
                }
                Ok(frame) => {
                    self.aligned = true;
                    self.decide_unverified();
                    self.len = 0;
                    self.statistics.packets = self.statistics.packets.saturating_add(1);
                    return Some(frame);
                }
                Err(address) => {
                    self.decide_unverified();
                    self.unverified_left = PACKET_LEN;
                    self.unverified = address;
                    fits = false;
                }
            }
        }
    }

    /// Takes a byte in the middle of what may become a packet, which most are, in the few cycles
    /// that a board has at 3 Mbaud. False, and the byte is not taken, if there is more to do about
    /// it.
    #[inline]
    pub(crate) fn continues_with(&mut self, byte: u8) -> bool {
        let continues = self.len + 1 < PACKET_LEN && fits_at(self.len, byte);
        if continues {
            self.bytes[self.len] = byte;
            self.len += 1;
        }
        continues
    }

    /// The address of ten bytes whose CRC fitted nothing, if there have been any since this was
    /// last asked.
    pub fn take_unverified(&mut self) -> Option<Address> {
        self.unverified.take()
    }

    /// The line was silent, or a byte arrived damaged: what has been collected is not the start of
    /// a packet.
    pub fn restart(&mut self) {
        for _ in 0..self.len {
            self.count_dropped();
        }
        self.decide_unverified();
        self.len = 0;
        self.aligned = true;
    }

    /// Packets and discarded bytes so far.
    pub fn statistics(&self) -> FrameStatistics {
        self.statistics
    }

    /// Bytes heard that belong to no packet whose CRC fits, a started one included.
    pub(crate) fn unpacked_bytes(&self) -> usize {
        let FrameStatistics { discarded_bytes, unverified, .. } = self.statistics;
        let dropped = PACKET_LEN.saturating_sub(self.unverified_left) % PACKET_LEN;
        discarded_bytes as usize + PACKET_LEN * unverified as usize + dropped + self.len
    }

    /// Bytes that wait for the rest of their packet, 0 to 9.
    pub fn pending(&self) -> usize {
        self.len
    }

    /// Drops the first byte, and those behind it with which no packet can begin. In one go: a
    /// packet of another board's session is dropped whole, and at 3 Mbaud the next one follows in 3
    /// us.
    fn drop_to_the_next_start(&mut self) {
        let begins = |start: &usize| {
            self.bytes[*start..self.len].iter().enumerate().all(|(position, &byte)| fits_at(position, byte))
        };
        let next = (1..self.len).find(begins).unwrap_or(self.len);
        (0..next).for_each(|_| self.count_dropped());
        self.bytes.copy_within(next..self.len, 0);
        self.len -= next;
    }

    fn count_dropped(&mut self) {
        match self.unverified_left {
            0 => self.count_discarded(1),
            1 => {
                self.unverified_left = 0;
                self.statistics.unverified = self.statistics.unverified.saturating_add(1);
            }
            _ => self.unverified_left -= 1,
        }
    }

    /// A packet has begun before the unverified one's end: then that was none, and its bytes count
    /// as discarded.
    fn decide_unverified(&mut self) {
        if self.unverified_left > 0 {
            self.count_discarded(PACKET_LEN - self.unverified_left);
            self.unverified_left = 0;
        }
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
