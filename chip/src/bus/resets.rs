//! Resets of single peripherals and of the chip.

use super::{Bus, memory};
use crate::peripherals::clocks::Clocks;
use crate::peripherals::pads::Pads;
use crate::peripherals::pll::Pll;
use crate::peripherals::resets::{self, Resets, bit};
use crate::peripherals::sio::Sio;
use crate::report::ResetReason;
use crate::ticks::Ticks;

impl Bus {
    /// Resets the peripherals whose bits have just been set in RESETS.
    pub(super) fn reset_peripherals(&mut self, peripherals: u32) {
        if peripherals == 0 {
            return;
        }
        let is_reset = |bit: u32| peripherals & bit != 0;
        if is_reset(bit::ADC) {
            self.adc.reset();
        }
        if is_reset(bit::DMA) {
            self.dma.reset();
        }
        if is_reset(bit::PWM) {
            self.pwm.reset();
        }
        if is_reset(bit::TIMER) {
            self.timer.reset(self.now);
        }
        if is_reset(bit::IO_BANK0) {
            self.io.reset();
        }
        if is_reset(bit::PADS_BANK0) {
            self.pads = Pads::default();
        }
        if is_reset(bit::PLL_SYS) {
            self.pll_sys = Pll::default();
        }
        if is_reset(bit::PLL_USB) {
            self.pll_usb = Pll::default();
        }
        if is_reset(bit::SYSCFG) {
            self.syscfg.reset();
        }
        for (bit, spi) in [bit::SPI0, bit::SPI1].into_iter().zip(&mut self.spi) {
            if is_reset(bit) {
                spi.reset();
            }
        }
        for (bit, i2c) in [bit::I2C0, bit::I2C1].into_iter().zip(&mut self.i2c) {
            if is_reset(bit) {
                i2c.reset(self.now);
            }
        }
        for (bit, uart) in [bit::UART0, bit::UART1].into_iter().zip(&mut self.uarts) {
            if is_reset(bit) {
                uart.reset();
            }
        }
        self.update_clocks();
        self.pin_functions_changed();
    }

    /// GPIO outputs, spinlocks and divider as after power-on.
    pub(super) fn reset_sio(&mut self) {
        self.sio = Sio::default();
        self.update_pins();
    }

    /// What the watchdog resets besides the processor: what PSM WDSEL and RESETS WDSEL select
    /// (2.13.4, 2.14.2). Returns whether the processor is among it.
    pub fn reset_by_watchdog(&mut self, reason: ResetReason) -> bool {
        let processor = self.psm.watchdog_resets_processor();
        let selected = self.resets.watchdog_select();
        if self.psm.watchdog_resets_clocks() {
            self.clocks = Clocks::default();
        }
        if self.psm.watchdog_resets_peripherals() {
            self.resets = Resets::default();
            self.sio = Sio::default();
            self.reset_peripherals(resets::ALL);
        } else {
            self.resets.hold(selected);
            self.reset_peripherals(selected);
        }
        self.watchdog.restart_after(reason);
        self.update_clocks();
        self.pin_functions_changed();
        self.settle();
        processor
    }

    /// Power off and on: registers and SRAM are lost. Time, flash, the world outside the pins, the
    /// logs and what is already on the wires stay.
    pub fn power_cycle(&mut self) {
        self.cut_flash();
        let mut fresh = Bus::new(self.flash.clone());
        (fresh.now, fresh.cycles) = (self.now, self.cycles);
        fresh.sram = memory::power_on_sram();
        fresh.interrupt_edges = 0;
        fresh.pins = self.pins.clone();
        fresh.unmodelled = self.unmodelled.clone();
        fresh.timer.reset(self.now);
        for (uart, before) in fresh.uarts.iter_mut().zip(&mut self.uarts) {
            before.reset();
            std::mem::swap(uart, before);
        }
        for (i2c, before) in fresh.i2c.iter_mut().zip(&mut self.i2c) {
            before.reset(self.now);
            std::mem::swap(i2c, before);
        }
        self.adc.reset();
        std::mem::swap(&mut fresh.adc, &mut self.adc);
        *self = fresh;
        self.next_event = Ticks::ZERO;
        self.update_clocks();
        self.pin_functions_changed();
        self.settle();
    }
}
