//! Which program a board starts with: a record in flash that changes only when an update is
//! confirmed.
//!
//! ```text
//!  word    0        1        2              3                4       5
//!          "PDC1"   number   place, 0 or 1  length, bytes    CRC     CRC-32 of the words before
//! ```
//!
//! Two sectors take turns, as for parameters ([`store`](crate::store)): the record with the highest
//! number whose CRC fits counts, and until the last word of a new one is there the old one does.
//! Without any record the board starts with the program in the first place, where a probe or the
//! boot ROM has flashed it. The boot stage reads these words, too, and it may be older than whoever
//! writes them.

use pneudrive_protocol::program::crc;

/// Bytes of a record: one page of flash.
pub const RECORD: usize = 256;
/// "PDC1".
pub const FORMAT: u32 = u32::from_le_bytes(*b"PDC1");
const WORDS: usize = 6;
const CRC_AT: usize = 4 * (WORDS - 1);

/// A program that a board starts with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// Which record it is; it grows with every confirmation.
    pub number: u32,
    /// Place of the program, 0 or 1.
    pub place: u32,
    /// Its length, bytes.
    pub length: u32,
    /// Its CRC-32.
    pub crc: u32,
}

impl Choice {
    /// The page that keeps it.
    pub fn encode(&self) -> [u8; RECORD] {
        let mut record = [0xff; RECORD];
        let words = [FORMAT, self.number, self.place, self.length, self.crc];
        for (slot, word) in record.as_chunks_mut::<4>().0.iter_mut().zip(words) {
            *slot = word.to_le_bytes();
        }
        let sum = crc(&record[..CRC_AT]);
        record[CRC_AT..CRC_AT + 4].copy_from_slice(&sum.to_le_bytes());
        record
    }

    /// What a page keeps, if that is a record.
    pub fn decode(record: &[u8; RECORD]) -> Option<Self> {
        let mut words = record.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word));
        if words.next()? != FORMAT {
            return None;
        }
        let [number, place, length, program_crc, sum] = core::array::from_fn(|_| words.next().unwrap_or(0));
        (sum == crc(&record[..CRC_AT]) && place < 2).then_some(Self {
            number,
            place,
            length,
            crc: program_crc,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHOICE: Choice = Choice { number: 7, place: 1, length: 60_000, crc: 0x1234_5678 };

    /// Its bytes, frozen: boot stages that are flashed read them.
    #[test]
    fn a_record_stands_like_this_in_flash() {
        let record = CHOICE.encode();
        assert_eq!(record[..8], *b"PDC1\x07\0\0\0");
        assert_eq!(record[8..20], [1, 0, 0, 0, 0x60, 0xEA, 0, 0, 0x78, 0x56, 0x34, 0x12]);
        assert!(record[24..].iter().all(|byte| *byte == 0xff));
        assert_eq!(Choice::decode(&record), Some(CHOICE));
    }

    #[test]
    fn any_flipped_bit_is_noticed() {
        for bit in 0..8 * 4 * WORDS {
            let mut record = CHOICE.encode();
            record[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Choice::decode(&record), None, "bit {bit}");
        }
        assert_eq!(Choice::decode(&[0xff; RECORD]), None);
        assert_eq!(Choice::decode(&[0; RECORD]), None);
        assert_eq!(Choice::decode(&Choice { place: 2, ..CHOICE }.encode()), None);
    }
}
