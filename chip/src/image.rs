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
    /// Segments loaded straight into SRAM, which a debugger can do and a boot cannot: programs for tests.
    pub sram: Vec<(u32, Vec<u8>)>,
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
        check_vector_table(&flash)?;
        Ok(Image { flash: flash.into(), sram, rtt: find_rtt(&file)? })
    }

    /// Flash contents without an ELF file around them.
    pub fn from_flash(flash: &[u8]) -> Result<Image, ElfError> {
        check_vector_table(flash)?;
        Ok(Image { flash: flash.into(), sram: Vec::new(), rtt: None })
    }
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
