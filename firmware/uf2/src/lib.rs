//! UF2 files: what a chip of the RP2 family takes when it is plugged in with its BOOTSEL button
//! held.
//!
//! The boot ROM then shows itself as a USB drive, and whatever UF2 file is copied to it goes to
//! flash. A file is a row of blocks of 512 bytes, each with 256 bytes for one page of flash:
//!
//! ```text
//!   0  0x0A324655      16  bytes of data: 256        32  data
//!   4  0x9E5D5157      20  number of this block     288  zeros
//!   8  flags           24  number of blocks         508  0x0AB16F30
//!  12  address         28  chip family
//! ```
//!
//! The format is Microsoft's (github.com/microsoft/uf2); what the boot ROM wants of it is in the
//! RP2040 datasheet, 2.8.4.2, and the RP2350 datasheet, 5.5.2.
//!
//! ```no_run
//! use pneudrive_uf2::{ChipFamily, FlashImage, encode};
//!
//! let image = FlashImage::from_elf(&std::fs::read("firmware.elf")?)?;
//! std::fs::write("firmware.uf2", encode(&image, ChipFamily::Rp2040))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod boot;
mod image;

pub use boot::{BootError, check_bootable};
pub use image::{FlashImage, ImageError};

/// Bytes of a block.
pub const BLOCK: usize = 512;
/// Bytes of flash in a block: the boot ROM takes whole pages only.
pub const PAGE: usize = 256;

const MAGIC_START: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const MAGIC_END: u32 = 0x0AB1_6F30;
/// The word at 28 is a family.
const FAMILY_PRESENT: u32 = 0x2000;
const DATA: usize = 32;
const END: usize = BLOCK - 4;

/// Which boot ROM a file is for; another one ignores its blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChipFamily {
    /// RP2040.
    Rp2040,
    /// RP2350, on its Arm cores, in secure state.
    Rp2350,
}

impl ChipFamily {
    /// Its number in Microsoft's list, `utils/uf2families.json`.
    pub const fn id(self) -> u32 {
        match self {
            Self::Rp2040 => 0xE48B_FF56,
            Self::Rp2350 => 0xE48B_FF59,
        }
    }
}

/// The file's bytes: one block for each page of the image, in order of address.
pub fn encode(image: &FlashImage, family: ChipFamily) -> Vec<u8> {
    let blocks = image.bytes().len().div_ceil(PAGE);
    let pages = (0..).zip(image.bytes().chunks(PAGE));
    pages.flat_map(|(number, page)| block(image.start(), number, blocks as u32, family, page)).collect()
}

fn block(start: u32, number: u32, blocks: u32, family: ChipFamily, page: &[u8]) -> [u8; BLOCK] {
    let address = start + number * PAGE as u32;
    let [first, second] = MAGIC_START;
    let header = [first, second, FAMILY_PRESENT, address, PAGE as u32, number, blocks, family.id()];
    let mut block = [0; BLOCK];
    for (slot, word) in block.as_chunks_mut::<4>().0.iter_mut().zip(header) {
        *slot = word.to_le_bytes();
    }
    // As erased, behind the image's end.
    block[DATA..DATA + PAGE].fill(0xff);
    block[DATA..DATA + page.len()].copy_from_slice(page);
    block[END..].copy_from_slice(&MAGIC_END.to_le_bytes());
    block
}
