//! SSI (4.10): the serial interface to the flash chip, as second-stage boot loaders set it up, and
//! what a read through it costs.

use std::collections::VecDeque;

use super::serial_flash::{SerialFlash, UnknownInstruction};
use super::{RegisterWrite, Written};
use crate::ticks::{Rate, Ticks};

/// Register offsets (4.10.13).
const CTRLR0: u32 = 0x00;
const CTRLR1: u32 = 0x04;
const SSIENR: u32 = 0x08;
const SER: u32 = 0x10;
const BAUDR: u32 = 0x14;
const SR: u32 = 0x28;
const DR0: u32 = 0x60;
const RX_SAMPLE_DLY: u32 = 0xf0;
const SPI_CTRLR0: u32 = 0xf4;

/// SR.
const BUSY: u32 = 1 << 0;
const TRANSMIT_NOT_FULL: u32 = 1 << 1;
const TRANSMIT_EMPTY: u32 = 1 << 2;
const RECEIVE_NOT_EMPTY: u32 = 1 << 3;

/// Processor cycles of a read besides those of the serial clock: chip select, the SSI's FIFOs, its
/// bus. The datasheet gives none; with this many, a read with the usual divider of 2 takes the 400
/// ns at 125 MHz that users have measured.
const READ_OVERHEAD: u32 = 10;

/// The SSI block with the flash chip behind it.
#[derive(Clone, Debug)]
pub(crate) struct Ssi {
    enabled: bool,
    control0: u32,
    control1: u32,
    slave_enable: u32,
    divider: u32,
    sample_delay: u32,
    spi_control: u32,
    received: VecDeque<u32>,
    /// Instruction and address of a read on several lines, as far as they have been written.
    pushed: Vec<u32>,
    busy_until: Ticks,
    flash: SerialFlash,
}

impl Ssi {
    /// As the boot ROM hands it to the boot loader in flash.
    pub fn after_boot_rom() -> Ssi {
        Ssi { enabled: false, flash: SerialFlash::default(), ..Ssi::after_boot_loader() }
    }

    /// As the boot loader for the W25Q080 family leaves it: quad reads of 32 bits without
    /// instruction, at half the system clock.
    pub fn after_boot_loader() -> Ssi {
        Ssi {
            enabled: true,
            control0: 0x005f_0300,
            control1: 0,
            slave_enable: 1,
            divider: 2,
            sample_delay: 1,
            spi_control: 0xa000_2022,
            received: VecDeque::new(),
            pushed: Vec::new(),
            busy_until: Ticks::ZERO,
            flash: SerialFlash::reading_continuously(),
        }
    }

    /// Data lines of a read: CTRLR0.SPI_FRF.
    fn lines(&self) -> u32 {
        1 << (self.control0 >> 21 & 3).min(2)
    }

    /// Bits of the instruction before a read's address: SPI_CTRLR0.INST_L.
    fn instruction_bits(&self) -> u32 {
        [0, 4, 8, 16][(self.spi_control >> 8 & 3) as usize]
    }

    /// Serial clocks of a read of 32 bits: instruction, address with mode bits, wait, data.
    /// SPI_CTRLR0.TRANS_TYPE says which of the first two go over all lines.
    fn read_clocks(&self) -> u32 {
        let lines = self.lines();
        let (instruction_lines, address_lines) = match self.spi_control & 3 {
            0 => (1, 1),
            1 => (1, lines),
            _ => (lines, lines),
        };
        let address_bits = 4 * (self.spi_control >> 2 & 15);
        let wait = self.spi_control >> 11 & 31;
        self.instruction_bits() / instruction_lines + address_bits / address_lines + wait + 32 / lines
    }

    /// Processor cycles for which the bus waits when the cache has to read from flash.
    pub fn read_cycles(&self) -> u32 {
        self.read_clocks() * self.divider.max(2) + READ_OVERHEAD
    }

    /// Whether the flash chip understands what the SSI would send for a read.
    pub fn can_read(&self) -> bool {
        self.enabled && self.flash.is_continuous() == (self.instruction_bits() == 0)
    }

    /// Whether the flash chip takes the next byte for an instruction.
    pub fn flash_takes_instructions(&self) -> bool {
        !self.flash.is_continuous()
    }

    pub fn read(&mut self, offset: u32, now: Ticks) -> Option<u32> {
        Some(match offset {
            CTRLR0 => self.control0,
            CTRLR1 => self.control1,
            SSIENR => u32::from(self.enabled),
            SER => self.slave_enable,
            BAUDR => self.divider,
            SR => {
                let idle = now >= self.busy_until;
                let received = !self.received.is_empty();
                let transmit = if idle { TRANSMIT_EMPTY } else { BUSY };
                TRANSMIT_NOT_FULL | transmit | if received { RECEIVE_NOT_EMPTY } else { 0 }
            }
            DR0 => self.received.pop_front().unwrap_or(0),
            RX_SAMPLE_DLY => self.sample_delay,
            SPI_CTRLR0 => self.spi_control,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, clk_sys: Rate, now: Ticks) -> Written {
        let value = write.raw;
        match offset {
            CTRLR0 => self.control0 = value,
            CTRLR1 => self.control1 = value & 0xffff,
            SSIENR => {
                self.enabled = value & 1 != 0;
                if !self.enabled {
                    self.received.clear();
                    self.pushed.clear();
                }
            }
            SER => self.slave_enable = value & 1,
            BAUDR => self.divider = value & 0xfffe,
            DR0 if self.enabled => return self.push(value, clk_sys, now),
            DR0 => {}
            RX_SAMPLE_DLY => self.sample_delay = value & 0xff,
            SPI_CTRLR0 => self.spi_control = value,
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    fn push(&mut self, value: u32, clk_sys: Rate, now: Ticks) -> Written {
        if self.lines() == 1 {
            // What is pushed while the last byte is on its way belongs to the same transfer.
            if now >= self.busy_until {
                self.flash.select();
            }
            self.be_busy_for(8, clk_sys, now);
            let answer = self.flash.exchange(value as u8);
            self.received.push_back(u32::from(answer.unwrap_or(0xff)));
            return modelled(answer.map(drop));
        }
        self.pushed.push(value);
        let [instruction, address] = self.pushed[..] else { return Written::Done };
        self.pushed.clear();
        self.be_busy_for(self.read_clocks(), clk_sys, now);
        self.received.push_back(u32::MAX);
        modelled(self.flash.read_quad(instruction as u8, address as u8))
    }

    fn be_busy_for(&mut self, clocks: u32, clk_sys: Rate, now: Ticks) {
        self.busy_until =
            self.busy_until.max(now) + clk_sys.ticks_for(u64::from(clocks * self.divider.max(2)));
    }
}

fn modelled(result: Result<(), UnknownInstruction>) -> Written {
    result.map_or(Written::ValueNotModelled, |()| Written::Done)
}

#[cfg(test)]
mod tests;
