//! A debug probe at the chip.

use crate::common::*;
use pneudrive_chip::{Chip, Fault, SEMIHOSTING, Ticks};

const SRAM: u32 = 0x2000_0000;
/// Its exception number.
const HARD_FAULT: usize = 3;
const MS: Ticks = Ticks::from_millis(1);

/// Asks the debugger for operation 0x15 with an argument in RAM, and keeps the result in r4.
fn asking() -> Chip {
    let main = released().load(0, 0x15).load(1, SRAM + 0x100).op(0xbeab).op(0x1c04);
    Chip::from_flash(&flash(main.hang(), &[(HARD_FAULT, Program::new().hang())])).expect("a program")
}

fn released() -> Program {
    Program::new().store(RESETS, 0)
}

#[test]
fn a_breakpoint_halts_until_the_debugger_goes_on() {
    let mut chip = asking();
    chip.attach_debugger();
    chip.run_until(MS);
    assert_eq!(chip.breakpoint(), Some(SEMIHOSTING));
    assert_eq!((chip.register(0), chip.register(1)), (0x15, SRAM + 0x100));
    assert!(chip.write_memory(SRAM + 0x100, b"run"));
    assert_eq!(chip.read_memory(SRAM + 0x102), Some(b'n'));
    assert!(!chip.write_memory(0x1000_0000, b"run"), "flash is no RAM");

    let instructions = chip.instructions();
    chip.run_until(MS * 2);
    assert_eq!(
        (chip.instructions(), chip.now() >= MS * 2),
        (instructions, true),
        "time goes on, the program does not"
    );
    chip.set_register(0, 77);
    chip.resume();
    chip.run_until(MS * 3);
    assert_eq!(chip.breakpoint(), None);
    assert_eq!(chip.register(4), 77);
    assert!(chip.instructions() > instructions + 100);
}

#[test]
fn a_reset_does_not_take_the_debugger_off() {
    let mut chip = asking();
    chip.attach_debugger();
    chip.power_cycle();
    chip.run_until(MS);
    assert_eq!(chip.breakpoint(), Some(SEMIHOSTING));
    assert_eq!(chip.hard_faults(), 0);
}

#[test]
fn without_a_debugger_a_breakpoint_is_a_fault() {
    let mut chip = asking();
    chip.run_until(MS);
    assert_eq!(chip.breakpoint(), None);
    assert_eq!(chip.last_hard_fault().map(|fault| fault.fault), Some(Fault::Breakpoint));
}
