//! Checked packets: the second format in the same ten bytes.
//!
//! Values need 10 of a word's 16 bits. Bit 15 of every data word stays 0, so that no data word can
//! be an address; the five bits below it carry, in the four data words from first to last, a 4-bit
//! sequence number and a 16-bit CRC:
//!
//! ```text
//!  data word    bit 15   bits 14..10          bits 9..0
//!     0           0      S3 S2 S1 S0 C15      value 0
//!     1           0      C14 .. C10           value 1
//!     2           0      C9  .. C5            value 2
//!     3           0      C4  .. C0            value 3
//! ```
//!
//! The CRC is CRC-16/DNP (polynomial 0x3D65, 0x9EB2 in Koopman's notation). It covers a byte that
//! tells requests from answers (not sent) and the ten bytes with the CRC's bits at 0, 88 bits in
//! all. Up to 135 bits its Hamming distance is 6, the best a 16-bit CRC reaches at this length: P.
//! Koopman, T. Chakravarty, "Cyclic Redundancy Code (CRC) Polynomial Selection for Embedded
//! Networks", DSN 2004, table 3. So every error of up to five bits is found (`tests/checked.rs`
//! tries them all), every odd number of flipped bits, and of random damage all but one in 65,536.
//! `docs/reliability.md` has the figures; `examples/undetected_errors.rs` makes them.
//!
//! An original board answers a checked request, unchecked and with its pressures, and then drops
//! its commands, because words exceed 1023. By the format of the answer a host tells the two kinds
//! of boards apart when it pings them.
//!
//! Four commands of 0 counts are no set point (0 kPa is 102 counts). In a checked request they say
//! that the host leaves ([`CheckedPacket::leave`]): the board vents, answers, and forgets the host,
//! so that the next one, of whichever kind, is obeyed at once. Firmware that does not know of it
//! takes them for four commands of 0 counts, which vent.

use crate::spare_bits::{CRC_BITS, Kind, SPARE_BITS, bytes_of, gather, request_crc, spread};
use crate::{Address, CHANNELS, Counts, PACKET_LEN, Packet, PacketError, Seal, Sequence};
use thiserror::Error;

/// Who sends a checked packet. Part of what the CRC covers, so a host's own echo is never taken for
/// an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From the host: values are commands.
    Request,
    /// From a board: values are pressures.
    Answer,
}

impl Direction {
    const fn kind(self) -> Kind {
        match self {
            Self::Request => Kind::Request,
            Self::Answer => Kind::Answer,
        }
    }
}

/// Ten bytes that are no valid checked packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CheckedError {
    /// Not even the form of a packet: no address, or a data word with bit 15 set.
    #[error(transparent)]
    Form(#[from] PacketError),
    /// The CRC does not fit.
    #[error("expected CRC 0x{expected:04X} for these values, got 0x{got:04X}")]
    Crc {
        /// The CRC of the bytes as they came.
        expected: u16,
        /// The CRC that came with them.
        got: u16,
    },
}

/// A packet with a sequence number, as it is sent with a CRC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CheckedPacket {
    /// Address and values.
    pub packet: Packet,
    /// The request's number.
    pub sequence: Sequence,
}

impl CheckedPacket {
    /// The commands of a request that says that the host leaves.
    pub const LEAVE: [Counts; CHANNELS] = [Counts::MIN; CHANNELS];

    /// The request that tells the board with this address that its host leaves: it vents, answers,
    /// and forgets the host.
    pub const fn leave(address: Address, sequence: Sequence) -> Self {
        Self { packet: Packet { address, values: Self::LEAVE }, sequence }
    }

    /// Whether this, as a request, says that the host leaves.
    pub fn is_leave(&self) -> bool {
        self.packet.values == Self::LEAVE
    }

    /// The ten bytes on the wire.
    pub fn encode(&self, direction: Direction) -> [u8; PACKET_LEN] {
        self.encode_as(direction.kind(), None)
    }

    /// The ten bytes on the wire, with `seal` in the CRC. Their number is that of the seal.
    pub fn encode_sealed(&self, direction: Direction, seal: Seal) -> [u8; PACKET_LEN] {
        let numbered = Self { sequence: seal.number().sequence(), ..*self };
        numbered.encode_as(direction.kind(), Some(seal))
    }

    /// The ten bytes on the wire, sent as `kind`.
    pub(crate) fn encode_as(&self, kind: Kind, seal: Option<Seal>) -> [u8; PACKET_LEN] {
        let mut words = self.packet.values.map(Counts::get);
        spread(&mut words, u32::from(self.sequence.get()) << CRC_BITS);
        let crc = request_crc(self.packet.address, words)
            ^ kind.crc_difference()
            ^ seal.map_or(0, Seal::crc_difference);
        spread(&mut words, u32::from(crc));
        bytes_of(self.packet.address, words)
    }

    /// Largest high byte of a data word: bit 15 is 0.
    pub(crate) const DATA_HIGH_BYTE_MAX: u8 = 0x7F;

    /// Reads ten bytes as a checked packet sent in `direction`.
    pub fn decode(bytes: &[u8; PACKET_LEN], direction: Direction) -> Result<Self, CheckedError> {
        let (checked, got, expected) = Self::parse(bytes)?;
        let expected = expected ^ direction.kind().crc_difference();
        if got == expected { Ok(checked) } else { Err(CheckedError::Crc { expected, got }) }
    }

    /// Reads ten bytes as a checked packet with commands or pressures, and tells who sent it.
    pub fn decode_either(bytes: &[u8; PACKET_LEN]) -> Result<(Self, Direction), CheckedError> {
        let (checked, got, expected) = Self::parse(bytes)?;
        let directions = [Direction::Request, Direction::Answer];
        let direction = directions.into_iter().find(|one| got == expected ^ one.kind().crc_difference());
        direction.map(|direction| (checked, direction)).ok_or(CheckedError::Crc { expected, got })
    }

    /// Reads ten bytes as a packet with a CRC of any kind, in a session if `seal` knows a seal for
    /// their address and number. The session's CRC goes first: what fits it is of the session,
    /// whatever else it fits.
    #[inline]
    pub(crate) fn decode_any(
        bytes: &[u8; PACKET_LEN],
        seal: impl FnOnce(Address, Sequence) -> Option<Seal>,
    ) -> Result<(Self, Kind, Option<Seal>), CheckedError> {
        let (checked, got, expected) = Self::parse(bytes)?;
        let kind_at =
            |offset: u16| Kind::ALL.into_iter().find(|kind| got == expected ^ kind.crc_difference() ^ offset);
        let seal = seal(checked.packet.address, checked.sequence);
        if let Some(seal) = seal
            && let Some(kind) = kind_at(seal.crc_difference())
        {
            return Ok((checked, kind, Some(seal)));
        }
        kind_at(0).map(|kind| (checked, kind, None)).ok_or(CheckedError::Crc { expected, got })
    }

    /// The packet, the CRC that came with it, and the CRC that it should have as a request.
    fn parse(bytes: &[u8; PACKET_LEN]) -> Result<(Self, u16, u16), PacketError> {
        let word = |index: usize| u16::from_be_bytes([bytes[2 * index], bytes[2 * index + 1]]);
        let address = Address::from_word(word(0)).ok_or(PacketError::NotAnAddress { word: word(0) })?;
        let mut words = [0; CHANNELS];
        for (index, slot) in words.iter_mut().enumerate() {
            *slot = word(index + 1);
            if *slot > SPARE_BITS | Counts::MAX.get() {
                return Err(PacketError::ValueOutOfRange { index, word: *slot });
            }
        }
        let spare = gather(words);
        let (sequence, got) = (Sequence::new((spare >> CRC_BITS) as u8), spare as u16);
        let mut values = words.map(|word| word & !SPARE_BITS);
        let packet = Packet { address, values: values.map(Counts::saturating) };
        spread(&mut values, u32::from(sequence.get()) << CRC_BITS);
        Ok((Self { packet, sequence }, got, request_crc(address, values)))
    }
}
