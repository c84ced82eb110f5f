//! The firmware as a UF2 file: what the boot ROM would write to flash runs.

use pneudrive_chip::Chip;
use pneudrive_uf2::{BootError, ChipFamily, FlashImage, check_bootable, encode};
use system_tests::chip_bench::{BOOT, ChipBench, packet};
use system_tests::firmware;

fn image() -> FlashImage {
    FlashImage::from_elf(firmware::elf()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_board_flashed_by_uf2_answers() {
    let uf2 = encode(&image(), ChipFamily::Rp2040);
    let (flash, families) = uf2_decode::convert_from_uf2(&uf2).unwrap_or_else(|error| panic!("{error:?}"));
    assert_eq!(families.into_iter().collect::<Vec<_>>(), [(0xe48b_ff56, 0x1000_0000)]);

    let chip = Chip::from_flash(&flash).unwrap_or_else(|error| panic!("{error}"));
    let mut bench = ChipBench::on_board(chip, 2);
    bench.run(BOOT);
    let Some(answer) = bench.exchange(packet(2, [102; 4])) else { panic!("no answer") };
    assert_eq!(answer.packet(), packet(2, [102; 4]), "the pressures that the sensors read");
    assert_eq!(bench.chip.unmodelled_accesses().count(), 0);
}

#[test]
fn what_the_boot_rom_would_not_start_is_not_written() {
    assert_eq!(check_bootable(&image(), ChipFamily::Rp2040), Ok(()));
    assert_eq!(check_bootable(&image(), ChipFamily::Rp2350), Err(BootError::ImageDefinition));

    // Without `link-rp.x` the boot loader lies elsewhere, and the ROM goes back to BOOTSEL without
    // a word.
    let mut elf = firmware::elf().to_vec();
    let at = firmware::file_offset_of_address(&elf, 0x1000_0010).unwrap_or_else(|| panic!("no boot loader"));
    elf[at] ^= 1;
    let damaged = FlashImage::from_elf(&elf).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(check_bootable(&damaged, ChipFamily::Rp2040), Err(BootError::BootLoader { .. })));
}
