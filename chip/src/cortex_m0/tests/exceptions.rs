//! Exception entry, return, priorities and preemption.

use super::assembler::{BX_LR, CPSID, CPSIE, HANG, NOP, SVC, adds, movs, mrs, msr, pop, push};
use super::{CODE, Machine, STACK, VECTORS, handler};

const IRQ_0: u32 = 16;
const IRQ_1: u32 = 17;
const SVCALL: u32 = 11;
const PENDSV: u32 = 14;

/// Names of special registers.
const IPSR: u16 = 5;
const MSP: u16 = 8;
const PSP: u16 = 9;
const CONTROL: u16 = 20;

#[test]
fn entry_pushes_the_frame_and_return_restores_it() {
    let mut machine = Machine::new(&[movs(0, 7), movs(1, 8), NOP, NOP]);
    machine.load(handler(IRQ_0), &[movs(0, 99), movs(1, 99), BX_LR]);
    machine.enable_interrupt(0, 0);
    machine.steps(2);
    machine.core.r[12] = 0x1212_1212;
    machine.core.r[14] = 0x1414_1414;
    machine.core.set_apsr(0xa000_0000);
    machine.pend(0);

    machine.step();
    assert_eq!(machine.pc(), handler(IRQ_0));
    assert_eq!(machine.core.ipsr, IRQ_0);
    assert_eq!(machine.core.r[14], 0xffff_fff9, "return to thread mode, main stack");
    let frame = STACK - 32;
    assert_eq!(machine.core.r[13], frame);
    let words: Vec<u32> = (0..8).map(|i| machine.word(frame + 4 * i)).collect();
    assert_eq!(words[..2], [7, 8]);
    assert_eq!(words[4..], [0x1212_1212, 0x1414_1414, CODE + 4, 0xa100_0000]);

    machine.steps(3);
    assert_eq!(machine.pc(), CODE + 4);
    assert_eq!(machine.core.r[..2], [7, 8]);
    assert_eq!(machine.core.r[14], 0x1414_1414);
    assert_eq!(machine.core.r[13], STACK);
    assert_eq!(machine.core.apsr(), 0xa000_0000);
    assert_eq!(machine.core.ipsr, 0);
}

#[test]
fn the_frame_is_aligned_to_eight_bytes() {
    let mut machine = Machine::new(&[push(1), NOP]);
    machine.load(handler(IRQ_0), &[BX_LR]);
    machine.enable_interrupt(0, 0);
    machine.step();
    assert_eq!(machine.core.r[13], STACK - 4);
    machine.pend(0);
    machine.step();
    assert_eq!(machine.core.r[13], STACK - 40, "four bytes of padding");
    assert_eq!(machine.word(STACK - 40 + 28) >> 9 & 1, 1, "remembered in the stacked xPSR");
    machine.step();
    assert_eq!(machine.core.r[13], STACK - 4);
}

#[test]
fn a_more_urgent_interrupt_preempts_and_a_less_urgent_one_waits() {
    let mut machine = Machine::new(&[NOP, NOP, NOP]);
    machine.load(handler(IRQ_0), &[NOP, NOP, BX_LR]);
    machine.load(handler(IRQ_1), &[NOP, BX_LR]);
    machine.load(handler(18), &[NOP, BX_LR]);
    machine.enable_interrupt(0, 2);
    machine.enable_interrupt(1, 1);
    machine.enable_interrupt(2, 3);
    machine.pend(0);
    machine.step();
    assert_eq!(machine.pc(), handler(IRQ_0));
    machine.step();
    machine.pend(1);
    machine.pend(2);
    machine.step();
    assert_eq!(machine.pc(), handler(IRQ_1), "preempts");
    assert_eq!(machine.core.r[14], 0xffff_fff1, "return to handler mode");
    machine.steps(2);
    assert_eq!((machine.pc(), machine.core.ipsr), (handler(IRQ_0) + 2, IRQ_0), "back in the first handler");
    machine.steps(2);
    assert_eq!((machine.pc(), machine.core.ipsr), (CODE, 0), "thread mode for the moment");
    machine.step();
    assert_eq!(machine.pc(), handler(18), "then the one that waited");
    assert_eq!(machine.core.counters.exceptions[16..19], [1, 1, 1]);
}

#[test]
fn equal_priorities_do_not_preempt_and_the_lower_number_goes_first() {
    let mut machine = Machine::new(&[NOP]);
    machine.load(handler(IRQ_0), &[BX_LR]);
    machine.load(handler(IRQ_1), &[NOP, BX_LR]);
    machine.enable_interrupt(0, 1);
    machine.enable_interrupt(1, 1);
    machine.pend(1);
    machine.step();
    assert_eq!(machine.core.ipsr, IRQ_1);
    machine.pend(0);
    machine.step();
    assert_eq!(machine.core.ipsr, IRQ_1, "not preempted");
    machine.pend(1);
    machine.steps(2);
    assert_eq!(machine.core.ipsr, IRQ_0, "of two pending ones");
}

#[test]
fn primask_holds_interrupts_back_until_it_is_cleared() {
    let mut machine = Machine::new(&[CPSID, NOP, NOP, CPSIE, NOP]);
    machine.load(handler(IRQ_0), &[BX_LR]);
    machine.enable_interrupt(0, 0);
    machine.step();
    machine.pend(0);
    machine.steps(3);
    assert_eq!((machine.pc(), machine.core.ipsr), (CODE + 8, 0));
    machine.step();
    assert_eq!(machine.core.ipsr, IRQ_0, "before the next instruction");
}

#[test]
fn an_interrupt_pended_in_its_own_handler_runs_again() {
    let mut machine = Machine::new(&[NOP, NOP]);
    machine.load(handler(IRQ_0), &[adds(7, 1), BX_LR]);
    machine.enable_interrupt(0, 0);
    machine.pend(0);
    machine.steps(2);
    machine.pend(0);
    machine.step();
    assert_eq!(machine.core.ipsr, 0);
    machine.step();
    assert_eq!(machine.core.ipsr, IRQ_0);
}

#[test]
fn a_disabled_interrupt_stays_pending() {
    let mut machine = Machine::new(&[NOP, NOP]);
    machine.pend(5);
    machine.step();
    assert_eq!(machine.core.ipsr, 0);
    assert_eq!(machine.read_scs(0x280), 1 << 5);
    machine.write_scs(0x280, 1 << 5);
    assert_eq!(machine.read_scs(0x200), 0);
}

#[test]
fn a_line_that_is_high_at_reset_is_pending() {
    let mut machine = Machine::new(&[NOP]);
    // TIMER INTF forces TIMER_IRQ_1, out of reset.
    machine.bus.write32(0x4000_c000, 0).expect("RESETS");
    machine.bus.write32(0x4005_403c, 2).expect("TIMER");
    machine.core.reset(&mut machine.bus, VECTORS);
    assert_eq!(machine.read_scs(0x200), 2);
}

#[test]
fn a_line_still_high_at_the_return_brings_the_handler_back() {
    let mut machine = Machine::new(&[NOP, NOP]);
    machine.load(handler(IRQ_1), &[BX_LR]);
    machine.enable_interrupt(1, 0);
    machine.bus.write32(0x4000_c000, 0).expect("RESETS");
    machine.bus.write32(0x4005_403c, 2).expect("TIMER");
    machine.steps(3);
    assert_eq!(machine.core.ipsr, IRQ_1, "entered again after the return");
    assert_eq!(machine.core.counters.exceptions[17], 2);
    machine.bus.write32(0x4005_403c, 0).expect("TIMER");
    machine.steps(3);
    assert_eq!(machine.core.counters.exceptions[17], 2, "the line is low");
}

#[test]
fn svc_is_taken_at_once_and_returns_behind_itself() {
    let mut machine = Machine::new(&[SVC, NOP]);
    machine.load(handler(SVCALL), &[BX_LR]);
    machine.step();
    assert_eq!((machine.pc(), machine.core.ipsr), (handler(SVCALL), SVCALL));
    machine.step();
    assert_eq!(machine.pc(), CODE + 2);
    assert_eq!(machine.core.counters.hard_faults, 0);
}

#[test]
fn pendsv_is_set_by_icsr_and_waits_for_more_urgent_handlers() {
    let mut machine = Machine::new(&[NOP, NOP]);
    machine.load(handler(IRQ_0), &[NOP, BX_LR]);
    machine.load(handler(PENDSV), &[BX_LR]);
    machine.write_scs(0xd20, 3 << 22);
    machine.enable_interrupt(0, 0);
    machine.pend(0);
    machine.step();
    machine.write_scs(0xd04, 1 << 28);
    assert_eq!(machine.read_scs(0xd04), 1 << 28 | PENDSV << 12 | IRQ_0);
    machine.steps(2);
    assert_eq!(machine.core.ipsr, 0);
    machine.step();
    assert_eq!(machine.core.ipsr, PENDSV);
    assert_eq!(machine.read_scs(0xd04) >> 28 & 1, 0, "no longer pending");
}

#[test]
fn thread_mode_can_use_the_process_stack_and_handlers_use_the_main_stack() {
    let process_stack = STACK - 0x1000;
    let mut program = Vec::new();
    program.extend(msr(PSP, 0));
    program.extend(msr(CONTROL, 1));
    program.extend([NOP]);
    program.extend(mrs(2, MSP));
    let mut machine = Machine::new(&program);
    machine.load(handler(IRQ_0), &[push(0x10), pop(0x10), BX_LR]);
    machine.core.r[0] = process_stack;
    machine.core.r[1] = 2;
    machine.steps(3);
    assert_eq!(machine.core.r[13], process_stack);
    machine.enable_interrupt(0, 0);
    machine.pend(0);
    machine.step();
    assert_eq!(machine.core.r[14], 0xffff_fffd, "return to thread mode, process stack");
    assert_eq!(machine.core.r[13], STACK, "the frame is on the process stack");
    machine.steps(3);
    assert_eq!(machine.core.r[13], process_stack);
    machine.step();
    assert_eq!(machine.core.r[2], STACK);
}

#[test]
fn ipsr_is_readable_and_lr_of_a_nested_call_survives_pop_pc() {
    let mut program = vec![push(0x100)];
    program.extend(mrs(3, IPSR));
    program.extend([pop(0x100), HANG]);
    let mut machine = Machine::new(&[NOP, NOP]);
    machine.load(handler(IRQ_1), &program);
    machine.enable_interrupt(1, 0);
    machine.pend(1);
    machine.steps(3);
    assert_eq!(machine.core.r[3], IRQ_1);
    machine.step();
    assert_eq!((machine.pc(), machine.core.ipsr), (CODE, 0), "POP {{PC}} of EXC_RETURN returns");
}
