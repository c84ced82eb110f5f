//! The special registers behind MRS and MSR (B5.2).

use super::{Core, Flags, SP};
use crate::bus::Bus;
use crate::report::Fault;

const MSP: u16 = 8;
const PSP: u16 = 9;
const PRIMASK: u16 = 16;
const CONTROL: u16 = 20;

impl Core {
    /// APSR flags in bits 31 to 28.
    pub(super) fn apsr(&self) -> u32 {
        let flags = self.flags;
        let bit = |set: bool, n: u32| u32::from(set) << n;
        bit(flags.n(), 31) | bit(flags.z(), 30) | bit(flags.c, 29) | bit(flags.v(), 28)
    }

    pub(super) fn set_apsr(&mut self, value: u32) {
        self.flags = Flags {
            negative: value,
            nonzero: !value & 1 << 30,
            c: value >> 29 & 1 != 0,
            overflow: value << 3,
        };
    }

    pub(super) fn read_special_register(&self, number: u16) -> Result<u32, Fault> {
        Ok(match number {
            // Combinations of APSR (bit 2 clear), EPSR (reads zero) and IPSR (bit 0).
            0..=7 => {
                let apsr = if number & 4 == 0 { self.apsr() } else { 0 };
                let ipsr = if number & 1 != 0 { self.ipsr } else { 0 };
                apsr | ipsr
            }
            MSP if self.process_stack => self.banked_sp,
            MSP => self.r[SP],
            PSP if self.process_stack => self.r[SP],
            PSP => self.banked_sp,
            PRIMASK => u32::from(self.primask),
            CONTROL => u32::from(self.process_stack) << 1,
            _ => return Err(Fault::UndefinedInstruction),
        })
    }

    pub(super) fn write_special_register(
        &mut self,
        bus: &mut Bus,
        number: u16,
        value: u32,
    ) -> Result<(), Fault> {
        match number {
            0..=3 => self.set_apsr(value),
            // IPSR and EPSR ignore writes.
            4..=7 => {}
            MSP if self.process_stack => self.banked_sp = value & !3,
            MSP => self.set_sp(value & !3),
            PSP if self.process_stack => self.set_sp(value & !3),
            PSP => self.banked_sp = value & !3,
            PRIMASK => {
                self.primask = value & 1 != 0;
                bus.notice_interrupts();
            }
            // In handler mode CONTROL.SPSEL ignores writes. nPRIV is not modelled: code always runs
            // privileged.
            CONTROL if self.ipsr == 0 => self.select_process_stack(value & 2 != 0),
            CONTROL => {}
            _ => return Err(Fault::UndefinedInstruction),
        }
        Ok(())
    }

    /// Switches R13 between the main and the process stack.
    pub(super) fn select_process_stack(&mut self, process: bool) {
        if process != self.process_stack {
            std::mem::swap(&mut self.r[SP], &mut self.banked_sp);
            self.process_stack = process;
        }
    }
}
