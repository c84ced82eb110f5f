//! Exception entry, return and priorities (B1.5), and waking from WFE and WFI (B1.5.17 to B1.5.19).

use super::{Activity, Core, LR, Outcome, PC, SP};
use crate::bus::Bus;
use crate::report::{Fault, HardFault};

pub(super) const HARD_FAULT: u32 = 3;
pub(super) const SVCALL: u32 = 11;
pub(super) const PENDSV: u32 = 14;
pub(super) const SYSTICK: u32 = 15;
/// Exception number of interrupt 0.
pub(super) const FIRST_INTERRUPT: u32 = 16;

/// Cycles from the interrupt to the first instruction of its handler with zero wait states, as the
/// TRM gives them.
const ENTRY_CYCLES: u32 = 15;
/// Cycles of unstacking, on top of those of the returning instruction. The TRM gives no figure;
/// this one is the eight loads of the frame and a pipeline refill. Tail-chaining, which would save
/// cycles, is not modelled.
const RETURN_CYCLES: u32 = 10;

/// Priority of thread mode: less urgent than any exception's.
const THREAD_PRIORITY: i16 = 256;

/// EXC_RETURN (table B1-8).
const RETURN_TO_HANDLER: u32 = 0xffff_fff1;
const RETURN_TO_THREAD_MAIN: u32 = 0xffff_fff9;
const RETURN_TO_THREAD_PROCESS: u32 = 0xffff_fffd;

/// The exceptions being handled, outermost first. Four priorities and the fixed ones bound the
/// depth.
#[derive(Clone, Debug, Default)]
pub(super) struct ActiveExceptions(Vec<u32>);

impl Core {
    /// ExecutionPriority (B1.5.4), without PRIMASK: of the most urgent exception being handled.
    fn active_priority(&self) -> i16 {
        self.active.0.iter().map(|e| self.nvic.priority(*e)).min().unwrap_or(THREAD_PRIORITY)
    }

    /// ExecutionPriority: PRIMASK raises it to 0.
    fn execution_priority(&self) -> i16 {
        let active = self.active_priority();
        if self.primask { active.min(0) } else { active }
    }

    /// Enters the most urgent pending exception if the current priority lets it. Returns whether it
    /// did.
    #[cold]
    pub(super) fn take_pending_exception(&mut self, bus: &mut Bus) -> bool {
        self.latch_interrupts(bus);
        match self.nvic.most_urgent() {
            Some(exception) if self.nvic.priority(exception) < self.execution_priority() => {
                self.enter_exception(bus, exception);
                true
            }
            _ => {
                bus.interrupts_seen();
                false
            }
        }
    }

    /// What the interrupt lines did since the last look becomes pending.
    pub(super) fn latch_interrupts(&mut self, bus: &mut Bus) {
        self.make_pending(bus.take_interrupt_edges());
    }

    /// Makes interrupts pending, with the event SCR.SEVONPEND asks for.
    pub(super) fn make_pending(&mut self, interrupts: u32) {
        self.event_register |= self.send_event_on_pending && interrupts & !self.nvic.pending != 0;
        self.nvic.pending |= interrupts;
    }

    /// Stops executing. An interrupt that is already pending may wake the core at once, so it is
    /// looked for.
    pub(super) fn sleep(&mut self, bus: &mut Bus, activity: Activity) {
        self.activity = activity;
        bus.notice_interrupts();
        bus.pause_core();
    }

    /// Whether a sleeping core has a reason to go on; wakes it if so.
    pub fn try_wake(&mut self, bus: &mut Bus) -> bool {
        self.latch_interrupts(bus);
        let preempts = |core: &Core, priority: i16| {
            core.nvic.most_urgent().is_some_and(|exception| core.nvic.priority(exception) < priority)
        };
        let wake = match self.activity {
            Activity::Running => return true,
            Activity::LockedUp | Activity::Halted => false,
            // WFI wakes even if PRIMASK then keeps the exception from being taken.
            Activity::WaitingForInterrupt => preempts(self, self.active_priority()),
            Activity::WaitingForEvent => {
                std::mem::take(&mut self.event_register) || preempts(self, self.execution_priority())
            }
        };
        if wake {
            self.activity = Activity::Running;
            bus.notice_interrupts();
        }
        wake
    }

    /// ExceptionEntry: pushes the frame and goes to the handler (B1.5.6).
    fn enter_exception(&mut self, bus: &mut Bus, exception: u32) {
        if let Err(fault) = self.push_frame(bus) {
            self.lock_up(bus, fault);
            return;
        }
        self.r[LR] = match (self.ipsr, self.process_stack) {
            (0, false) => RETURN_TO_THREAD_MAIN,
            (0, true) => RETURN_TO_THREAD_PROCESS,
            _ => RETURN_TO_HANDLER,
        };
        self.select_process_stack(false);
        self.ipsr = exception;
        self.active.0.push(exception);
        self.nvic.clear_pending(exception);
        self.event_register = true;
        self.activity = Activity::Running;
        self.counters.exceptions[exception as usize] += 1;
        bus.notice_interrupts();
        match bus.read32(self.vector_table.wrapping_add(4 * exception)) {
            Ok(handler) => self.r[PC] = handler & !1,
            Err(fault) => self.lock_up(bus, fault),
        }
        bus.spend_cycles(ENTRY_CYCLES);
    }

    /// PushStack: R0 to R3, R12, LR, return address, xPSR on an 8-byte boundary.
    fn push_frame(&mut self, bus: &mut Bus) -> Result<(), Fault> {
        let sp = self.r[SP];
        let padded = sp >> 2 & 1;
        let frame = sp.wrapping_sub(32) & !7;
        const THUMB: u32 = 1 << 24;
        let xpsr = self.apsr() | THUMB | padded << 9 | self.ipsr;
        let words = [self.r[0], self.r[1], self.r[2], self.r[3], self.r[12], self.r[LR], self.r[PC], xpsr];
        for (i, word) in (0..).zip(words) {
            bus.write32(frame.wrapping_add(4 * i), word)?;
        }
        self.set_sp(frame);
        Ok(())
    }

    /// ExceptionReturn (B1.5.8).
    pub(super) fn exception_return(&mut self, bus: &mut Bus, exc_return: u32) -> Result<(), Fault> {
        let to_handler = match exc_return {
            RETURN_TO_HANDLER => true,
            RETURN_TO_THREAD_MAIN | RETURN_TO_THREAD_PROCESS => false,
            _ => return Err(Fault::InvalidState),
        };
        if to_handler != (self.active.0.len() > 1) {
            return Err(Fault::InvalidState);
        }
        if let Some(exception) = self.active.0.pop() {
            // A line that is still high makes its interrupt pending again (B3.4.1).
            if let Some(line) = exception.checked_sub(FIRST_INTERRUPT) {
                self.make_pending(bus.interrupt_lines() & 1 << line);
            }
        }
        self.select_process_stack(exc_return == RETURN_TO_THREAD_PROCESS);
        self.pop_frame(bus)?;
        self.event_register = true;
        bus.notice_interrupts();
        bus.spend_cycles(RETURN_CYCLES);
        Ok(())
    }

    fn pop_frame(&mut self, bus: &mut Bus) -> Result<(), Fault> {
        let frame = self.r[SP];
        let mut words = [0; 8];
        for (i, word) in (0..).zip(&mut words) {
            *word = bus.read32(frame.wrapping_add(4 * i))?;
        }
        let [r0, r1, r2, r3, r12, lr, pc, xpsr] = words;
        self.r[..4].copy_from_slice(&[r0, r1, r2, r3]);
        self.r[12] = r12;
        self.r[LR] = lr;
        self.r[PC] = pc & !1;
        self.set_apsr(xpsr);
        self.ipsr = xpsr & 0x3f;
        self.set_sp(frame.wrapping_add(32) | (xpsr >> 9 & 1) << 2);
        Ok(())
    }

    /// SVC: taken at once, or a HardFault if the priority does not let it (B1.5.4).
    pub(super) fn take_supervisor_call(&mut self, bus: &mut Bus, exception: u32) -> Outcome {
        if self.nvic.priority(exception) >= self.execution_priority() {
            return Err(Fault::SupervisorCall);
        }
        self.enter_exception(bus, exception);
        Ok(0)
    }

    /// The instruction at `pc` faulted.
    #[cold]
    pub(super) fn hard_fault(&mut self, bus: &mut Bus, pc: u32, fault: Fault) {
        bus.catch_up();
        self.counters.hard_faults += 1;
        self.counters.last_hard_fault = Some(HardFault { at: bus.now, pc, fault });
        self.r[PC] = pc;
        if self.active_priority() < 0 {
            self.sleep(bus, Activity::LockedUp);
        } else {
            self.enter_exception(bus, HARD_FAULT);
        }
    }

    /// The exception frame or vector could not be accessed.
    fn lock_up(&mut self, bus: &mut Bus, fault: Fault) {
        bus.catch_up();
        self.counters.hard_faults += 1;
        self.counters.last_hard_fault = Some(HardFault { at: bus.now, pc: self.r[PC], fault });
        self.sleep(bus, Activity::LockedUp);
    }
}
