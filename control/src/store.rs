//! How parameters are kept in flash: two slots, one record in each, so that a power cut leaves the
//! old or the new.
//!
//! A record is one page of flash:
//!
//! ```text
//!  word    0        1        2 .. 33                       34 .. 62   63
//!          format   number   value of parameter 0, 1 ..    ones       CRC-32 of the words before
//!                            all ones: as compiled
//! ```
//!
//! The record with the highest number whose CRC fits counts. A new one goes into the other slot:
//! that is erased, then programmed, then read back. Until its last word is there the new record's
//! CRC does not fit, and the old record is not touched. The CRC finds every error of up to three
//! bits in a record (its Hamming distance at 2,016 bits is 4) and all but one in 2^32 of any
//! others.

use crate::ParameterSet;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use pneudrive_protocol::pages::Parameter;

/// Bytes of a record: one page of flash.
pub const RECORD: usize = 256;
/// Bytes of a slot: one sector of flash, which is erased as a whole.
pub const SLOT: usize = 4096;

const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
/// "PDP1".
const FORMAT: u32 = u32::from_le_bytes(*b"PDP1");
const ERASED: u32 = u32::MAX;
const FIRST_VALUE: usize = 2;
const CRC_AT: usize = RECORD - 4;

/// One of the two places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// The first.
    A,
    /// The second.
    B,
}

impl Slot {
    /// 0 or 1.
    pub const fn index(self) -> usize {
        self as usize
    }

    const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// The flash below: two slots of [`SLOT`] bytes.
pub trait Flash {
    /// The record at the start of a slot.
    fn read(&self, slot: Slot) -> [u8; RECORD];

    /// Sets all bits of a slot. False if the flash says that it failed.
    fn erase(&mut self, slot: Slot) -> bool;

    /// Clears bits at the start of an erased slot. False if the flash says that it failed.
    fn program(&mut self, slot: Slot, record: &[u8; RECORD]) -> bool;
}

/// A board's parameters as they are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stored {
    /// The values that differ from the compiled ones; the others are as compiled, also by another
    /// firmware.
    changed: [Option<u32>; Parameter::COUNT],
    /// Number of the record, 0 if there is none.
    number: u32,
    slot: Option<Slot>,
}

impl Stored {
    /// What a flash that was never written holds.
    pub const NOTHING: Self = Self { changed: [None; Parameter::COUNT], number: 0, slot: None };

    /// The newest whole record, or [`NOTHING`](Self::NOTHING).
    pub fn load(flash: &impl Flash) -> Self {
        [Slot::A, Slot::B]
            .into_iter()
            .filter_map(|slot| Self::decode(slot, &flash.read(slot)))
            .max_by_key(|stored| stored.number)
            .unwrap_or(Self::NOTHING)
    }

    /// Number of the record, 0 if there is none. It grows by one with every one that is written.
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Whether any value is not the compiled one.
    pub fn changes_anything(&self) -> bool {
        self.changed.iter().any(Option::is_some)
    }

    /// The compiled values with the kept ones over them.
    pub fn over(&self, compiled: &ParameterSet) -> ParameterSet {
        let mut set = *compiled;
        for (parameter, value) in Parameter::ALL.into_iter().zip(self.changed) {
            if let Some(value) = value {
                set.set(parameter, value);
            }
        }
        set
    }

    /// Keeps `set` from now on, as far as it differs from `compiled`. Nothing is written if that is
    /// what is kept already.
    ///
    /// # Errors
    /// The flash failed, or what it holds is not what was written. What was kept before still is.
    pub fn save(
        &self,
        flash: &mut impl Flash,
        set: &ParameterSet,
        compiled: &ParameterSet,
    ) -> Result<Self, WriteFailed> {
        let changed = Parameter::ALL
            .map(|parameter| Some(set.get(parameter)).filter(|value| *value != compiled.get(parameter)));
        if changed == self.changed {
            return Ok(*self);
        }
        let slot = self.slot.map_or(Slot::A, Slot::other);
        let new = Self { changed, number: self.number.saturating_add(1), slot: Some(slot) };
        let record = new.encode();
        if flash.erase(slot) && flash.program(slot, &record) && flash.read(slot) == record {
            Ok(new)
        } else {
            Err(WriteFailed)
        }
    }

    fn encode(&self) -> [u8; RECORD] {
        let mut record = [0xff; RECORD];
        let header = [FORMAT, self.number];
        let values = self.changed.iter().map(|value| value.unwrap_or(ERASED));
        for (place, word) in record.chunks_exact_mut(4).zip(header.into_iter().chain(values)) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        let crc = CRC.checksum(&record[..CRC_AT]);
        record[CRC_AT..].copy_from_slice(&crc.to_le_bytes());
        record
    }

    fn decode(slot: Slot, record: &[u8; RECORD]) -> Option<Self> {
        let mut words = record.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
        let found = words.next_back()?;
        if words.next()? != FORMAT || found != CRC.checksum(&record[..CRC_AT]) {
            return None;
        }
        let number = words.next()?;
        let mut changed = [None; Parameter::COUNT];
        for (value, word) in changed.iter_mut().zip(words) {
            *value = Some(word).filter(|word| *word != ERASED);
        }
        Some(Self { changed, number, slot: Some(slot) })
    }
}

/// What was to be kept is not in the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WriteFailed;

const _: () = assert!(4 * (FIRST_VALUE + Parameter::COUNT) <= CRC_AT);

#[cfg(test)]
mod tests;
