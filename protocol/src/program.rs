//! A board's program as an update brings it: what says which program it is.
//!
//! A program is what start-up copies to the beginning of RAM and runs there. It begins with the
//! processor's vector table, and behind that come four words that every program of a board has at
//! the same place:
//!
//! ```text
//!  offset    0               4        192     196                200     204
//!            stack pointer   entry    "PDF1"  length, bytes      chip    version: 10 bits each
//! ```
//!
//! In an update the program's CRC-32 follows it ([`crc()`], four bytes, little-endian).

use crate::pages::ChipKind;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// "PDF1": a program of a PneuDrive board.
pub const MAGIC: u32 = u32::from_le_bytes(*b"PDF1");
/// Where the four words are: behind a vector table of 48 entries.
pub const HEADER_AT: usize = 192;
/// The shortest program: up to the end of the four words.
const SHORTEST: usize = HEADER_AT + 16;
/// The longest program of an RP2040, bytes: what a board can keep in RAM until it is complete, with
/// its CRC.
pub const LONGEST: usize = 128 * 1024 - 8;
/// Where it runs.
pub const RAM: core::ops::Range<u32> = 0x2000_0000..0x2004_0000;

/// What a program says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Program {
    /// The chip it is for.
    pub chip: ChipKind,
    /// Major, minor and patch level, each 0 to 1023.
    pub version: [u16; 3],
    /// Its length, bytes; a multiple of 4.
    pub length: usize,
}

/// Why bytes are no program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ProgramError {
    /// The mark is missing: another product's, or damaged.
    #[error("it is no program of a PneuDrive board")]
    NotAProgram,
    /// Its length cannot be right.
    #[error("it says that it has {length} bytes, expected a multiple of 4 from {SHORTEST} to {LONGEST}")]
    Length {
        /// What it says.
        length: u32,
    },
    /// Its stack pointer or its entry is not in RAM.
    #[error("its stack pointer {stack_pointer:#010x} or entry {entry:#010x} cannot be right")]
    Vectors {
        /// First word.
        stack_pointer: u32,
        /// Second word.
        entry: u32,
    },
}

impl Program {
    /// What the program at the beginning of `bytes` says of itself. That it is complete, its CRC
    /// tells.
    ///
    /// # Errors
    /// Why it is none.
    pub fn parse(bytes: &[u8]) -> Result<Self, ProgramError> {
        let word = |at: usize| {
            let four = bytes.get(at..).and_then(|rest| rest.first_chunk::<4>());
            four.map(|four| u32::from_le_bytes(*four)).ok_or(ProgramError::NotAProgram)
        };
        if word(HEADER_AT)? != MAGIC {
            return Err(ProgramError::NotAProgram);
        }
        let (length, chip, version) = (word(HEADER_AT + 4)?, word(HEADER_AT + 8)?, word(HEADER_AT + 12)?);
        if !(SHORTEST..=LONGEST).contains(&(length as usize)) || length % 4 != 0 {
            return Err(ProgramError::Length { length });
        }
        let (stack_pointer, entry) = (word(0)?, word(4)?);
        let in_program = RAM.start..RAM.start + length;
        let stack_fits = (in_program.end..=RAM.end).contains(&stack_pointer) && stack_pointer % 8 == 0;
        if !stack_fits || entry & 1 == 0 || !in_program.contains(&entry) {
            return Err(ProgramError::Vectors { stack_pointer, entry });
        }
        let chip = u8::try_from(chip).map(ChipKind::of_number).map_err(|_| ProgramError::NotAProgram)?;
        let part = |shift: u32| (version >> shift & 1_023) as u16;
        Ok(Self { chip, version: [part(20), part(10), part(0)], length: length as usize })
    }
}

/// The CRC-32 of a program (ISO-HDLC: that of Ethernet, gzip and PNG).
pub fn crc(program: &[u8]) -> u32 {
    Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC).checksum(program)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(words: [(usize, u32); 6]) -> std::vec::Vec<u8> {
        let mut bytes = std::vec![0; 256];
        for (at, word) in words {
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    const WORDS: [(usize, u32); 6] = [
        (0, 0x2004_0000),
        (4, 0x2000_00d1),
        (192, MAGIC),
        (196, 256),
        (200, 1),
        (204, 1 << 20 | 2 << 10 | 3),
    ];

    #[test]
    fn a_program_says_what_it_is() {
        let expected = Program { chip: ChipKind::Rp2040, version: [1, 2, 3], length: 256 };
        assert_eq!(Program::parse(&program(WORDS)), Ok(expected));
    }

    #[test]
    fn what_cannot_be_started_is_none() {
        let with = |n: usize, word| {
            let mut words = WORDS;
            words[n].1 = word;
            Program::parse(&program(words))
        };
        assert_eq!(with(2, MAGIC ^ 1), Err(ProgramError::NotAProgram));
        for length in [0, 204, 254, LONGEST as u32 + 4, u32::MAX] {
            assert_eq!(with(3, length), Err(ProgramError::Length { length }));
        }
        for stack_pointer in [0, 0x2000_0000, 0x2000_00fc, 0x2004_0004, 0x2000_0104] {
            assert!(matches!(with(0, stack_pointer), Err(ProgramError::Vectors { .. })), "{stack_pointer:x}");
        }
        for entry in [0, 0x2000_00d0, 0x2000_0101, 0x1000_0001] {
            assert!(matches!(with(1, entry), Err(ProgramError::Vectors { .. })), "{entry:x}");
        }
        assert_eq!(Program::parse(&program(WORDS)[..207]), Err(ProgramError::NotAProgram));
        assert_eq!(Program::parse(&[]), Err(ProgramError::NotAProgram));
    }

    /// The check value of the catalogue of CRC algorithms.
    #[test]
    fn the_crc_is_that_of_the_catalogue() {
        assert_eq!(crc(b"123456789"), 0xCBF4_3926);
    }
}
