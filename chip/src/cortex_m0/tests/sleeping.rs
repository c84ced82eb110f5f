//! WFE, WFI, SEV and what wakes from them.

use super::assembler::{BX_LR, CPSID, NOP, SEV, WFE, WFI};
use super::{CODE, Machine, handler};
use crate::cortex_m0::Activity;

fn wakes(machine: &mut Machine) -> bool {
    machine.core.try_wake(&mut machine.bus)
}

#[test]
fn wfe_consumes_an_event_instead_of_sleeping() {
    let mut machine = Machine::new(&[SEV, WFE, WFE, NOP]);
    machine.steps(2);
    assert_eq!(machine.core.activity(), Activity::Running);
    machine.step();
    assert_eq!(machine.core.activity(), Activity::WaitingForEvent);
    assert!(!wakes(&mut machine));
}

#[test]
fn a_pending_interrupt_wakes_wfe_and_is_then_taken() {
    let mut machine = Machine::new(&[WFE, NOP]);
    machine.load(handler(16), &[BX_LR]);
    machine.enable_interrupt(0, 0);
    machine.step();
    assert!(!wakes(&mut machine));
    machine.pend(0);
    assert!(wakes(&mut machine));
    machine.step();
    assert_eq!(machine.pc(), handler(16));
}

#[test]
fn an_exception_return_is_an_event() {
    let mut machine = Machine::new(&[NOP, WFE, WFE]);
    machine.load(handler(16), &[BX_LR]);
    machine.enable_interrupt(0, 0);
    machine.pend(0);
    machine.steps(4);
    assert_eq!(
        (machine.pc(), machine.core.activity()),
        (CODE + 4, Activity::Running),
        "first WFE falls through"
    );
    machine.step();
    assert_eq!(machine.core.activity(), Activity::WaitingForEvent);
}

#[test]
fn with_primask_set_wfi_wakes_without_the_handler_and_wfe_sleeps_on() {
    let mut machine = Machine::new(&[CPSID, WFI, NOP]);
    machine.enable_interrupt(0, 0);
    machine.steps(2);
    machine.pend(0);
    assert!(wakes(&mut machine));
    machine.step();
    assert_eq!((machine.pc(), machine.core.ipsr), (CODE + 6, 0), "goes on behind WFI");

    let mut machine = Machine::new(&[CPSID, WFE, NOP]);
    machine.enable_interrupt(0, 0);
    machine.steps(2);
    machine.pend(0);
    assert!(!wakes(&mut machine));
}

#[test]
fn with_sevonpend_even_a_disabled_interrupt_wakes_wfe() {
    let mut machine = Machine::new(&[WFE, NOP]);
    machine.step();
    machine.write_scs(0xd10, 1 << 4);
    machine.pend(3);
    assert!(wakes(&mut machine));

    let mut machine = Machine::new(&[WFE, NOP]);
    machine.step();
    machine.pend(3);
    assert!(!wakes(&mut machine), "not without SEVONPEND");
}
