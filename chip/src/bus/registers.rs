//! Which peripheral answers at which address (2.2), and what follows from an access.

use super::Bus;
use crate::peripherals::resets::bit;
use crate::peripherals::sio::GPIO_IN;
use crate::peripherals::{Alias, RegisterWrite, Written, adc, uart};
use crate::report::{Access, Concern};

/// Base addresses; each block has 16 KiB, four times 4 KiB for the atomic aliases.
mod base {
    pub const SYSINFO: u32 = 0x4000_0000;
    pub const SYSCFG: u32 = 0x4000_4000;
    pub const CLOCKS: u32 = 0x4000_8000;
    pub const RESETS: u32 = 0x4000_c000;
    pub const PSM: u32 = 0x4001_0000;
    pub const IO_BANK0: u32 = 0x4001_4000;
    pub const PADS_BANK0: u32 = 0x4001_c000;
    pub const PADS_QSPI: u32 = 0x4002_0000;
    pub const XOSC: u32 = 0x4002_4000;
    pub const PLL_SYS: u32 = 0x4002_8000;
    pub const PLL_USB: u32 = 0x4002_c000;
    pub const UART0: u32 = 0x4003_4000;
    pub const UART1: u32 = 0x4003_8000;
    pub const SPI0: u32 = 0x4003_c000;
    pub const SPI1: u32 = 0x4004_0000;
    pub const I2C0: u32 = 0x4004_4000;
    pub const I2C1: u32 = 0x4004_8000;
    pub const ADC: u32 = 0x4004_c000;
    pub const PWM: u32 = 0x4005_0000;
    pub const TIMER: u32 = 0x4005_4000;
    pub const WATCHDOG: u32 = 0x4005_8000;
    pub const ROSC: u32 = 0x4006_0000;
    pub const VREG_AND_CHIP_RESET: u32 = 0x4006_4000;
    pub const TBMAN: u32 = 0x4006_c000;
    pub const DMA: u32 = 0x5000_0000;
}

/// Bits 13 and 12 choose the alias.
pub(super) const ALIAS_BITS: u32 = 0x3000;

/// UART, SPI and I2C know nothing of aliases: an interposer in front of them reads, modifies and writes (2.1.2). So an
/// atomic write to UARTDR takes a byte out of the receive FIFO, and one through the clear alias to a
/// write-one-to-clear register acknowledges nothing.
pub(super) fn has_interposer(address: u32) -> bool {
    (base::UART0..base::ADC).contains(&address)
}

fn split(address: u32) -> (u32, u32) {
    (address & !0x3fff, address & 0xfff)
}

/// The RESETS bit that holds a block, if one does.
fn reset_bit(block: u32) -> Option<u32> {
    Some(match block {
        base::SYSINFO => bit::SYSINFO,
        base::SYSCFG => bit::SYSCFG,
        base::IO_BANK0 => bit::IO_BANK0,
        base::PADS_BANK0 => bit::PADS_BANK0,
        base::PLL_SYS => bit::PLL_SYS,
        base::PLL_USB => bit::PLL_USB,
        base::UART0 => bit::UART0,
        base::UART1 => bit::UART1,
        base::SPI0 => bit::SPI0,
        base::SPI1 => bit::SPI1,
        base::I2C0 => bit::I2C0,
        base::I2C1 => bit::I2C1,
        base::ADC => bit::ADC,
        base::PWM => bit::PWM,
        base::TIMER => bit::TIMER,
        base::TBMAN => bit::TBMAN,
        base::DMA => bit::DMA,
        _ => return None,
    })
}

impl Bus {
    #[inline]
    fn held_in_reset(&self, block: u32) -> bool {
        reset_bit(block).is_some_and(|bit| self.resets.holds(bit))
    }

    /// A register read by the core.
    #[inline]
    pub(super) fn read_register(&mut self, address: u32) -> u32 {
        let value = self.read_register_quietly(address);
        // Only these reads take something away: a FIFO entry, or an interrupt.
        if matches!(
            split(address),
            (base::UART0 | base::UART1, uart::UARTDR) | (base::ADC, adc::FIFO) | (base::I2C0 | base::I2C1, _)
        ) {
            self.settle();
        }
        value
    }

    /// A register read without its consequences for DMA and interrupts: the caller settles.
    #[inline]
    pub(super) fn read_register_quietly(&mut self, address: u32) -> u32 {
        let (block, offset) = split(address);
        if self.held_in_reset(block) {
            self.note_unmodelled(address & !ALIAS_BITS, Access::Read, Concern::HeldInReset);
            return 0;
        }
        let now = self.now;
        let value = match block {
            base::SYSINFO => self.sysinfo.read(offset),
            base::SYSCFG => self.syscfg.read(offset),
            base::CLOCKS => self.clocks.read(offset),
            base::RESETS => self.resets.read(offset),
            base::PSM => self.psm.read(offset),
            base::IO_BANK0 => {
                let (outputs, enables) = self.driven_pins();
                self.io.read(offset, outputs, enables)
            }
            base::PADS_BANK0 => self.pads.read(offset),
            base::PADS_QSPI => self.pads_qspi.read(offset),
            base::XOSC => self.xosc.read(offset, now),
            base::PLL_SYS => self.pll_sys.read(offset),
            base::PLL_USB => self.pll_usb.read(offset),
            base::UART0 => self.uarts[0].read(offset),
            base::UART1 => self.uarts[1].read(offset),
            base::SPI0 => self.spi[0].read(offset),
            base::SPI1 => self.spi[1].read(offset),
            base::I2C0 => self.i2c[0].read(offset),
            base::I2C1 => self.i2c[1].read(offset),
            base::ADC => self.adc.read(offset),
            base::PWM => self.pwm.read(offset, now),
            base::TIMER => self.timer.read(offset, now),
            base::WATCHDOG => self.watchdog.read(offset, now),
            base::ROSC => self.rosc.read(offset),
            base::VREG_AND_CHIP_RESET => self.vreg.read(offset),
            base::TBMAN => self.tbman.read(offset),
            base::DMA => self.dma.read(offset),
            _ => None,
        };
        value.unwrap_or_else(|| {
            self.note_unmodelled(address & !ALIAS_BITS, Access::Read, Concern::NotModelled);
            0
        })
    }

    /// A register written by the core.
    pub(super) fn write_register(&mut self, address: u32, value: u32) {
        self.write_register_quietly(address, value);
        self.settle();
    }

    /// A register write without its consequences for DMA and interrupts: the caller settles.
    pub(super) fn write_register_quietly(&mut self, address: u32, value: u32) {
        let (block, offset) = split(address);
        if self.held_in_reset(block) {
            self.note_unmodelled(address & !ALIAS_BITS, Access::Write, Concern::HeldInReset);
            return;
        }
        let mut write = RegisterWrite::new(address, value);
        if write.alias != Alias::Plain && has_interposer(address) {
            let old = self.read_register_quietly(address);
            write = RegisterWrite::plain(write.onto(old));
        }
        let written = self.write_block(block, offset, write);
        let concern = match written {
            Written::Done => return,
            Written::NotModelled => Concern::NotModelled,
            Written::ValueNotModelled => Concern::ValueNotModelled,
        };
        self.note_unmodelled(address & !ALIAS_BITS, Access::Write, concern);
    }

    fn write_block(&mut self, block: u32, offset: u32, write: RegisterWrite) -> Written {
        let now = self.now;
        match block {
            base::SYSINFO => self.sysinfo.write(offset, write),
            base::SYSCFG => self.syscfg.write(offset, write),
            base::CLOCKS => {
                let written = self.clocks.write(offset, write);
                self.clocks_written(written)
            }
            base::RESETS => {
                let (written, newly_held) = self.resets.write(offset, write);
                self.reset_peripherals(newly_held);
                written
            }
            base::PSM => {
                let written = self.psm.write(offset, write);
                if self.psm.holds_sio() {
                    self.reset_sio();
                }
                written
            }
            base::IO_BANK0 => {
                let written = self.io.write(offset, write);
                self.pin_functions_changed();
                written
            }
            base::PADS_BANK0 => {
                let written = self.pads.write(offset, write);
                self.update_pins();
                written
            }
            base::PADS_QSPI => self.pads_qspi.write(offset, write),
            base::XOSC => self.xosc.write(offset, write, now),
            base::PLL_SYS => {
                let written = self.pll_sys.write(offset, write);
                self.clocks_written(written)
            }
            base::PLL_USB => {
                let written = self.pll_usb.write(offset, write);
                self.clocks_written(written)
            }
            base::UART0 => self.uarts[0].write(offset, write, now),
            base::UART1 => self.uarts[1].write(offset, write, now),
            base::SPI0 => self.spi[0].write(offset, write),
            base::SPI1 => self.spi[1].write(offset, write),
            base::I2C0 => self.i2c[0].write(offset, write, now),
            base::I2C1 => self.i2c[1].write(offset, write, now),
            base::ADC => self.adc.write(offset, write, now),
            base::PWM => {
                let written = self.pwm.write(offset, write, now);
                self.update_pwm_pins(now);
                written
            }
            base::TIMER => self.timer.write(offset, write, now),
            base::WATCHDOG => {
                let written = self.watchdog.write(offset, write, now);
                self.update_tick();
                written
            }
            base::ROSC => {
                let written = self.rosc.write(offset, write);
                self.clocks_written(written)
            }
            base::VREG_AND_CHIP_RESET => self.vreg.write(offset, write),
            base::TBMAN => self.tbman.write(offset, write),
            base::DMA => self.dma.write(offset, write, now),
            _ => Written::NotModelled,
        }
    }

    fn clocks_written(&mut self, written: Written) -> Written {
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
