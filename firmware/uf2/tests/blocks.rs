//! The bytes of a UF2 file, and what an independent decoder makes of them.

#![allow(clippy::unwrap_used)]

use elf::abi::{EM_ARM, ET_EXEC, PT_LOAD};
use pneudrive_uf2::{BLOCK, ChipFamily, FlashImage, ImageError, encode};

/// An ELF file with segments of these contents, at the addresses where they are stored.
fn elf(segments: &[(u32, &[u8])]) -> Vec<u8> {
    const HEADER: usize = 52;
    const SEGMENT: usize = 32;
    let mut file = vec![0; HEADER];
    file[..7].copy_from_slice(&[0x7f, b'E', b'L', b'F', 1, 1, 1]);
    file[16..18].copy_from_slice(&ET_EXEC.to_le_bytes());
    file[18..20].copy_from_slice(&EM_ARM.to_le_bytes());
    file[20] = 1;
    file[28] = HEADER as u8;
    file[40] = HEADER as u8;
    file[42] = SEGMENT as u8;
    file[44] = segments.len() as u8;
    let mut offset = HEADER + SEGMENT * segments.len();
    for (address, data) in segments {
        let size = data.len() as u32;
        // Type, offset, address where it runs, address where it is stored, sizes in file and
        // memory, flags, alignment.
        for word in [PT_LOAD, offset as u32, 0x2000_0000, *address, size, size, 5, 4] {
            file.extend(word.to_le_bytes());
        }
        offset += data.len();
    }
    file.extend(segments.iter().flat_map(|(_, data)| data.iter()));
    file
}

fn word(block: &[u8], offset: usize) -> u32 {
    u32::from_le_bytes(block[offset..offset + 4].try_into().unwrap())
}

/// Do not change this test: it is the format, and the numbers of the chips in the boot ROMs.
#[test]
fn a_block_has_these_bytes() {
    let image = FlashImage::from_elf(&elf(&[(0x1000_0100, &[0xab; 257])])).unwrap();
    assert_eq!(image.start(), 0x1000_0100);
    assert_eq!(image.static_ram(), 257, "it runs from RAM");
    for (family, id) in [(ChipFamily::Rp2040, 0xe48b_ff56), (ChipFamily::Rp2350, 0xe48b_ff59)] {
        let uf2 = encode(&image, family);
        assert_eq!(uf2.len(), 2 * BLOCK);
        let second = &uf2[BLOCK..];
        assert_eq!(&second[..8], b"UF2\nWQ]\x9e");
        assert_eq!(word(second, 8), 0x2000, "the family is given");
        assert_eq!(word(second, 12), 0x1000_0200, "address");
        assert_eq!(word(second, 16), 256, "bytes of data");
        assert_eq!(word(second, 20), 1, "number of this block");
        assert_eq!(word(second, 24), 2, "number of blocks");
        assert_eq!(word(second, 28), id);
        assert_eq!(second[32], 0xab);
        assert!(second[33..288].iter().all(|byte| *byte == 0xff), "the rest of the page stays erased");
        assert!(second[288..508].iter().all(|byte| *byte == 0));
        assert_eq!(&second[508..], b"\x30\x6f\xb1\x0a");
    }
}

#[test]
fn another_decoder_gets_the_image_back() {
    let program: Vec<u8> = (0..5_000_u32).map(|n| ((n * n) >> 3) as u8).collect();
    let segments = elf(&[(0x1000_0000, &program[..256]), (0x1000_0300, &program[256..])]);
    let image = FlashImage::from_elf(&segments).unwrap();
    assert!(image.bytes()[256..0x300].iter().all(|byte| *byte == 0xff), "the gap between the segments");
    let (decoded, families) = uf2_decode::convert_from_uf2(&encode(&image, ChipFamily::Rp2040)).unwrap();
    assert_eq!(decoded[..image.bytes().len()], *image.bytes());
    assert_eq!(families.into_iter().collect::<Vec<_>>(), [(0xe48b_ff56, 0x1000_0000)]);
}

#[test]
fn what_is_not_for_flash_is_refused() {
    let refused = |segments| FlashImage::from_elf(&elf(segments)).unwrap_err();
    assert!(matches!(
        refused(&[(0x2000_0000, &[1])]),
        ImageError::OutsideFlash { address: 0x2000_0000, size: 1 }
    ));
    assert!(matches!(refused(&[(0x10ff_ffff, &[1, 2])]), ImageError::OutsideFlash { .. }));
    assert!(matches!(refused(&[(0, &[1])]), ImageError::OutsideFlash { .. }));
    assert!(matches!(refused(&[]), ImageError::Empty));
    assert!(matches!(FlashImage::from_elf(b"UF2").unwrap_err(), ImageError::Malformed(_)));
}
