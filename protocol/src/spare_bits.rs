//! What the spare bits of data words carry: a sequence number and a CRC.
//! [`checked`](crate::checked) has the layout.

use crate::{Address, CHANNELS, PACKET_LEN};
use crc::{CRC_16_DNP, Crc};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_DNP);

/// The spare bits of a data word.
pub(crate) const SPARE_BITS: u16 = 0x7C00;
const SPARE_SHIFT: u32 = 10;
/// Where the first 16 of the 20 spare bits, read as one number, end: below them is the CRC.
pub(crate) const CRC_BITS: u32 = 16;

/// What ten bytes with a CRC are: a byte in front of what the CRC covers, which is not sent.
///
/// A request and a page request, an answer and a page answer differ in one bit of that byte, so
/// that at least five flipped bits are needed to make one of the other (the CRC's Hamming distance
/// is 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Request,
    Answer,
    PageRequest,
    PageAnswer,
}

impl Kind {
    pub(crate) const ALL: [Self; 4] = [Self::Request, Self::Answer, Self::PageRequest, Self::PageAnswer];

    const fn seed(self) -> u8 {
        match self {
            Self::Request => b'R',
            Self::Answer => b'A',
            Self::PageRequest => b'P',
            Self::PageAnswer => b'C',
        }
    }

    /// CRCs are linear: those of the same bytes sent as a request and as this always differ by this
    /// number.
    pub(crate) const fn crc_difference(self) -> u16 {
        const DIFFERENCES: [u16; 4] = [
            difference(Kind::Request),
            difference(Kind::Answer),
            difference(Kind::PageRequest),
            difference(Kind::PageAnswer),
        ];
        DIFFERENCES[self as usize]
    }
}

const fn difference(kind: Kind) -> u16 {
    let mut bytes = [0; 1 + PACKET_LEN];
    bytes[0] = kind.seed();
    let of_kind = CRC.checksum(&bytes);
    bytes[0] = Kind::Request.seed();
    of_kind ^ CRC.checksum(&bytes)
}

/// Writes a 20-bit number over the spare bits (adds to what is there), most significant bits into
/// the first word.
pub(crate) fn spread(words: &mut [u16; CHANNELS], spare: u32) {
    for (index, word) in words.iter_mut().enumerate() {
        let from = 5 * (CHANNELS - 1 - index) as u32;
        *word |= ((spare >> from) as u16 & 0x1F) << SPARE_SHIFT;
    }
}

/// The number that [`spread`] wrote.
pub(crate) fn gather(words: [u16; CHANNELS]) -> u32 {
    words.iter().fold(0, |spare, word| spare << 5 | u32::from((word & SPARE_BITS) >> SPARE_SHIFT))
}

/// Address and data words in the order of the wire.
pub(crate) fn bytes_of(address: Address, words: [u16; CHANNELS]) -> [u8; PACKET_LEN] {
    let mut bytes = [0; PACKET_LEN];
    bytes[..2].copy_from_slice(&address.word().to_be_bytes());
    for (slot, word) in bytes[2..].chunks_exact_mut(2).zip(words) {
        slot.copy_from_slice(&word.to_be_bytes());
    }
    bytes
}

/// The CRC of a packet with these words, whose CRC bits are 0, as a request.
pub(crate) fn request_crc(address: Address, words: [u16; CHANNELS]) -> u16 {
    let mut digest = CRC.digest();
    digest.update(&[Kind::Request.seed()]);
    digest.update(&bytes_of(address, words));
    digest.finalize()
}

/// What a session's number and its board's number change in the CRC of its packets.
pub(crate) fn session_crc(address: Address, number: u32) -> u16 {
    let [a, b, c, d] = number.to_be_bytes();
    CRC.checksum(&[a, b, c, d, address.board()])
}
