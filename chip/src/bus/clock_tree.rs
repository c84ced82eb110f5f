//! From the oscillators to the consumers: recomputed whenever CLOCKS, a PLL or the watchdog's tick is written.

use super::Bus;
use crate::peripherals::clocks::{Hertz, Sources};
use crate::ticks::{Rate, Ticks};

/// Turns processor cycles into ticks without losing fractions of a tick.
#[derive(Clone, Debug)]
pub(super) struct CycleClock {
    rate: Rate,
    /// Period of a cycle as a fraction.
    ticks: u64,
    cycles: u64,
    /// Ticks owed, in units of 1/`cycles`.
    remainder: u64,
}

impl Default for CycleClock {
    fn default() -> Self {
        CycleClock { rate: Rate::STOPPED, ticks: 1, cycles: 1, remainder: 0 }
    }
}

impl CycleClock {
    /// A stopped clock would stop time itself: the chip would be dead, which no firmware survives to notice. It keeps
    /// its last frequency instead, and the caller reports it.
    fn set(&mut self, (numerator, denominator): Hertz) -> bool {
        let rate = Rate::hertz(numerator, denominator);
        if rate.is_stopped() {
            return false;
        }
        if rate != self.rate {
            (self.ticks, self.cycles) = rate.period();
            self.rate = rate;
            self.remainder = 0;
        }
        true
    }

    pub fn rate(&self) -> Rate {
        self.rate
    }

    #[inline]
    pub fn ticks(&mut self, cycles: u32) -> Ticks {
        let due = u64::from(cycles) * self.ticks;
        // At 125 MHz, where nearly all time is spent, a cycle is a tick.
        if self.cycles == 1 {
            return Ticks::new(due);
        }
        let due = due + self.remainder;
        self.remainder = due % self.cycles;
        Ticks::new(due / self.cycles)
    }
}

impl Bus {
    fn clock_sources(&self) -> Sources {
        Sources { pll_sys: self.pll_sys.output(), pll_usb: self.pll_usb.output() }
    }

    pub(super) fn clk_ref(&self) -> Hertz {
        self.clocks.clk_ref(self.clock_sources())
    }

    /// Hands the present frequencies to everything that counts. Returns false if clk_sys would stand still.
    pub(super) fn update_clocks(&mut self) -> bool {
        let (now, sources) = (self.now, self.clock_sources());
        let clk_sys = self.clocks.clk_sys(sources);
        let running = self.cycle_clock.set(clk_sys);
        self.pwm.set_clock(clk_sys, now);
        self.dma.set_clock(clk_sys, now);
        self.dma_engine.set_clock(clk_sys);
        self.adc.set_clock(self.clocks.clk_adc(sources), now);
        let clk_peri = self.clocks.clk_peri(sources);
        for uart in &mut self.uarts {
            uart.set_clock(clk_peri);
        }
        self.update_tick();
        running
    }

    /// Hands the present 1 us tick to the timer and the watchdog.
    pub(super) fn update_tick(&mut self) {
        let tick = self.tick_rate();
        self.timer.set_tick(tick, self.now);
        self.watchdog.set_tick(tick, self.now);
        self.clocks_changed = true;
        self.pause_core = true;
    }
}
