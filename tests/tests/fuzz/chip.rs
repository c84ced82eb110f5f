use super::mutation::contents;
use super::scripts;
use bolero::check;
use elf_maker::elf;
use pneudrive_chip::{Chip, Ticks};

#[allow(dead_code, reason = "of what makes programs, only the one that makes files")]
#[path = "../../../chip/tests/common/mod.rs"]
mod elf_maker;

/// A program as small as they come: a boot block, a vector table, a word into SRAM, symbols.
fn program() -> Vec<u8> {
    let code = [0x2000_1000_u32, 0x1000_0109, 0xE7FE_BF00, 0xBF30_E7FD].map(u32::to_le_bytes).concat();
    let names = [("other", 1), ("_SEGGER_RTT", 0x2000_0000)];
    elf(&[(0x1000_0000, &[0; 0x100]), (0x1000_0100, &code), (0x2000_0000, b"SEGGER RTT")], &names)
}

/// A file is refused, or is a program; and a program may do what it likes.
#[test]
fn elf_files() {
    let program = program();
    assert!(Chip::from_elf(&program).is_ok());
    check!().with_iterations(5_000).with_generator(scripts(48)).for_each(|script: &Vec<u8>| {
        let Ok(mut chip) = Chip::from_elf(&contents(&program, script)) else { return };
        chip.run_until(Ticks::from_micros(20));
        assert!(chip.now() >= Ticks::from_micros(20));
    });
}

/// Any instructions at all.
#[test]
fn flash_contents() {
    check!().with_iterations(5_000).with_generator(scripts(256)).for_each(|code: &Vec<u8>| {
        let mut flash = vec![0; 0x100];
        flash.extend([0x00, 0x10, 0x00, 0x20, 0xC1, 0x01, 0x00, 0x10]);
        flash.resize(0x1C0, 0);
        flash.extend(code);
        let mut chip = Chip::from_flash(&flash).unwrap();
        chip.run_until(Ticks::from_micros(30));
        assert!(chip.now() >= Ticks::from_micros(30));
    });
}
