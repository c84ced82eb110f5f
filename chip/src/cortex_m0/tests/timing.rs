//! Cycle counts (Cortex-M0+ TRM table 3-1, RP2040 datasheet 2.1.3) and the measurement of the
//! stack.

use super::assembler::{BX_LR, CPSIE, HANG, NOP, SEV, WFE, adds, ldr, movs, pop, push, str};
use super::{CODE, DATA, Machine, STACK, handler};

/// Cycles of the last of these instructions, with r0 at `address`.
fn cycles_of(program: &[u16], address: u32) -> u64 {
    let mut machine = Machine::new(program);
    machine.core.r[0] = address;
    machine.core.r[14] = CODE | 1;
    machine.steps(program.len() - 1);
    let before = machine.bus.cycles();
    machine.step();
    assert_eq!(machine.core.counters.hard_faults, 0);
    machine.bus.cycles() - before
}

#[test]
fn instructions_take_the_cycles_of_the_manual() {
    for one in [NOP, SEV, CPSIE, movs(0, 1), adds(0, 1), 0x4348] {
        assert_eq!(cycles_of(&[one], 0), 1, "{one:#x}");
    }
    assert_eq!(cycles_of(&[ldr(1, 0, 0)], DATA), 2);
    assert_eq!(cycles_of(&[str(1, 0, 0)], DATA), 2);
    assert_eq!(cycles_of(&[push(0x1f0)], 0), 6, "1 + N");
    assert_eq!(cycles_of(&[push(0xf0), pop(0xf0)], 0), 5, "1 + N");
    assert_eq!(cycles_of(&[push(0x1f0), pop(0x1f0)], 0), 8, "3 + N with the PC");
    assert_eq!(cycles_of(&[0xc8f0], DATA), 5, "LDM of four");
    assert_eq!(cycles_of(&[HANG], 0), 2);
    assert_eq!(cycles_of(&[BX_LR], 0), 2);
    assert_eq!(cycles_of(&[movs(1, 0), 0xd0fe], 0), 2, "taken");
    assert_eq!(cycles_of(&[movs(1, 1), 0xd0fe], 0), 1, "not taken");
    assert_eq!(cycles_of(&[WFE], 0), 2);
}

#[test]
fn the_io_port_is_fast_and_apb_is_slow() {
    const SIO_CPUID: u32 = 0xd000_0000;
    const RESETS: u32 = 0x4000_c000;
    const UART0_SET: u32 = 0x4003_6038;
    const DMA_IN_AHB: u32 = 0x5000_0400;
    assert_eq!(cycles_of(&[ldr(1, 0, 0)], SIO_CPUID), 1);
    assert_eq!(cycles_of(&[ldr(1, 0, 0)], RESETS), 4);
    assert_eq!(cycles_of(&[str(1, 0, 0)], RESETS), 5);
    assert_eq!(cycles_of(&[ldr(1, 0, 0)], DMA_IN_AHB), 2);
    assert_eq!(cycles_of(&[str(1, 0, 0)], UART0_SET), 7);
}

#[test]
fn calls_take_three_cycles_and_exception_entry_fifteen() {
    let mut machine = Machine::new(&[0xf000, 0xf800, NOP]);
    machine.step();
    assert_eq!(machine.bus.cycles(), 3);
    machine.enable_interrupt(0, 0);
    machine.pend(0);
    machine.step();
    assert_eq!(machine.pc(), handler(16));
    assert_eq!(machine.bus.cycles(), 18);
}

#[test]
fn the_lowest_stack_pointer_counts_pushes_frames_and_subtractions() {
    let mut machine = Machine::new(&[push(0xff), pop(0xff), 0xb088, NOP, NOP]);
    machine.load(handler(16), &[push(0x100), pop(0x100)]);
    assert_eq!(machine.core.counters.lowest_sp, STACK);
    machine.steps(2);
    assert_eq!(machine.core.counters.lowest_sp, STACK - 32);
    machine.step();
    assert_eq!(machine.core.r[13], STACK - 32);
    machine.enable_interrupt(0, 0);
    machine.pend(0);
    machine.steps(3);
    assert_eq!(machine.core.counters.lowest_sp, STACK - 32 - 32 - 4);
}
