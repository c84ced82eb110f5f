use elf::ElfBytes;
use elf::abi::PT_LOAD;
use elf::endian::LittleEndian;
use thiserror::Error;

use crate::PAGE;

/// Where flash is mapped, on both chips.
const FLASH: u32 = 0x1000_0000;
/// Flash that a boot ROM can address.
const FLASH_SIZE: usize = 16 << 20;
/// Where RAM is, on both chips.
const RAM: std::ops::Range<u64> = 0x2000_0000..0x2010_0000;

/// What a program occupies of flash, without a gap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlashImage {
    start: u32,
    bytes: Vec<u8>,
    static_ram: u64,
}

/// Why a file is no program for flash.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file is no ELF file, or a damaged one.
    #[error("not a readable 32-bit little-endian ELF file: {0}")]
    Malformed(#[from] elf::ParseError),
    /// A segment is not in flash, so no boot would put it where it belongs.
    #[error("segment of {size} bytes at {address:#010x} is loaded outside flash")]
    OutsideFlash {
        /// Address at which it is loaded.
        address: u64,
        /// Bytes of it in the file.
        size: usize,
    },
    /// The file has nothing to load.
    #[error("no segment is loaded to flash")]
    Empty,
}

impl FlashImage {
    /// What is loaded of an ELF file, at the addresses where it is stored (not where start-up
    /// copies it).
    ///
    /// # Errors
    /// [`ImageError`]
    pub fn from_elf(elf: &[u8]) -> Result<Self, ImageError> {
        let file = ElfBytes::<LittleEndian>::minimal_parse(elf)?;
        let mut flash: Vec<u8> = Vec::new();
        let mut start = usize::MAX;
        let mut static_ram = 0;
        for segment in file.segments().into_iter().flatten() {
            if segment.p_type != PT_LOAD {
                continue;
            }
            if RAM.contains(&segment.p_vaddr) {
                static_ram += segment.p_memsz;
            }
            if segment.p_filesz == 0 {
                continue;
            }
            let data = file.segment_data(&segment)?;
            let outside = || ImageError::OutsideFlash { address: segment.p_paddr, size: data.len() };
            let from = segment.p_paddr.checked_sub(FLASH.into()).ok_or_else(outside)?;
            let from = usize::try_from(from).map_err(|_| outside())?;
            let to = from.checked_add(data.len()).filter(|to| *to <= FLASH_SIZE).ok_or_else(outside)?;
            if flash.len() < to {
                flash.resize(to, 0xff);
            }
            flash[from..to].copy_from_slice(data);
            start = start.min(from);
        }
        if start > flash.len() {
            return Err(ImageError::Empty);
        }
        let start = start / PAGE * PAGE;
        Ok(Self { start: FLASH + start as u32, bytes: flash.split_off(start), static_ram })
    }

    /// Address of the first byte, that of a page.
    pub fn start(&self) -> u32 {
        self.start
    }

    /// The bytes from there on; 0xff, as erased, where the program leaves a gap.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Bytes of RAM that variables, and code that runs from there, take up. The stack is not in it.
    pub fn static_ram(&self) -> u64 {
        self.static_ram
    }
}
