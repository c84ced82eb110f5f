//! A board's program from a file: what an update over the bus sends.
//!
//! ELF and UF2 files are what `cargo fw-build` and `cargo fw-uf2` make; of them only the program
//! counts, not the boot stage in front of it. Any other file must be the program itself.

use pneudrive_protocol::program::{Program, ProgramError, crc};
use thiserror::Error;

/// Where flash is mapped.
const FLASH: usize = 0x1000_0000;
/// Where a program is in flash when it is flashed by a probe or as UF2.
const PROGRAM: usize = FLASH + 0x4000;
/// No chip has more.
const FLASH_SIZE: usize = 16 << 20;

/// A program, complete and with its CRC.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramFile {
    program: Program,
    bytes: Vec<u8>,
    crc: u32,
}

/// Why a file cannot be sent to a board.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ProgramFileError {
    /// The file is cut off, or not of the format that it begins like.
    #[error("a damaged {format} file")]
    Malformed {
        /// "ELF" or "UF2".
        format: &'static str,
    },
    /// It is for another chip's boot loader.
    #[error("a UF2 file for another chip (family {family:#010x}); updates over the bus are for the RP2040")]
    OtherFamily {
        /// The family's number in the file.
        family: u32,
    },
    /// What it holds is no program that a board could start.
    #[error(
        "{error}; expected the RP2040's firmware with updates over the bus, as `cargo fw-build` (ELF) or `cargo fw-uf2` makes it, or such a program alone"
    )]
    NoProgram {
        /// Why.
        error: ProgramError,
    },
    /// The file ends before the program.
    #[error("the program has {length} bytes, and the file only {found} of them")]
    CutOff {
        /// Bytes that the program says it has.
        length: usize,
        /// Bytes of it in the file.
        found: usize,
    },
}

impl ProgramFile {
    /// From a file's bytes.
    ///
    /// # Errors
    /// Why it cannot be sent to a board.
    pub fn parse(file: &[u8]) -> Result<Self, ProgramFileError> {
        let mut bytes = match file {
            [0x7f, b'E', b'L', b'F', ..] => {
                from_elf(file).ok_or(ProgramFileError::Malformed { format: "ELF" })?
            }
            [b'U', b'F', b'2', b'\n', ..] => from_uf2(file)?,
            program => program.to_vec(),
        };
        let program = Program::parse(&bytes).map_err(|error| ProgramFileError::NoProgram { error })?;
        if bytes.len() < program.length {
            return Err(ProgramFileError::CutOff { length: program.length, found: bytes.len() });
        }
        bytes.truncate(program.length);
        Ok(Self { program, crc: crc(&bytes), bytes })
    }

    /// What it says of itself.
    pub fn program(&self) -> Program {
        self.program
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Their CRC-32.
    pub fn crc(&self) -> u32 {
        self.crc
    }
}

/// What of flash begins at the program's place; bytes that are at no address in the file are 0xff.
#[derive(Default)]
struct Place(Vec<u8>);

impl Place {
    fn put(&mut self, address: usize, bytes: &[u8]) -> Option<()> {
        let end = address.checked_add(bytes.len()).filter(|end| *end <= FLASH + FLASH_SIZE)?;
        if end <= PROGRAM {
            return Some(());
        }
        let skipped = PROGRAM.saturating_sub(address);
        let (start, end) = (address + skipped - PROGRAM, end - PROGRAM);
        if self.0.len() < end {
            self.0.resize(end, 0xff);
        }
        self.0[start..end].copy_from_slice(&bytes[skipped..]);
        Some(())
    }
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let four = bytes.get(at..)?.first_chunk::<4>()?;
    usize::try_from(u32::from_le_bytes(*four)).ok()
}

/// What the segments of a 32-bit little-endian ELF file load at the addresses where they are
/// stored.
fn from_elf(file: &[u8]) -> Option<Vec<u8>> {
    const LOAD: usize = 1;
    let half = |at: usize| Some(usize::from(u16::from_le_bytes(*file.get(at..)?.first_chunk()?)));
    if file.get(4..6)? != [1, 1] {
        return None;
    }
    let (table, entry, entries) = (word(file, 28)?, half(42)?, half(44)?);
    let mut place = Place::default();
    for number in 0..entries {
        let header = file.get(table.checked_add(number * entry)?..)?;
        let (offset, address, length) = (word(header, 4)?, word(header, 12)?, word(header, 16)?);
        if word(header, 0)? == LOAD && length > 0 {
            place.put(address, file.get(offset..offset.checked_add(length)?)?)?;
        }
    }
    Some(place.0)
}

/// The pages of a UF2 file's blocks (github.com/microsoft/uf2).
fn from_uf2(file: &[u8]) -> Result<Vec<u8>, ProgramFileError> {
    const BLOCK: usize = 512;
    const MAGIC: [usize; 3] = [0x0A32_4655, 0x9E5D_5157, 0x0AB1_6F30];
    const RP2040: usize = 0xE48B_FF56;
    let malformed = ProgramFileError::Malformed { format: "UF2" };
    if !file.len().is_multiple_of(BLOCK) {
        return Err(malformed);
    }
    let mut place = Place::default();
    for block in file.chunks_exact(BLOCK) {
        let word = |at| word(block, at).unwrap_or(0);
        if [word(0), word(4), word(508)] != MAGIC {
            return Err(malformed);
        }
        if word(28) != RP2040 {
            return Err(ProgramFileError::OtherFamily { family: word(28) as u32 });
        }
        let data = block.get(32..32 + word(16)).ok_or_else(|| malformed.clone())?;
        place.put(word(12), data).ok_or_else(|| malformed.clone())?;
    }
    Ok(place.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(length: usize) -> Vec<u8> {
        let mut bytes: Vec<u8> = (0..length).map(|n| (n % 253) as u8).collect();
        let words = [
            (0, 0x2004_0000),
            (4, 0x2000_00d1),
            (192, u32::from_le_bytes(*b"PDF1")),
            (196, length as u32),
            (200, 1),
            (204, 3),
        ];
        for (at, word) in words {
            bytes[at..at + 4].copy_from_slice(&u32::to_le_bytes(word));
        }
        bytes
    }

    /// Two segments, the first of which ends in front of the program.
    fn elf(program: &[u8]) -> Vec<u8> {
        let mut file = vec![0; 52 + 2 * 32];
        file[..6].copy_from_slice(b"\x7fELF\x01\x01");
        file[28] = 52;
        file[42] = 32;
        file[44] = 2;
        let boot = [7; 100];
        for (n, (address, bytes)) in [(0x1000_0000_u32, &boot[..]), (0x1000_4000, program)].iter().enumerate()
        {
            let offset = file.len() as u32;
            let header = [1, offset, 0x2000_0000, *address, bytes.len() as u32];
            for (word, at) in header.into_iter().zip((52 + 32 * n..).step_by(4)) {
                file[at..at + 4].copy_from_slice(&word.to_le_bytes());
            }
            file.extend_from_slice(bytes);
        }
        file
    }

    fn uf2(program: &[u8], family: u32) -> Vec<u8> {
        let mut file = Vec::new();
        for (n, page) in program.chunks(256).enumerate() {
            let mut block = vec![0; 512];
            let address = 0x1000_4000 + 256 * n as u32;
            let words = [0x0A32_4655, 0x9E5D_5157, 0x2000, address, 256, n as u32, 0, family];
            for (word, at) in words.into_iter().zip((0..).step_by(4)) {
                block[at..at + 4].copy_from_slice(&u32::to_le_bytes(word));
            }
            block[32..32 + page.len()].copy_from_slice(page);
            block[508..].copy_from_slice(&0x0AB1_6F30_u32.to_le_bytes());
            file.extend(block);
        }
        file
    }

    #[test]
    fn all_formats_give_the_same_program() {
        let bytes = program(1_000);
        let file = ProgramFile::parse(&bytes).unwrap();
        assert_eq!((file.bytes(), file.crc()), (&bytes[..], crc(&bytes)));
        assert_eq!(file.program().version, [0, 0, 3]);
        assert_eq!(ProgramFile::parse(&elf(&bytes)), Ok(file.clone()));
        assert_eq!(ProgramFile::parse(&uf2(&bytes, 0xE48B_FF56)), Ok(file));
    }

    #[test]
    fn what_is_none_is_refused() {
        let bytes = program(1_000);
        let parse = |file: &[u8]| ProgramFile::parse(file).unwrap_err();
        assert_eq!(
            parse(&uf2(&bytes, 0xE48B_FF59)),
            ProgramFileError::OtherFamily { family: 0xE48B_FF59 },
            "the RP2350's"
        );
        assert_eq!(parse(&uf2(&bytes, 0xE48B_FF56)[..700]), ProgramFileError::Malformed { format: "UF2" });
        let file = elf(&bytes);
        for length in 4..file.len() {
            assert_eq!(parse(&file[..length]), ProgramFileError::Malformed { format: "ELF" }, "{length}");
        }
        assert_eq!(parse(&bytes[..900]), ProgramFileError::CutOff { length: 1_000, found: 900 });
        for other in [&b""[..], b"hello", &[0xff; 5_000]] {
            let error = ProgramError::NotAProgram;
            assert_eq!(parse(other), ProgramFileError::NoProgram { error });
        }
    }
}
