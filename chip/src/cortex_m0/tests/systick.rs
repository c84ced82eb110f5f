//! SysTick as software sees it.

use super::Machine;
use super::assembler::{BX_LR, NOP};
use super::handler;
use crate::ticks::Ticks;

const SYST_CSR: u32 = 0x10;
const SYST_RVR: u32 = 0x14;
const SYST_CVR: u32 = 0x18;
const ENABLE_FROM_PROCESSOR_CLOCK: u32 = 0b101;
const WITH_INTERRUPT: u32 = 0b111;

/// The first tick at which `cycles` cycles of the ring oscillator (6.5 MHz) are over.
fn cycles(cycles: u64) -> Ticks {
    Ticks::new((cycles * 125_000_000).div_ceil(6_500_000))
}

fn started(reload: u32, control: u32) -> Machine {
    let mut machine = Machine::new(&[NOP; 8]);
    machine.write_scs(SYST_RVR, reload);
    machine.write_scs(SYST_CVR, 0);
    machine.write_scs(SYST_CSR, control);
    machine
}

#[test]
fn it_reloads_on_the_first_count_and_then_counts_down() {
    let mut machine = started(100, ENABLE_FROM_PROCESSOR_CLOCK);
    let start = machine.bus.now;
    for (elapsed, value) in [(0, 0), (1, 100), (2, 99), (100, 1), (101, 0), (102, 100), (202, 0)] {
        machine.bus.now = start + cycles(elapsed);
        assert_eq!(machine.read_scs(SYST_CVR), value, "after {elapsed} cycles");
    }
}

#[test]
fn countflag_tells_once_that_zero_was_passed() {
    let mut machine = started(100, ENABLE_FROM_PROCESSOR_CLOCK);
    machine.pass(cycles(100));
    assert_eq!(machine.read_scs(SYST_CSR) >> 16, 0);
    machine.pass(cycles(1));
    assert_eq!(machine.read_scs(SYST_CSR) >> 16, 1);
    assert_eq!(machine.read_scs(SYST_CSR) >> 16, 0, "cleared by the read");
}

#[test]
fn the_exception_comes_once_every_reload_plus_one() {
    let mut machine = started(999, WITH_INTERRUPT);
    machine.load(handler(15), &[BX_LR]);
    let start = machine.bus.now;
    for n in 1..5 {
        let due = machine.core.next_event();
        assert_eq!(due, start + cycles(1000 * n));
        machine.bus.now = due;
        machine.core.advance(&mut machine.bus);
        machine.steps(2);
        assert_eq!(machine.core.counters.exceptions[15], n);
    }
}

#[test]
fn writing_cvr_starts_over_without_the_exception() {
    let mut machine = started(999, WITH_INTERRUPT);
    machine.pass(cycles(500));
    machine.write_scs(SYST_CVR, 5);
    assert_eq!(machine.read_scs(SYST_CVR), 0, "any value clears");
    assert_eq!(machine.core.next_event(), machine.bus.now + cycles(1000));
}

#[test]
fn without_a_reload_value_it_stands_still() {
    let mut machine = started(0, WITH_INTERRUPT);
    assert_eq!(machine.core.next_event(), Ticks::NEVER);
    machine.pass(Ticks::from_millis(1));
    assert_eq!(machine.read_scs(SYST_CVR), 0);
}
