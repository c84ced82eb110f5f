use super::{DMA, RESETS, bus, read, reports, write};
use crate::report::Fault;

const FLASH: u32 = 0x1000_0000;
const SRAM: u32 = 0x2000_0000;
const SRAM_END: u32 = 0x2004_2000;

#[test]
fn flash_is_little_endian_and_appears_in_all_four_cache_aliases() {
    let mut bus = bus();
    for alias in [0x1000_0000, 0x1100_0000, 0x1200_0000, 0x1300_0000] {
        assert_eq!(bus.read32(alias + 4), Ok(0x0706_0504));
        assert_eq!(bus.read16(alias + 4), Ok(0x0504));
        assert_eq!(bus.read8(alias + 5), Ok(5));
    }
    assert_eq!(bus.read32(FLASH + 0x1000), Ok(0xffff_ffff), "erased beyond the image");
    assert_eq!(bus.write32(FLASH, 0), Ok(()), "gives up a cache entry");
    assert_eq!(bus.read32(FLASH), Ok(0x0302_0100));
    assert_eq!(bus.write32(0x1100_0000, 0), Err(Fault::Bus(0x1100_0000)));
}

#[test]
fn sram_takes_all_widths_up_to_its_last_byte() {
    let mut bus = bus();
    assert_eq!(bus.write32(SRAM, 0x1122_3344), Ok(()));
    assert_eq!(bus.write16(SRAM + 2, 0x5566), Ok(()));
    assert_eq!(bus.write8(SRAM + 1, 0x77), Ok(()));
    assert_eq!(bus.read32(SRAM), Ok(0x5566_7744));
    assert_eq!(bus.write32(SRAM_END - 4, 1), Ok(()));
    assert_eq!(bus.read8(SRAM_END - 4), Ok(1));
    assert_eq!(bus.read32(SRAM_END), Err(Fault::Bus(SRAM_END)));
    assert_eq!(bus.write8(SRAM_END, 0), Err(Fault::Bus(SRAM_END)));
}

#[test]
fn sram_is_not_zero_at_power_on() {
    assert_eq!(read(&mut bus(), SRAM + 0x1234), 0xa5a5_a5a5);
}

#[test]
fn misaligned_accesses_fault() {
    let mut bus = bus();
    assert_eq!(bus.read32(SRAM + 2), Err(Fault::Unaligned(SRAM + 2)));
    assert_eq!(bus.read16(SRAM + 1), Err(Fault::Unaligned(SRAM + 1)));
    assert_eq!(bus.write32(SRAM + 1, 0), Err(Fault::Unaligned(SRAM + 1)));
    assert_eq!(bus.write16(SRAM + 3, 0), Err(Fault::Unaligned(SRAM + 3)));
}

#[test]
fn narrow_writes_to_a_register_fill_all_lanes_and_narrow_reads_pick_theirs() {
    let mut bus = bus();
    assert_eq!(bus.write8(DMA + 1, 0xab), Ok(()));
    assert_eq!(read(&mut bus, DMA), 0xabab_abab);
    assert_eq!(bus.write16(DMA + 2, 0x1234), Ok(()));
    assert_eq!(bus.read16(DMA), Ok(0x1234));
    write(&mut bus, DMA, 0x4433_2211);
    assert_eq!(bus.read8(DMA + 2), Ok(0x33));
    assert_eq!(bus.read16(DMA + 2), Ok(0x4433));
}

#[test]
fn the_missing_rom_and_flash_streams_are_reported() {
    let mut bus = bus();
    assert_eq!(read(&mut bus, 0x1018), 0);
    write(&mut bus, 0x1400_0014, 1);
    assert_eq!(reports(&bus), ["Read of 0x00001018: NotModelled x1", "Write of 0x14000014: NotModelled x1"]);
    assert_eq!(bus.fetch(0x1018), None, "and cannot be executed");
    assert_eq!(bus.read32(0x6000_0000), Err(Fault::Bus(0x6000_0000)));
    assert_ne!(read(&mut bus, RESETS + 8), 0);
}
