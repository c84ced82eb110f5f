//! ELF files, good and bad, and the RTT log.

use crate::common::{Program, STACK, elf, flash};
use pneudrive_chip::{Chip, ElfError, ResetReason, Ticks};

const FLASH: u32 = 0x1000_0000;
const RTT: u32 = 0x2000_0100;

fn error(file: &[u8]) -> ElfError {
    Chip::from_elf(file).expect_err("this file cannot run")
}

#[test]
fn segments_are_loaded_by_physical_address_and_the_program_starts_from_its_vector() {
    let program = flash(Program::new().load(0, 0x1234_5678).hang(), &[]);
    let (boot2, rest) = program.split_at(0x100);
    let mut chip = Chip::from_elf(&elf(&[(FLASH, boot2), (FLASH + 0x100, rest)], &[])).expect("runs");
    assert_eq!(chip.program_counter(), 0x1000_0200);
    assert_eq!(chip.lowest_stack_pointer(), STACK);
    assert_eq!(chip.resets().len(), 1);
    assert_eq!((chip.resets()[0].at, chip.resets()[0].reason), (Ticks::ZERO, ResetReason::PowerOn));
    chip.run_until(Ticks::from_micros(10));
    // Stack pointer, vector and first instruction come from flash, 50 cycles of 6.5 MHz each, and
    // nothing is cut.
    assert!(chip.now() >= Ticks::from_micros(10) && chip.now() < Ticks::from_micros(10 + 3 * 8));
    assert_eq!(chip.hard_faults(), 0);
}

#[test]
fn errors_tell_what_is_wrong() {
    let good = flash(Program::new().hang(), &[]);
    assert!(matches!(error(b"not an ELF file"), ElfError::Malformed(_)));
    let file = elf(&[(FLASH, &good)], &[]);
    assert!(matches!(error(&file[..200]), ElfError::Malformed(_)), "cut off");

    let mut x86 = file.clone();
    x86[18] = 62;
    assert!(matches!(error(&x86), ElfError::NotAnArmExecutable { machine: 62, kind: 2 }));
    let mut relocatable = file.clone();
    relocatable[16] = 1;
    assert!(matches!(error(&relocatable), ElfError::NotAnArmExecutable { machine: 40, kind: 1 }));

    let elsewhere = error(&elf(&[(0x0800_0000, &good)], &[]));
    assert!(matches!(elsewhere, ElfError::SegmentOutsideMemory { address: 0x0800_0000, .. }));
    assert_eq!(
        elsewhere.to_string(),
        format!(
            "segment of {} bytes at 0x08000000 lies outside flash and SRAM; is memory.x the RP2040's?",
            good.len()
        )
    );
    assert!(matches!(error(&elf(&[(FLASH, &good[..0x100])], &[])), ElfError::NoVectorTable));
    let mut blank = good;
    blank[0x100..0x108].fill(0xff);
    assert!(matches!(
        error(&elf(&[(FLASH, &blank)], &[])),
        ElfError::BadVectorTable { stack_pointer: 0xffff_ffff, entry: 0xffff_ffff }
    ));
}

/// The program reads its own last word, of which the image has half: LDR r1, [r0]; STR r1, [r2].
#[test]
fn the_last_word_of_flash_is_read_also_if_it_is_not_whole() {
    const SRAM: u32 = 0x2000_0000;
    let program = Program::new().load(0, FLASH + 0x220).load(2, SRAM).op(0x6801).op(0x6011).hang();
    let image = flash(program, &[]);
    assert_eq!(image.len(), 0x222);
    let mut chip = Chip::from_flash(&image).expect("runs");
    chip.run_until(Ticks::from_millis(1));
    let word = [0, 1, 2, 3].map(|n| chip.read_memory(SRAM + n));
    assert_eq!(word, [0xfe, 0xe7, 0xff, 0xff].map(Some));
}

/// A boot loader that leaves through its own vector, and one whose checksum is wrong.
#[test]
fn the_boot_loader_runs_if_its_checksum_is_right() {
    let program = flash(Program::new().load(0, 0x1234_5678).hang(), &[]);
    let mut block = vec![0; 0x100];
    let code = Program::new().load(0, 0x1000_0201).op(0x4700);
    for (bytes, opcode) in block.chunks_mut(2).zip(code.0) {
        bytes.copy_from_slice(&opcode.to_le_bytes());
    }
    let file = |block: &[u8]| elf(&[(FLASH, block), (FLASH + 0x100, &program[0x100..])], &[]);
    let ElfError::BadBootBlock { found: 0, expected } = error(&file(&block)) else {
        panic!("accepted without a checksum")
    };
    block[0xfc..].copy_from_slice(&expected.to_le_bytes());
    let mut chip = Chip::from_elf(&file(&block)).expect("runs");
    assert_eq!(chip.program_counter(), 0x2004_1f00, "copied to SRAM");
    chip.run_until(Ticks::from_millis(1));
    assert_eq!((chip.program_counter() & !0xff, chip.hard_faults()), (0x1000_0200, 0));
}

/// A control block with one up channel of 16 bytes behind it.
fn control_block(read: u32, written: u32, buffer: &[u8; 16]) -> Vec<u8> {
    let mut block = b"SEGGER RTT\0\0\0\0\0\0".to_vec();
    for word in [1, 1, 0, RTT + 48, 16, written, read, 0] {
        block.extend(u32::to_le_bytes(word));
    }
    block.resize(48, 0);
    block.extend(buffer);
    block
}

#[test]
fn the_log_is_taken_out_once_and_around_the_end_of_its_buffer() {
    let program = flash(Program::new().store(RTT + 24 + 12, 5).hang(), &[]);
    let block = control_block(14, 2, b"cdefghijklmnopab");
    let file = elf(&[(FLASH, &program), (RTT, &block)], &[("other", 1), ("_SEGGER_RTT", RTT)]);
    let mut chip = Chip::from_elf(&file).expect("runs");
    assert_eq!(chip.take_rtt(), b"abcd");
    assert_eq!(chip.take_rtt(), b"");
    assert_eq!(chip.read_memory(RTT + 24 + 16), Some(2), "the program sees that there is room again");
    chip.run_until(Ticks::from_micros(100));
    assert_eq!(chip.take_rtt(), b"efg", "the program has moved the write offset to 5");
}

#[test]
fn a_control_block_that_is_not_there_yet_gives_nothing() {
    let program = flash(Program::new().hang(), &[]);
    let mut chip = Chip::from_elf(&elf(&[(FLASH, &program)], &[("_SEGGER_RTT", RTT)])).expect("runs");
    assert_eq!(chip.take_rtt(), b"");
    let mut without_symbol = Chip::from_elf(&elf(&[(FLASH, &program)], &[])).expect("runs");
    assert_eq!(without_symbol.take_rtt(), b"");
}
