use crc::{CRC_32_MPEG_2, Crc};
use thiserror::Error;

use crate::{ChipFamily, FlashImage};

/// RP2040: the boot loader's code, and behind it its checksum (datasheet 2.8.1.3.1).
const BOOT_LOADER: usize = 252;
/// RP2350: the ROM looks there for the block that says what the image is (datasheet 5.1.5).
const SEARCHED: usize = 4096;
/// First and last word of such a block (5.1.5.1).
const BLOCK_START: u32 = 0xffff_ded3;
const BLOCK_END: u32 = 0xab12_3579;

/// Why a boot ROM would not start an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BootError {
    /// It does not begin where the ROM looks.
    #[error("the program begins at {start:#010x}, expected 0x10000000")]
    Start {
        /// Address of its first page.
        start: u32,
    },
    /// RP2040: there is no second-stage boot loader, or a damaged one.
    #[error("the RP2040's boot loader has checksum {found:#010x}, expected {expected:#010x}")]
    BootLoader {
        /// Its last word.
        found: u32,
        /// CRC-32 of the rest, as the boot ROM computes it.
        expected: u32,
    },
    /// RP2350: nothing says what the image is.
    #[error("no image definition for the RP2350 in the first 4 KiB")]
    ImageDefinition,
}

/// Whether the chip's boot ROM would start this image: it says nothing when it does not.
///
/// # Errors
/// [`BootError`]; also for a program for the other chip.
pub fn check_bootable(image: &FlashImage, family: ChipFamily) -> Result<(), BootError> {
    if image.start() != 0x1000_0000 {
        return Err(BootError::Start { start: image.start() });
    }
    let mut words = image.bytes().as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word));
    match family {
        ChipFamily::Rp2040 => {
            let code = &image.bytes()[..BOOT_LOADER.min(image.bytes().len())];
            let expected = Crc::<u32>::new(&CRC_32_MPEG_2).checksum(code);
            let found = words.nth(BOOT_LOADER / 4).unwrap_or(0);
            if found == expected { Ok(()) } else { Err(BootError::BootLoader { found, expected }) }
        }
        ChipFamily::Rp2350 => {
            let mut block = words.take(SEARCHED / 4).skip_while(|word| *word != BLOCK_START);
            let complete = block.any(|word| word == BLOCK_END);
            if complete { Ok(()) } else { Err(BootError::ImageDefinition) }
        }
    }
}
