//! SysTick (B3.3). The counter is computed from the time since it was last set, not stepped.

use crate::bus::Bus;
use crate::ticks::{Rate, Ticks};

const ENABLE: u32 = 1 << 0;
const TICKINT: u32 = 1 << 1;
/// Processor clock; 0 is the reference, which on the RP2040 is the watchdog's 1 us tick (datasheet
/// 4.7.2).
const CLKSOURCE: u32 = 1 << 2;
const COUNTFLAG: u32 = 1 << 16;
const COUNTER_BITS: u32 = 0xff_ffff;

/// SYST_CSR, SYST_RVR, SYST_CVR.
#[derive(Clone, Debug)]
pub(super) struct SysTick {
    control: u32,
    reload: u32,
    /// Value of the counter at `since`.
    value: u32,
    since: Ticks,
    rate: Rate,
    /// Passages through zero since `since` that are accounted for.
    zeros_seen: u64,
    count_flag: bool,
}

impl Default for SysTick {
    fn default() -> Self {
        SysTick {
            control: 0,
            reload: 0,
            value: 0,
            since: Ticks::ZERO,
            rate: Rate::STOPPED,
            zeros_seen: 0,
            count_flag: false,
        }
    }
}

impl SysTick {
    /// Counts after `since` until the counter first becomes zero. From zero it first reloads.
    fn first_zero(&self) -> u64 {
        u64::from(if self.value > 0 { self.value } else { self.reload + 1 })
    }

    fn counts(&self, now: Ticks) -> u64 {
        self.rate.counts_in(now.saturating_sub(self.since))
    }

    /// How often the counter has become zero since `since`.
    fn zeros(&self, now: Ticks) -> u64 {
        let counts = self.counts(now);
        match counts.checked_sub(self.first_zero()) {
            Some(beyond) if self.reload > 0 || self.value > 0 => {
                if self.reload == 0 {
                    1
                } else {
                    1 + beyond / (u64::from(self.reload) + 1)
                }
            }
            _ => 0,
        }
    }

    fn current(&self, now: Ticks) -> u32 {
        let counts = self.counts(now);
        match counts.checked_sub(u64::from(self.value)) {
            None => self.value - counts as u32,
            Some(0) => 0,
            Some(_) if self.reload == 0 => 0,
            Some(beyond) => self.reload - ((beyond - 1) % (u64::from(self.reload) + 1)) as u32,
        }
    }

    /// Accounts for the zeros up to `now`. True if the exception becomes pending.
    pub fn advance(&mut self, now: Ticks) -> bool {
        let zeros = self.zeros(now);
        let new = zeros > self.zeros_seen;
        self.zeros_seen = zeros;
        self.count_flag |= new;
        new && self.control & TICKINT != 0
    }

    /// When the counter next becomes zero with the interrupt enabled.
    pub fn next_interrupt(&self) -> Ticks {
        if self.control & (ENABLE | TICKINT) != ENABLE | TICKINT || self.reload == 0 && self.value == 0 {
            return Ticks::NEVER;
        }
        let next = self.first_zero() + self.zeros_seen * (u64::from(self.reload) + 1);
        self.since + self.rate.ticks_for(next)
    }

    /// Makes `now` the counter's new origin, at the clock it has now.
    pub fn restart(&mut self, bus: &Bus) {
        self.advance(bus.now);
        self.value = self.current(bus.now);
        self.since = bus.now;
        self.zeros_seen = 0;
        self.rate = match self.control & (ENABLE | CLKSOURCE) {
            0 | CLKSOURCE => Rate::STOPPED,
            ENABLE => bus.tick_rate(),
            _ => bus.processor_rate(),
        };
    }

    pub fn read_control(&mut self, now: Ticks) -> u32 {
        self.advance(now);
        self.control | if std::mem::take(&mut self.count_flag) { COUNTFLAG } else { 0 }
    }

    pub fn write_control(&mut self, bus: &Bus, value: u32) {
        self.restart(bus);
        self.control = value & (ENABLE | TICKINT | CLKSOURCE);
        self.restart(bus);
    }

    pub fn read_reload(&self) -> u32 {
        self.reload
    }

    pub fn write_reload(&mut self, bus: &Bus, value: u32) {
        self.restart(bus);
        self.reload = value & COUNTER_BITS;
    }

    pub fn read_current(&self, now: Ticks) -> u32 {
        self.current(now)
    }

    /// Any write clears the counter and COUNTFLAG.
    pub fn clear_current(&mut self, bus: &Bus) {
        self.restart(bus);
        self.value = 0;
        self.count_flag = false;
    }
}
