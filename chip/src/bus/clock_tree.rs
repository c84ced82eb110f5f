//! From the oscillators to the consumers: recomputed whenever CLOCKS, a PLL or the watchdog's tick
//! is written.

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
    /// What a few cycles take, by their number: nearly all instructions need no division.
    few: [Duration; FEW],
}

/// Instructions take up to so many cycles, less one, unless they wait for flash or load and store
/// many registers.
const FEW: usize = 16;

/// Whole ticks, and the rest in units of 1/`cycles`.
#[derive(Clone, Copy, Debug, Default)]
struct Duration {
    ticks: u64,
    rest: u64,
}

impl Default for CycleClock {
    fn default() -> Self {
        CycleClock { rate: Rate::STOPPED, ticks: 1, cycles: 1, remainder: 0, few: Default::default() }
    }
}

impl CycleClock {
    /// A stopped clock would stop time itself: the chip would be dead, which no firmware survives
    /// to notice. It keeps its last frequency instead, and the caller reports it.
    fn set(&mut self, (numerator, denominator): Hertz) -> bool {
        let rate = Rate::hertz(numerator, denominator);
        if rate.is_stopped() {
            return false;
        }
        if rate != self.rate {
            (self.ticks, self.cycles) = rate.period();
            self.rate = rate;
            self.remainder = 0;
            self.few = std::array::from_fn(|cycles| {
                let due = cycles as u64 * self.ticks;
                Duration { ticks: due / self.cycles, rest: due % self.cycles }
            });
        }
        true
    }

    pub fn rate(&self) -> Rate {
        self.rate
    }

    #[inline]
    pub fn ticks(&mut self, cycles: u32) -> Ticks {
        let Some(time) = self.few.get(cycles as usize) else { return self.ticks_of_many(cycles) };
        // Both are less than a tick, so together less than two.
        let rest = self.remainder + time.rest;
        let carry = rest >= self.cycles;
        self.remainder = if carry { rest - self.cycles } else { rest };
        Ticks::new(time.ticks + u64::from(carry))
    }

    /// The least number of cycles after which `time` has passed, or one that is smaller where that
    /// is very long.
    #[inline]
    pub fn cycles_to_pass(&self, time: Ticks) -> u32 {
        const LONG: u64 = 1 << 24;
        let time = time.get().min(LONG);
        // At 125 MHz, where nearly all time is spent, a cycle is a tick.
        if self.ticks == 1 && self.cycles == 1 {
            return time as u32;
        }
        let cycles = (time * self.cycles).saturating_sub(self.remainder).div_ceil(self.ticks);
        u32::try_from(cycles).unwrap_or(u32::MAX)
    }

    fn ticks_of_many(&mut self, cycles: u32) -> Ticks {
        let due = u64::from(cycles) * self.ticks + self.remainder;
        self.remainder = due % self.cycles;
        Ticks::new(due / self.cycles)
    }
}

impl Bus {
    fn clock_sources(&self) -> Sources {
        Sources { rosc: self.rosc.output(), pll_sys: self.pll_sys.output(), pll_usb: self.pll_usb.output() }
    }

    pub(super) fn clk_ref(&self) -> Hertz {
        self.clocks.clk_ref(self.clock_sources())
    }

    /// Hands the present frequencies to everything that counts. Returns false if clk_sys would
    /// stand still.
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
        for i2c in &mut self.i2c {
            i2c.set_clock(clk_sys);
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
        self.pause_core();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(hertz: Hertz) -> CycleClock {
        let mut clock = CycleClock::default();
        assert!(clock.set(hertz));
        clock
    }

    #[test]
    fn no_fraction_of_a_tick_is_lost() {
        for hertz in [(6_500_000, 1), (12_000_000, 1), (48_000_000, 7), (125_000_000, 1), (133_000_000, 1)] {
            let mut clock = clock(hertz);
            let (ticks, cycles) = clock.rate.period();
            let (mut spent, mut passed) = (0, 0);
            for n in 0..100_000_u32 {
                let now = n * 7 % 23;
                spent += u64::from(now);
                let wait = Ticks::new(u64::from(n % 1_000));
                let enough = clock.cycles_to_pass(wait);
                assert!(clock.clone().ticks(enough) >= wait);
                assert!(enough == 0 || clock.clone().ticks(enough - 1) < wait);
                passed += clock.ticks(now).get();
                assert_eq!(passed, spent * ticks / cycles, "after {spent} cycles at {hertz:?}");
            }
        }
    }
}
