//! Tests of the core: against an independent implementation, and by small programs.

mod assembler;
mod differential;
mod exceptions;
mod faults;
mod sleeping;
mod systick;
mod timing;

use super::{Core, PC};
use crate::bus::Bus;
use crate::ticks::Ticks;

/// Where the test programs stand.
const VECTORS: u32 = 0x2000_0000;
const CODE: u32 = 0x2000_1000;
const DATA: u32 = 0x2000_2000;
const STACK: u32 = 0x2000_8000;

/// A core with a program in SRAM.
struct Machine {
    core: Core,
    bus: Bus,
}

impl Machine {
    /// Loads `program` at [`CODE`], points every exception at its own handler address and resets
    /// the core.
    fn new(program: &[u16]) -> Machine {
        let mut bus = Bus::new(Vec::new().into());
        let mut core = Core::new();
        let write = |bus: &mut Bus, address, value| bus.write32(address, value).expect("SRAM");
        write(&mut bus, VECTORS, STACK);
        write(&mut bus, VECTORS + 4, CODE | 1);
        for exception in 2..48 {
            write(&mut bus, VECTORS + 4 * exception, handler(exception) | 1);
        }
        core.reset(&mut bus, VECTORS);
        let mut machine = Machine { core, bus };
        machine.load(CODE, program);
        machine
    }

    fn load(&mut self, address: u32, program: &[u16]) {
        for (i, opcode) in (0..).zip(program) {
            self.bus.write16(address + 2 * i, *opcode).expect("SRAM");
        }
    }

    fn step(&mut self) {
        self.core.step(&mut self.bus);
    }

    fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.step();
        }
    }

    fn pc(&self) -> u32 {
        self.core.r[PC]
    }

    fn word(&mut self, address: u32) -> u32 {
        self.bus.read32(address).expect("memory")
    }

    /// Writes a register of the system control space.
    fn write_scs(&mut self, offset: u32, value: u32) {
        self.core.write_system_control(&mut self.bus, 0xe000_e000 + offset, value).expect("register");
    }

    fn read_scs(&mut self, offset: u32) -> u32 {
        self.core.read_system_control(&mut self.bus, 0xe000_e000 + offset).expect("register")
    }

    /// Enables an interrupt at a priority (0 to 3) and makes it pending.
    fn enable_interrupt(&mut self, irq: u32, priority: u32) {
        self.write_scs(0x100, 1 << irq);
        let register = 0x400 + (irq & !3);
        let shift = 8 * (irq % 4) + 6;
        let others = self.read_scs(register) & !(3 << shift);
        self.write_scs(register, others | priority << shift);
    }

    fn pend(&mut self, irq: u32) {
        self.write_scs(0x200, 1 << irq);
    }

    /// Runs idle time: what the run loop does for a core that sleeps.
    fn pass(&mut self, duration: Ticks) {
        self.bus.now += duration;
        self.core.advance(&mut self.bus);
    }
}

/// Address of an exception's handler: 64 bytes each.
fn handler(exception: u32) -> u32 {
    0x2000_4000 + 64 * exception
}
