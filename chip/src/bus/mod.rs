//! Everything outside the core: time, memories, peripherals, pins, interrupt lines.
//!
//! - `memory.rs`: the address map and accesses of the core and the DMA;
//! - `flash.rs`: flash behind its cache, and the waits for it;
//! - `rom.rs`: the boot ROM's functions that change flash;
//! - `blocks.rs`: which peripheral answers where;
//! - `registers.rs`: accesses to registers, and what they set in motion;
//! - `events.rs`: what peripherals do by themselves as time goes on;
//! - `dma_engine.rs`: DMA requests and transfers;
//! - `clock_tree.rs`: frequencies from the oscillators to every consumer;
//! - `pins.rs`: what stands on the pins.

mod blocks;
mod clock_tree;
mod dma_engine;
mod events;
mod flash;
mod memory;
mod pins;
mod registers;
mod resets;
mod rom;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::peripherals::adc::Adc;
use crate::peripherals::clocks::Clocks;
use crate::peripherals::dma::Dma;
use crate::peripherals::gpio::IoBank;
use crate::peripherals::i2c::I2c;
use crate::peripherals::pads::Pads;
use crate::peripherals::pll::Pll;
use crate::peripherals::psm::Psm;
use crate::peripherals::pwm::Pwm;
use crate::peripherals::resets::Resets;
use crate::peripherals::rosc::Rosc;
use crate::peripherals::sio::Sio;
use crate::peripherals::ssi::Ssi;
use crate::peripherals::storage::{self, Storage};
use crate::peripherals::timer::Timer;
use crate::peripherals::uart::Uart;
use crate::peripherals::vreg::Vreg;
use crate::peripherals::watchdog::Watchdog;
use crate::peripherals::xip::Xip;
use crate::peripherals::xosc::Xosc;
use crate::report::{Access, Concern, ResetReason, UnmodelledLog};
use crate::ticks::{Rate, Ticks};

use clock_tree::CycleClock;
use dma_engine::DmaEngine;
use flash::FlashPort;
pub(crate) use memory::{RAM_CYCLES, access_cycles};
use pins::PinState;
pub use pins::{Edge, Level};
use rom::FlashChange;

/// The whole chip but the core.
#[derive(Clone, Debug)]
pub(crate) struct Bus {
    /// Virtual time, without the cycles that the core has spent since [`Bus::catch_up`]: whoever
    /// looks at time from within an instruction catches up first.
    pub now: Ticks,
    /// The processor clock or the 1 us tick changed. The core is paused, too.
    pub clocks_changed: bool,
    /// Cycles that the core has spent since `now`.
    spent: u32,
    /// The same before `now`, since creation.
    cycles: u64,
    /// The core executes while it has spent less: the only thing to be compared for each
    /// instruction.
    budget: u32,
    /// Up to where the run loop lets the core run, if nothing else is due.
    run_limit: Ticks,
    interrupts_changed: bool,
    core_paused: bool,
    interrupt_lines: u32,
    interrupt_edges: u32,
    /// When a peripheral next does something by itself.
    next_event: Ticks,
    cycle_clock: CycleClock,
    flash: Arc<[u8]>,
    flash_change: Option<FlashChange>,
    sram: Box<[u8; memory::SRAM_SIZE]>,
    reset_request: Option<ResetReason>,
    unmodelled: UnmodelledLog,
    pins: PinState,
    dma_engine: DmaEngine,
    flash_port: FlashPort,

    pub(crate) uarts: [Uart; 2],
    pub(crate) i2c: [I2c; 2],
    pub(crate) adc: Adc,
    pub(crate) pwm: Pwm,
    sio: Sio,
    io: IoBank,
    pads: Pads,
    dma: Dma,
    timer: Timer,
    watchdog: Watchdog,
    clocks: Clocks,
    resets: Resets,
    psm: Psm,
    xosc: Xosc,
    rosc: Rosc,
    pll_sys: Pll,
    pll_usb: Pll,
    vreg: Vreg,
    xip: Xip,
    ssi: Ssi,
    pads_qspi: Storage,
    spi: [Storage; 2],
    sysinfo: Storage,
    syscfg: Storage,
    tbman: Storage,
}

impl Bus {
    /// A chip with `flash` at 0x1000_0000, just powered.
    pub fn new(flash: Arc<[u8]>) -> Bus {
        let mut bus = Bus {
            now: Ticks::ZERO,
            clocks_changed: true,
            spent: 0,
            cycles: 0,
            budget: 0,
            run_limit: Ticks::ZERO,
            interrupts_changed: true,
            core_paused: true,
            interrupt_lines: 0,
            interrupt_edges: 0,
            next_event: Ticks::NEVER,
            cycle_clock: CycleClock::default(),
            flash,
            flash_change: None,
            sram: memory::power_on_sram(),
            reset_request: None,
            unmodelled: UnmodelledLog::default(),
            pins: PinState::default(),
            dma_engine: DmaEngine::default(),
            flash_port: FlashPort::default(),
            uarts: Default::default(),
            i2c: Default::default(),
            adc: Adc::default(),
            pwm: Pwm::default(),
            sio: Sio::default(),
            io: IoBank::default(),
            pads: Pads::default(),
            dma: Dma::default(),
            timer: Timer::default(),
            watchdog: Watchdog::default(),
            clocks: Clocks::default(),
            resets: Resets::default(),
            psm: Psm::default(),
            xosc: Xosc::default(),
            rosc: Rosc::default(),
            pll_sys: Pll::default(),
            pll_usb: Pll::default(),
            vreg: Vreg::default(),
            xip: Xip::default(),
            ssi: Ssi::after_boot_loader(),
            pads_qspi: Storage::new(storage::PADS_QSPI),
            spi: [Storage::new(storage::SPI), Storage::new(storage::SPI)],
            sysinfo: Storage::new(storage::SYSINFO),
            syscfg: Storage::new(storage::SYSCFG),
            tbman: Storage::new(storage::TBMAN),
        };
        bus.update_clocks();
        bus.update_pins();
        bus.settle();
        bus
    }

    /// When a peripheral next does something by itself.
    pub fn next_event(&self) -> Ticks {
        self.next_event
    }

    /// The interrupt lines, or something else the core must look at before its next instruction,
    /// changed.
    #[inline]
    pub fn notice_interrupts(&mut self) {
        self.interrupts_changed = true;
        self.budget = 0;
    }

    /// Whether [`Self::notice_interrupts`] was called since the core last looked.
    #[inline]
    pub fn interrupts_changed(&self) -> bool {
        self.interrupts_changed
    }

    /// The core has looked at the interrupt lines.
    pub fn interrupts_seen(&mut self) {
        self.interrupts_changed = false;
        self.set_budget();
    }

    /// The run loop must look at the core before its next instruction: it sleeps, its timer was
    /// set, a clock changed, a peripheral asks for a reset.
    pub fn pause_core(&mut self) {
        self.core_paused = true;
        self.budget = 0;
    }

    /// Whether the core is to be looked at.
    pub fn core_paused(&self) -> bool {
        self.core_paused
    }

    /// The same, once.
    pub fn take_core_pause(&mut self) -> bool {
        std::mem::take(&mut self.core_paused)
    }

    /// The core executes no further instruction before the run loop lets it: it must wait for
    /// flash.
    fn stop_core(&mut self) {
        self.budget = 0;
    }

    /// Lets the core execute until `limit` or whatever is due before it.
    pub fn let_core_run(&mut self, limit: Ticks) {
        self.run_limit = limit;
        self.set_budget();
    }

    /// Whether the core executes its next instruction without a look at anything else.
    #[inline]
    pub fn core_runs(&self) -> bool {
        self.spent < self.budget
    }

    fn set_budget(&mut self) {
        debug_assert!(self.spent == 0, "time has been caught up with");
        let stops = self.interrupts_changed || self.core_paused || self.must_wait();
        let time = self.run_limit.min(self.next_event).saturating_sub(self.now);
        self.budget = if stops { 0 } else { self.cycle_clock.cycles_to_pass(time) };
    }

    /// The interrupt lines as they are now, bit n for IRQ n.
    pub fn interrupt_lines(&self) -> u32 {
        self.interrupt_lines
    }

    /// Lines that rose since the last call.
    pub fn take_interrupt_edges(&mut self) -> u32 {
        std::mem::take(&mut self.interrupt_edges)
    }

    /// The reset a peripheral asks for, once.
    pub fn take_reset_request(&mut self) -> Option<ResetReason> {
        self.reset_request.take()
    }

    /// Moves time on by processor cycles.
    #[inline]
    pub fn spend_cycles(&mut self, cycles: u32) {
        self.spent += cycles;
    }

    /// Cycles that the core has spent since creation, up to `now`.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Makes [`Bus::now`] the time at which the core is.
    #[inline]
    pub fn catch_up(&mut self) {
        let spent = std::mem::take(&mut self.spent);
        self.budget = self.budget.saturating_sub(spent);
        self.cycles += u64::from(spent);
        self.now += self.cycle_clock.ticks(spent);
    }

    /// clk_sys, which is the processor's clock.
    pub fn processor_rate(&self) -> Rate {
        self.cycle_clock.rate()
    }

    /// The watchdog's tick, the reference clock of SysTick.
    pub fn tick_rate(&self) -> Rate {
        match self.watchdog.tick_cycles() {
            Some(cycles) => {
                let (numerator, denominator) = self.clk_ref();
                Rate::hertz(numerator, denominator * cycles)
            }
            None => Rate::STOPPED,
        }
    }

    pub fn note_unmodelled(&mut self, address: u32, access: Access, concern: Concern) {
        self.unmodelled.note(address, access, concern);
    }

    pub fn unmodelled(&self) -> &UnmodelledLog {
        &self.unmodelled
    }
}
