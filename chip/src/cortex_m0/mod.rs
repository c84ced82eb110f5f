//! The Cortex-M0+ core: ARMv6-M (ARM DDI 0419) with the cycle counts of the Cortex-M0+ TRM (ARM DDI
//! 0484).
//!
//! One file per encoding class of the architecture manual's chapter A5, one for each part of the
//! system control space.

mod alu;
mod branch;
mod data_processing;
mod decode;
mod exceptions;
mod kind;
mod load_store;
mod load_store_multiple;
mod miscellaneous;
mod nvic;
mod shift_add;
mod special_data;
mod special_registers;
mod system_control;
mod systick;
mod wide;

#[cfg(test)]
mod tests;

use crate::bus::Bus;
use crate::report::{Fault, HardFault};
use crate::ticks::Ticks;

use exceptions::ActiveExceptions;
use nvic::Nvic;
use systick::SysTick;

/// Register numbers with a role.
const SP: usize = 13;
const LR: usize = 14;
const PC: usize = 15;
/// Cycles of a call of the boot ROM, besides those that the flash chip takes. Not measured: nothing
/// here depends on them.
const ROM_CALL: u32 = 100;

/// Whether the core executes, and if not, what would make it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    Running,
    /// After `WFE`.
    WaitingForEvent,
    /// After `WFI`.
    WaitingForInterrupt,
    /// A HardFault within a HardFault (B1.5.15): only a reset helps.
    LockedUp,
    /// At a breakpoint, with a debugger attached.
    Halted,
}

/// N, Z, C, V of the APSR. N, Z and V are kept as the words from which they follow: nearly all
/// instructions set them, and few look at them.
#[derive(Clone, Copy, Debug, Default)]
struct Flags {
    /// N is the sign.
    negative: u32,
    /// Z is set if this is zero.
    nonzero: u32,
    c: bool,
    /// V is the sign.
    overflow: u32,
}

/// The processor's state.
#[derive(Clone, Debug)]
pub(crate) struct Core {
    /// R0 to R12, the stack pointer in use, LR, and in R15 the address of the next instruction.
    r: [u32; 16],
    flags: Flags,
    /// The stack pointer not in use: PSP while the main stack is, MSP while the process stack is.
    banked_sp: u32,
    /// CONTROL.SPSEL: thread mode uses the process stack.
    process_stack: bool,
    primask: bool,
    /// IPSR: number of the exception being handled, 0 in thread mode.
    ipsr: u32,
    event_register: bool,
    activity: Activity,
    active: ActiveExceptions,
    nvic: Nvic,
    systick: SysTick,
    /// VTOR.
    vector_table: u32,
    /// SCR.SEVONPEND: an interrupt becoming pending is an event, even if it is disabled.
    send_event_on_pending: bool,
    system_reset_requested: bool,
    /// `BKPT` halts.
    debugger_attached: bool,
    /// Number of the last `BKPT` that halted.
    breakpoint: u8,
    counters: Counters,
}

/// Figures for tests and performance pages; they survive resets.
#[derive(Clone, Debug)]
pub(crate) struct Counters {
    pub instructions: u64,
    pub lowest_sp: u32,
    pub hard_faults: u64,
    pub last_hard_fault: Option<HardFault>,
    /// Exceptions entered, by exception number (ARMv6-M B1.5.2).
    pub exceptions: [u64; 48],
}

impl Default for Counters {
    fn default() -> Self {
        Counters {
            instructions: 0,
            lowest_sp: u32::MAX,
            hard_faults: 0,
            last_hard_fault: None,
            exceptions: [0; 48],
        }
    }
}

impl Core {
    /// A core held in reset; [`Core::reset`] starts it.
    pub fn new() -> Core {
        Core {
            r: [0; 16],
            flags: Flags { nonzero: 1, ..Flags::default() },
            banked_sp: 0,
            process_stack: false,
            primask: false,
            ipsr: 0,
            event_register: false,
            activity: Activity::Running,
            active: ActiveExceptions::default(),
            nvic: Nvic::default(),
            systick: SysTick::default(),
            vector_table: 0,
            send_event_on_pending: false,
            system_reset_requested: false,
            debugger_attached: false,
            breakpoint: 0,
            counters: Counters::default(),
        }
    }

    /// Takes the reset exception (B1.5.5) with the vector table at `vector_table`.
    pub fn reset(&mut self, bus: &mut Bus, vector_table: u32) {
        self.restart(bus, vector_table);
        match (bus.read32(vector_table), bus.read32(vector_table + 4)) {
            (Ok(sp), Ok(entry)) => {
                self.set_sp(sp & !3);
                self.r[PC] = entry & !1;
            }
            _ => self.activity = Activity::LockedUp,
        }
    }

    /// Goes on at `entry` as after a reset, with nothing returned to: where the boot ROM has come
    /// to.
    pub fn start_at(&mut self, bus: &mut Bus, entry: u32, stack_pointer: u32) {
        self.restart(bus, 0);
        self.set_sp(stack_pointer);
        self.r[PC] = entry & !1;
    }

    fn restart(&mut self, bus: &mut Bus, vector_table: u32) {
        let counters = std::mem::take(&mut self.counters);
        let debugger_attached = self.debugger_attached;
        *self = Core { counters, vector_table, debugger_attached, ..Core::new() };
        bus.take_interrupt_edges();
        self.nvic.pending = bus.interrupt_lines();
        bus.notice_interrupts();
    }

    pub fn activity(&self) -> Activity {
        self.activity
    }

    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    pub fn counters_mut(&mut self) -> &mut Counters {
        &mut self.counters
    }

    /// Address of the next instruction.
    pub fn pc(&self) -> u32 {
        self.r[PC]
    }

    /// Register `number` (0 to 14; 15 is the address of the next instruction).
    pub fn register(&self, number: usize) -> u32 {
        self.r[number]
    }

    /// Changes R0 to R12.
    pub fn set_register(&mut self, number: usize, value: u32) {
        self.r[..SP][number] = value;
    }

    pub fn attach_debugger(&mut self) {
        self.debugger_attached = true;
    }

    /// The number of the breakpoint at which it has halted.
    pub fn breakpoint(&self) -> Option<u8> {
        (self.activity == Activity::Halted).then_some(self.breakpoint)
    }

    /// Goes on behind a breakpoint.
    pub fn resume(&mut self, bus: &mut Bus) {
        if self.activity == Activity::Halted {
            self.activity = Activity::Running;
            bus.notice_interrupts();
        }
    }

    /// True once after AIRCR.SYSRESETREQ was written.
    pub fn take_system_reset_request(&mut self) -> bool {
        std::mem::take(&mut self.system_reset_requested)
    }

    /// When SysTick next reaches zero with its interrupt enabled.
    pub fn next_event(&self) -> Ticks {
        self.systick.next_interrupt()
    }

    /// Does what is due at the bus's time: at present only the SysTick exception becoming pending.
    pub fn advance(&mut self, bus: &mut Bus) {
        if self.systick.advance(bus.now) {
            self.nvic.set_systick_pending(true);
            bus.notice_interrupts();
        }
    }

    /// The processor clock or the 1 us tick has changed.
    pub fn reclock(&mut self, bus: &Bus) {
        self.systick.restart(bus);
    }

    /// Executes instructions, and enters the exceptions that become pending, until `limit` or until
    /// something else is due: a peripheral's event, or a look at the core. An instruction is never
    /// cut.
    pub fn run(&mut self, bus: &mut Bus, limit: Ticks) {
        bus.let_core_run(limit);
        loop {
            // Counted here and not in `self`: that is memory, which every instruction would change.
            let mut executed = 0;
            while bus.core_runs() {
                executed += u64::from(self.execute(bus));
            }
            self.counters.instructions += executed;
            self.catch_up(bus);
            // Between two instructions, unless something is due first.
            if bus.now >= limit.min(bus.next_event()) || bus.core_paused() {
                return;
            }
            if bus.interrupts_changed() {
                self.take_pending_exception(bus);
            } else {
                bus.let_core_run(limit);
            }
        }
    }

    /// Executes one instruction or enters one exception.
    #[cfg(test)]
    pub fn step(&mut self, bus: &mut Bus) {
        if !(bus.interrupts_changed() && self.take_pending_exception(bus)) {
            self.counters.instructions += u64::from(self.execute(bus));
        }
        self.catch_up(bus);
    }

    /// Makes [`Bus::now`] the time at which the core is, after what it has executed and the waits
    /// for flash in it.
    fn catch_up(&mut self, bus: &mut Bus) {
        bus.spend_waits();
        bus.catch_up();
    }

    /// Executes one instruction, and spends its cycles but those of waiting for flash. Returns
    /// whether there was one.
    #[inline]
    fn execute(&mut self, bus: &mut Bus) -> bool {
        let pc = self.r[PC];
        let Some(opcode) = bus.fetch_at_once(pc) else {
            self.wait_or_fault(bus, pc);
            return false;
        };
        self.r[PC] = pc.wrapping_add(2);
        match decode::execute(self, bus, opcode) {
            Ok(cycles) => bus.spend_cycles(cycles),
            Err(fault) => self.hard_fault(bus, pc, fault),
        }
        true
    }

    /// There is no instruction at `pc`, not yet or never.
    #[cold]
    fn wait_or_fault(&mut self, bus: &mut Bus, pc: u32) {
        if bus.must_wait() {
            // Time goes on first; the instruction is there when the core comes back.
        } else if let Some(result) = bus.call_rom(pc, [self.r[0], self.r[1], self.r[2], self.r[3]]) {
            self.return_from_rom(bus, pc, result);
        } else {
            self.hard_fault(bus, pc, Fault::Bus(pc));
        }
    }

    /// A function of the boot ROM has been called and returns.
    fn return_from_rom(&mut self, bus: &mut Bus, pc: u32, result: Result<u32, Fault>) {
        match result {
            Ok(value) => {
                self.r[0] = value;
                self.r[PC] = self.r[LR] & !1;
                bus.spend_cycles(ROM_CALL);
            }
            Err(fault) => self.hard_fault(bus, pc, fault),
        }
    }

    /// The value an instruction reads from the PC: its own address + 4 (A5.1.2).
    #[inline]
    fn pc_operand(&self) -> u32 {
        self.r[PC].wrapping_add(2)
    }

    #[inline]
    fn set_sp(&mut self, value: u32) {
        self.r[SP] = value;
        if value < self.counters.lowest_sp {
            self.counters.lowest_sp = value;
        }
    }
}

/// Three bits of an opcode as the number of a low register.
#[inline]
fn low(opcode: u16, shift: u32) -> usize {
    usize::from(opcode >> shift & 7)
}

/// What every instruction returns: its cycles, or why it could not be completed.
type Outcome = Result<u32, Fault>;
