//! Accesses to registers, and what they set in motion.

use super::Bus;
use super::blocks::{Block, block_at};
use crate::peripherals::sio::GPIO_IN;
use crate::peripherals::{Alias, RegisterWrite, Written};
use crate::report::{Access, Concern};

/// Bits 13 and 12 choose the alias.
pub(super) const ALIAS_BITS: u32 = 0x3000;

/// The blocks behind interposers, and the first one after them.
const UART0: u32 = 0x4003_4000;
const ADC: u32 = 0x4004_c000;

/// UART, SPI and I2C know nothing of aliases: an interposer in front of them reads, modifies and
/// writes (2.1.2). So an atomic write to UARTDR takes a byte out of the receive FIFO, and one
/// through the clear alias to a write-one-to-clear register acknowledges nothing.
pub(super) fn has_interposer(address: u32) -> bool {
    (UART0..ADC).contains(&address)
}

/// A register's offset in its block, whichever alias it is reached through.
fn offset(address: u32) -> u32 {
    address & 0xfff
}

impl Bus {
    /// A register read by the core.
    #[inline]
    pub(super) fn read_register(&mut self, address: u32) -> u32 {
        let block = block_at(address);
        let value = self.read_block(block, address);
        if block.read_takes.takes(offset(address)) {
            self.catch_up();
            self.settle();
        }
        value
    }

    /// A register read without its consequences for DMA and interrupts: the caller settles.
    pub(super) fn read_register_quietly(&mut self, address: u32) -> u32 {
        self.read_block(block_at(address), address)
    }

    #[inline]
    fn read_block(&mut self, block: &Block, address: u32) -> u32 {
        if self.resets.holds(block.held_by) {
            return self.read_of_nothing(address, Concern::HeldInReset);
        }
        match (block.read)(self, offset(address)) {
            Some(value) => value,
            None => self.read_of_nothing(address, Concern::NotModelled),
        }
    }

    #[cold]
    fn read_of_nothing(&mut self, address: u32, concern: Concern) -> u32 {
        self.note_unmodelled(address & !ALIAS_BITS, Access::Read, concern);
        0
    }

    /// A register written by the core.
    pub(super) fn write_register(&mut self, address: u32, value: u32) {
        self.write_register_quietly(address, value);
        self.settle();
    }

    /// A register write without its consequences for DMA and interrupts: the caller settles.
    pub(super) fn write_register_quietly(&mut self, address: u32, value: u32) {
        let block = block_at(address);
        if self.resets.holds(block.held_by) {
            self.note_unmodelled(address & !ALIAS_BITS, Access::Write, Concern::HeldInReset);
            return;
        }
        let mut write = RegisterWrite::new(address, value);
        if write.alias != Alias::Plain && has_interposer(address) {
            let old = self.read_block(block, address);
            write = RegisterWrite::plain(write.onto(old));
        }
        let concern = match (block.write)(self, offset(address), write) {
            Written::Done => return,
            Written::NotModelled => Concern::NotModelled,
            Written::ValueNotModelled => Concern::ValueNotModelled,
        };
        self.note_unmodelled(address & !ALIAS_BITS, Access::Write, concern);
    }

    pub(super) fn clocks_written(&mut self, written: Written) -> Written {
        if self.update_clocks() { written } else { Written::ValueNotModelled }
    }

    pub(super) fn read_sio(&mut self, address: u32) -> u32 {
        let offset = address & 0xfff;
        let value = if offset == GPIO_IN { Some(self.input_levels()) } else { self.sio.read(offset) };
        value.unwrap_or_else(|| {
            self.note_unmodelled(address, Access::Read, Concern::NotModelled);
            0
        })
    }

    pub(super) fn write_sio(&mut self, address: u32, value: u32) {
        let (output, enable) = (self.sio.output(), self.sio.output_enable());
        if !self.sio.write(address & 0xfff, value) {
            self.note_unmodelled(address, Access::Write, Concern::NotModelled);
        }
        let changed = output ^ self.sio.output() | enable ^ self.sio.output_enable();
        if changed != 0 {
            self.update_some_pins(changed, self.now);
            self.update_interrupt_lines();
        }
    }
}
