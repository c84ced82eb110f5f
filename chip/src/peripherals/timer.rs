//! TIMER (4.6): 64 bits of microseconds and four alarms on the lower 32.

#[cfg(test)]
mod tests;

use super::{RegisterWrite, Written};
use crate::ticks::{Rate, Ticks};

/// Register offsets (4.6.5).
const TIMEHW: u32 = 0x00;
const TIMELW: u32 = 0x04;
const TIMEHR: u32 = 0x08;
const TIMELR: u32 = 0x0c;
const ALARM0: u32 = 0x10;
const ALARM3: u32 = 0x1c;
const ARMED: u32 = 0x20;
const TIMERAWH: u32 = 0x24;
const TIMERAWL: u32 = 0x28;
const DBGPAUSE: u32 = 0x2c;
const PAUSE: u32 = 0x30;
const INTR: u32 = 0x34;
const INTE: u32 = 0x38;
const INTF: u32 = 0x3c;
const INTS: u32 = 0x40;

const ALARMS: u32 = 0xf;

/// The TIMER block.
#[derive(Clone, Debug)]
pub(crate) struct Timer {
    /// Count at `since`.
    base: u64,
    since: Ticks,
    /// The tick the watchdog makes, normally 1 MHz.
    tick: Rate,
    paused: bool,
    debug_pause: u32,
    /// Upper half, latched by reading TIMELR.
    latched_high: u32,
    /// Lower half waiting for TIMEHW.
    written_low: u32,
    alarms: [u32; 4],
    /// Count at which each armed alarm fires.
    armed: [Option<u64>; 4],
    raw: u32,
    enable: u32,
    force: u32,
}

impl Default for Timer {
    fn default() -> Self {
        Timer {
            base: 0,
            since: Ticks::ZERO,
            tick: Rate::STOPPED,
            paused: false,
            debug_pause: 7,
            latched_high: 0,
            written_low: 0,
            alarms: [0; 4],
            armed: [None; 4],
            raw: 0,
            enable: 0,
            force: 0,
        }
    }
}

impl Timer {
    pub fn reset(&mut self, now: Ticks) {
        *self = Timer { tick: self.tick, since: now, ..Timer::default() };
    }

    fn rate(&self) -> Rate {
        if self.paused { Rate::STOPPED } else { self.tick }
    }

    /// Microseconds counted.
    pub fn count(&self, now: Ticks) -> u64 {
        self.base.wrapping_add(self.rate().counts_in(now.saturating_sub(self.since)))
    }

    fn restart(&mut self, now: Ticks) {
        self.base = self.count(now);
        self.since = now;
    }

    /// The watchdog's tick changed.
    pub fn set_tick(&mut self, tick: Rate, now: Ticks) {
        if tick != self.tick {
            self.restart(now);
            self.tick = tick;
        }
    }

    pub fn read(&mut self, offset: u32, now: Ticks) -> Option<u32> {
        let count = self.count(now);
        Some(match offset {
            TIMEHW | TIMELW => 0,
            TIMEHR => self.latched_high,
            TIMELR => {
                self.latched_high = (count >> 32) as u32;
                count as u32
            }
            ALARM0..=ALARM3 => self.alarms[((offset - ALARM0) / 4) as usize],
            ARMED => (0..4).map(|i| u32::from(self.armed[i].is_some()) << i).sum(),
            TIMERAWH => (count >> 32) as u32,
            TIMERAWL => count as u32,
            DBGPAUSE => self.debug_pause,
            PAUSE => u32::from(self.paused),
            INTR => self.raw,
            INTE => self.enable,
            INTF => self.force,
            INTS => self.status(),
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        match offset {
            TIMELW => self.written_low = write.raw,
            TIMEHW => {
                self.base = u64::from(write.raw) << 32 | u64::from(self.written_low);
                self.since = now;
            }
            ALARM0..=ALARM3 => self.arm(((offset - ALARM0) / 4) as usize, write, now),
            ARMED => {
                for (i, armed) in self.armed.iter_mut().enumerate() {
                    if write.ones() >> i & 1 != 0 {
                        *armed = None;
                    }
                }
            }
            // No debugger ever halts this core.
            DBGPAUSE => self.debug_pause = write.onto(self.debug_pause) & 7,
            PAUSE => {
                self.restart(now);
                self.paused = write.onto(u32::from(self.paused)) & 1 != 0;
            }
            INTR => self.raw &= !write.ones(),
            INTE => self.enable = write.onto(self.enable) & ALARMS,
            INTF => self.force = write.onto(self.force) & ALARMS,
            TIMEHR | TIMELR | TIMERAWH | TIMERAWL | INTS => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    /// Writing an alarm arms it for the next time the lower half *becomes* equal to it: one written
    /// at its own time fires 71 minutes later.
    fn arm(&mut self, alarm: usize, write: RegisterWrite, now: Ticks) {
        self.alarms[alarm] = write.onto(self.alarms[alarm]);
        let count = self.count(now);
        let wait = match self.alarms[alarm].wrapping_sub(count as u32) {
            0 => 1 << 32,
            wait => u64::from(wait),
        };
        self.armed[alarm] = Some(count.wrapping_add(wait));
    }

    fn status(&self) -> u32 {
        self.raw & self.enable | self.force
    }

    /// When the next armed alarm fires.
    pub fn next_event(&self) -> Ticks {
        match self.armed.iter().flatten().min() {
            Some(count) => self.since + self.rate().ticks_for(count.wrapping_sub(self.base)),
            None => Ticks::NEVER,
        }
    }

    pub fn advance(&mut self, now: Ticks) {
        let count = self.count(now);
        for (i, armed) in self.armed.iter_mut().enumerate() {
            if armed.is_some_and(|at| at <= count) {
                *armed = None;
                self.raw |= 1 << i;
            }
        }
    }

    /// Interrupt lines TIMER_IRQ_0 to 3.
    pub fn interrupts(&self) -> u32 {
        self.status()
    }
}
