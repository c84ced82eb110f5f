//! HardFaults and lockup.

use super::assembler::{BKPT, BX_LR, CPSID, HANG, NOP, SVC, UDF, ldr, movs, str};
use super::{CODE, Machine, handler};
use crate::cortex_m0::Activity;
use crate::report::Fault;

const HARD_FAULT: u32 = 3;

/// Executes one instruction with r0 and r1 set and tells the fault it took, if any.
fn fault_of(opcode: u16, r0: u32, r1: u32) -> Option<Fault> {
    let mut machine = Machine::new(&[opcode]);
    machine.core.r[0] = r0;
    machine.core.r[1] = r1;
    machine.step();
    let fault = machine.core.counters.last_hard_fault;
    if let Some(fault) = fault {
        assert_eq!((machine.pc(), machine.core.ipsr), (handler(HARD_FAULT), HARD_FAULT));
        assert_eq!(fault.pc, CODE);
        assert_eq!(
            machine.word(machine.core.r[13] + 24),
            CODE,
            "the stacked PC is the faulting instruction's"
        );
    }
    fault.map(|f| f.fault)
}

#[test]
fn every_kind_of_fault_is_told() {
    assert_eq!(fault_of(NOP, 0, 0), None);
    assert_eq!(fault_of(UDF, 0, 0), Some(Fault::UndefinedInstruction));
    assert_eq!(
        fault_of(0xb900, 0, 0),
        Some(Fault::UndefinedInstruction),
        "a hole in the miscellaneous class"
    );
    assert_eq!(fault_of(0xe800, 0, 0), Some(Fault::UndefinedInstruction), "Thumb-2 only");
    assert_eq!(fault_of(BKPT, 0, 0), Some(Fault::Breakpoint));
    assert_eq!(fault_of(ldr(1, 0, 0), 0x2000_0002, 0), Some(Fault::Unaligned(0x2000_0002)));
    assert_eq!(fault_of(str(1, 0, 0), 0x2000_0001, 0), Some(Fault::Unaligned(0x2000_0001)));
    assert_eq!(fault_of(ldr(1, 0, 0), 0x3000_0000, 0), Some(Fault::Bus(0x3000_0000)));
    assert_eq!(fault_of(ldr(1, 0, 0), 0x2004_2000, 0), Some(Fault::Bus(0x2004_2000)), "behind the SRAM");
    assert_eq!(fault_of(str(1, 0, 0), 0x1100_0000, 0), Some(Fault::Bus(0x1100_0000)), "flash is not written");
    assert_eq!(fault_of(0x4700, 0x2000_1000, 0), Some(Fault::InvalidState), "BX without the Thumb bit");
}

#[test]
fn a_faulting_load_leaves_its_register_alone() {
    let mut machine = Machine::new(&[ldr(1, 0, 0)]);
    machine.core.r[0] = 0x3000_0000;
    machine.core.r[1] = 0x55;
    machine.step();
    assert_eq!(machine.core.r[1], 0x55);
}

#[test]
fn svc_with_interrupts_masked_is_a_fault() {
    let mut machine = Machine::new(&[CPSID, SVC]);
    machine.steps(2);
    assert_eq!(machine.core.counters.last_hard_fault.map(|f| f.fault), Some(Fault::SupervisorCall));
}

#[test]
fn a_fault_in_the_hard_fault_handler_locks_the_core_up() {
    let mut machine = Machine::new(&[UDF]);
    machine.load(handler(HARD_FAULT), &[UDF]);
    machine.steps(2);
    assert_eq!(machine.core.activity(), Activity::LockedUp);
    machine.enable_interrupt(0, 0);
    machine.pend(0);
    assert!(!machine.core.try_wake(&mut machine.bus), "no interrupt helps");
}

#[test]
fn a_stack_outside_memory_locks_the_core_up() {
    let mut machine = Machine::new(&[UDF]);
    machine.core.r[13] = 0x1000_0000;
    machine.step();
    assert_eq!(machine.core.activity(), Activity::LockedUp);
    assert_eq!(machine.core.counters.last_hard_fault.map(|f| f.fault), Some(Fault::Bus(0x0fff_ffe0)));
}

#[test]
fn returning_from_a_fault_goes_on_where_the_handler_says() {
    let mut machine = Machine::new(&[UDF, movs(4, 9), HANG]);
    // The handler steps over the two bytes of UDF in the stacked PC: LDR r0, [SP, #24]; ADDS r0,
    // #2; STR.
    machine.load(handler(HARD_FAULT), &[0x9806, 0x3002, 0x9006, BX_LR]);
    machine.steps(6);
    assert_eq!(machine.core.r[4], 9);
}
