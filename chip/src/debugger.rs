//! What a debug probe does: halts at breakpoints, looks at registers and memory and changes them.

use crate::chip::Chip;

/// Number of the breakpoint with which a program asks its debugger for something (ARM IHI 0105,
/// semihosting): operation in R0, its argument in R1, result expected in R0.
pub const SEMIHOSTING: u8 = 0xab;

impl Chip {
    /// From now on `BKPT` halts the processor instead of faulting. Time and peripherals go on
    /// meanwhile, the watchdog too.
    pub fn attach_debugger(&mut self) {
        self.core.attach_debugger();
    }

    /// The number of the breakpoint at which the processor has halted.
    pub fn breakpoint(&self) -> Option<u8> {
        self.core.breakpoint()
    }

    /// Goes on behind the breakpoint. Does nothing unless the processor has halted.
    pub fn resume(&mut self) {
        self.core.resume(&mut self.bus);
    }

    /// R0 to R12, the stack pointer in use, LR, and as 15 the address of the next instruction.
    ///
    /// # Panics
    ///
    /// If there is no such register.
    pub fn register(&self, number: usize) -> u32 {
        self.core.register(number)
    }

    /// Changes R0 to R12.
    ///
    /// # Panics
    ///
    /// If there is no such register.
    pub fn set_register(&mut self, number: usize, value: u32) {
        self.core.set_register(number, value);
    }

    /// Changes bytes of SRAM; says whether all of them are in it.
    pub fn write_memory(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.bus.load_sram(address, bytes).is_ok()
    }
}
