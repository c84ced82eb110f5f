//! The program: loadable segments of an ELF file and the place of the RTT control block.

use std::sync::Arc;

use elf::ElfBytes;
use elf::abi::{EM_ARM, ET_EXEC, PT_LOAD};
use elf::endian::LittleEndian;

/// Flash is mapped from here; the first 256 bytes are the second-stage boot loader.
pub(crate) const FLASH_START: u32 = 0x1000_0000;
const FLASH_LIMIT: u32 = 0x1100_0000;
const SRAM_START: u32 = 0x2000_0000;
const SRAM_END: u32 = SRAM_START + 264 * 1024;
/// The vector table after the boot loader, where boot2 jumps to.
pub(crate) const VECTOR_TABLE: u32 = 0x1000_0100;
/// Where the boot ROM copies the boot loader and starts it, with the stack below: the end of the
/// last SRAM bank (2.8.1.3.1).
pub(crate) const BOOT_LOADER: u32 = 0x2004_1f00;
/// The boot ROM reads that many bytes from the start of flash; the last four are a checksum of the
/// others.
const BOOT_BLOCK: usize = 256;
const BOOT_CODE: usize = BOOT_BLOCK - 4;
/// RTT's control block, by the name every implementation gives it.
const RTT_SYMBOL: &str = "_SEGGER_RTT";

/// Why a file cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ElfError {
    /// The file is no ELF file, or a damaged one.
    #[error("not a readable 32-bit little-endian ELF file: {0}")]
    Malformed(#[from] elf::ParseError),
    /// The file is for another machine.
    #[error(
        "expected an ARM executable (machine {EM_ARM}, type {ET_EXEC}), found machine {machine}, type {kind}"
    )]
    NotAnArmExecutable {
        /// e_machine.
        machine: u16,
        /// e_type.
        kind: u16,
    },
    /// A segment lies outside flash and SRAM.
    #[error(
        "segment of {size} bytes at {address:#010x} lies outside flash and SRAM; is memory.x the RP2040's?"
    )]
    SegmentOutsideMemory {
        /// Physical address.
        address: u32,
        /// Bytes in the file.
        size: usize,
    },
    /// Nothing is linked to the place the boot loader jumps to.
    #[error("no vector table at {VECTOR_TABLE:#010x}; link with link.x and link-rp.x, boot block first")]
    NoVectorTable,
    /// The boot block's checksum is wrong: the boot ROM would not start it.
    #[error("the boot block has checksum {found:#010x}, expected {expected:#010x}")]
    BadBootBlock {
        /// Its last word.
        found: u32,
        /// CRC-32 of the rest, as the boot ROM computes it.
        expected: u32,
    },
    /// The initial stack pointer or the reset vector cannot be right.
    #[error(
        "vector table has stack pointer {stack_pointer:#010x} and entry {entry:#010x}, expected SRAM and odd"
    )]
    BadVectorTable {
        /// First word.
        stack_pointer: u32,
        /// Second word.
        entry: u32,
    },
}

/// A program ready to be put into a chip. Cloning shares the flash.
#[derive(Clone, Debug)]
pub(crate) struct Image {
    /// From [`FLASH_START`].
    pub flash: Arc<[u8]>,
    /// Segments loaded straight into SRAM, which a debugger can do and a boot cannot: programs for
    /// tests.
    pub sram: Vec<(u32, Vec<u8>)>,
    /// The second-stage boot loader; none if its block is blank.
    pub boot_loader: Option<[u8; BOOT_CODE]>,
    /// Address of `_SEGGER_RTT`.
    pub rtt: Option<u32>,
}

impl Image {
    pub fn from_elf(bytes: &[u8]) -> Result<Image, ElfError> {
        let file = ElfBytes::<LittleEndian>::minimal_parse(bytes)?;
        if (file.ehdr.e_machine, file.ehdr.e_type) != (EM_ARM, ET_EXEC) {
            return Err(ElfError::NotAnArmExecutable {
                machine: file.ehdr.e_machine,
                kind: file.ehdr.e_type,
            });
        }
        let mut flash = Vec::new();
        let mut sram = Vec::new();
        let segments =
            file.segments().into_iter().flatten().filter(|s| s.p_type == PT_LOAD && s.p_filesz > 0);
        for segment in segments {
            let data = file.segment_data(&segment)?;
            let outside =
                || ElfError::SegmentOutsideMemory { address: segment.p_paddr as u32, size: data.len() };
            let start = u32::try_from(segment.p_paddr).map_err(|_| outside())?;
            let end = u32::try_from(data.len())
                .ok()
                .and_then(|size| start.checked_add(size))
                .ok_or_else(outside)?;
            if start >= FLASH_START && end <= FLASH_LIMIT {
                let (from, to) = ((start - FLASH_START) as usize, (end - FLASH_START) as usize);
                if flash.len() < to {
                    flash.resize(to, 0xff);
                }
                flash[from..to].copy_from_slice(data);
            } else if start >= SRAM_START && end <= SRAM_END {
                sram.push((start, data.to_vec()));
            } else {
                return Err(outside());
            }
        }
        let rtt = find_rtt(&file)?;
        Ok(Image { sram, rtt, ..Image::from_flash(&flash)? })
    }

    /// Flash contents without an ELF file around them.
    pub fn from_flash(flash: &[u8]) -> Result<Image, ElfError> {
        let boot_loader = find_boot_loader(flash)?;
        check_vector_table(flash)?;
        // Erased up to a whole word, or its last bytes would be read as erased, too.
        let mut words = flash.to_vec();
        words.resize(flash.len().next_multiple_of(4), 0xff);
        Ok(Image { flash: words.into(), sram: Vec::new(), boot_loader, rtt: None })
    }
}

/// The code of the boot block, which the boot ROM copies to SRAM and runs there if its checksum is
/// right (2.8.1.3.1).
fn find_boot_loader(flash: &[u8]) -> Result<Option<[u8; BOOT_CODE]>, ElfError> {
    let Some(block) = flash.first_chunk::<BOOT_BLOCK>() else { return Ok(None) };
    let blank = [[0x00; BOOT_BLOCK], [0xff; BOOT_BLOCK]];
    if blank.contains(block) {
        return Ok(None);
    }
    let Some((code, &checksum)) = block
        .split_first_chunk::<BOOT_CODE>()
        .and_then(|(code, rest)| rest.first_chunk::<4>().map(|checksum| (code, checksum)))
    else {
        return Ok(None);
    };
    let (found, expected) = (u32::from_le_bytes(checksum), boot_checksum(code));
    if found == expected { Ok(Some(*code)) } else { Err(ElfError::BadBootBlock { found, expected }) }
}

/// CRC-32 with polynomial 0x04c1_1db7 from all ones, most significant bit first, nothing inverted
/// at the end.
fn boot_checksum(code: &[u8]) -> u32 {
    code.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte) << 24, |crc, _| {
            crc << 1 ^ if crc >> 31 != 0 { 0x04c1_1db7 } else { 0 }
        })
    })
}

fn check_vector_table(flash: &[u8]) -> Result<(), ElfError> {
    let table = flash.get((VECTOR_TABLE - FLASH_START) as usize..).unwrap_or_default();
    let Some(&[a, b, c, d, e, f, g, h]) = table.first_chunk() else { return Err(ElfError::NoVectorTable) };
    let (stack_pointer, entry) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
    if entry & 1 == 0 || !(SRAM_START..=SRAM_END).contains(&stack_pointer) {
        return Err(ElfError::BadVectorTable { stack_pointer, entry });
    }
    Ok(())
}

fn find_rtt(file: &ElfBytes<'_, LittleEndian>) -> Result<Option<u32>, ElfError> {
    let Some((symbols, names)) = file.symbol_table()? else { return Ok(None) };
    for symbol in symbols {
        if names.get(symbol.st_name as usize)? == RTT_SYMBOL {
            return Ok(u32::try_from(symbol.st_value).ok());
        }
    }
    Ok(None)
}
