//! WATCHDOG (4.7): countdown, forced reset, scratch registers and the 1 us tick for TIMER and
//! SysTick.

#[cfg(test)]
mod tests;

use super::{RegisterWrite, Written};
use crate::report::ResetReason;
use crate::ticks::{Rate, Ticks};

/// Register offsets (4.7.6).
const CTRL: u32 = 0x00;
const LOAD: u32 = 0x04;
const REASON: u32 = 0x08;
const SCRATCH0: u32 = 0x0c;
const SCRATCH7: u32 = 0x28;
const TICK: u32 = 0x2c;

/// CTRL.
const TIME: u32 = 0xff_ffff;
const PAUSE_BITS: u32 = 7 << 24;
const ENABLE: u32 = 1 << 30;
const TRIGGER: u32 = 1 << 31;

/// REASON.
const REASON_TIMER: u32 = 1 << 0;
const REASON_FORCE: u32 = 1 << 1;

/// TICK.
const TICK_CYCLES: u32 = 0x1ff;
const TICK_ENABLE: u32 = 1 << 9;
const TICK_RUNNING: u32 = 1 << 10;

/// The counter goes down by two a tick (erratum RP2040-E1).
const COUNTS_PER_TICK: u64 = 2;

/// The WATCHDOG block.
#[derive(Clone, Debug)]
pub(crate) struct Watchdog {
    control: u32,
    /// Counter at `since`.
    counter: u32,
    since: Ticks,
    reason: u32,
    scratch: [u32; 8],
    tick_control: u32,
    tick: Rate,
    fired: Option<ResetReason>,
}

impl Default for Watchdog {
    fn default() -> Self {
        Watchdog {
            control: PAUSE_BITS,
            counter: 0,
            since: Ticks::ZERO,
            reason: 0,
            scratch: [0; 8],
            tick_control: TICK_ENABLE,
            tick: Rate::STOPPED,
            fired: None,
        }
    }
}

impl Watchdog {
    /// The watchdog's own reset: scratch registers and the reason stay (4.7.4).
    pub fn restart_after(&mut self, reason: ResetReason) {
        let reason = match reason {
            ResetReason::WatchdogTimer => REASON_TIMER,
            ResetReason::WatchdogForce => REASON_FORCE,
            ResetReason::PowerOn | ResetReason::SystemResetRequest => self.reason,
        };
        *self = Watchdog { reason, scratch: self.scratch, ..Watchdog::default() };
    }

    /// clk_ref cycles of one tick; none while the tick is off.
    pub fn tick_cycles(&self) -> Option<u64> {
        let cycles = self.tick_control & TICK_CYCLES;
        (self.tick_control & TICK_ENABLE != 0 && cycles > 0).then_some(u64::from(cycles))
    }

    /// The tick as it results from TICK and clk_ref.
    pub fn set_tick(&mut self, tick: Rate, now: Ticks) {
        if tick != self.tick {
            self.restart_countdown(now);
            self.tick = tick;
        }
    }

    fn rate(&self) -> Rate {
        if self.control & ENABLE != 0 { self.tick } else { Rate::STOPPED }
    }

    fn counter(&self, now: Ticks) -> u32 {
        let gone = COUNTS_PER_TICK * self.rate().counts_in(now.saturating_sub(self.since));
        u64::from(self.counter).saturating_sub(gone) as u32
    }

    fn restart_countdown(&mut self, now: Ticks) {
        self.counter = self.counter(now);
        self.since = now;
    }

    pub fn read(&self, offset: u32, now: Ticks) -> Option<u32> {
        Some(match offset {
            CTRL => self.control | self.counter(now),
            LOAD => 0,
            REASON => self.reason,
            SCRATCH0..=SCRATCH7 => self.scratch[((offset - SCRATCH0) / 4) as usize],
            TICK => self.tick_control | if self.tick_cycles().is_some() { TICK_RUNNING } else { 0 },
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        match offset {
            CTRL => {
                self.restart_countdown(now);
                // No debugger ever halts this core, so the pause bits are only stored.
                let value = write.onto(self.control);
                self.control = value & (PAUSE_BITS | ENABLE);
                if value & TRIGGER != 0 {
                    self.fired = Some(ResetReason::WatchdogForce);
                }
            }
            LOAD => {
                self.counter = write.raw & TIME;
                self.since = now;
            }
            SCRATCH0..=SCRATCH7 => {
                let scratch = &mut self.scratch[((offset - SCRATCH0) / 4) as usize];
                *scratch = write.onto(*scratch);
            }
            TICK => self.tick_control = write.onto(self.tick_control) & (TICK_CYCLES | TICK_ENABLE),
            REASON => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    /// When the counter reaches zero.
    pub fn next_event(&self) -> Ticks {
        if self.fired.is_some() {
            return Ticks::ZERO;
        }
        self.since + self.rate().ticks_for(u64::from(self.counter).div_ceil(COUNTS_PER_TICK))
    }

    pub fn advance(&mut self, now: Ticks) {
        if self.fired.is_none()
            && self.control & ENABLE != 0
            && self.counter(now) == 0
            && !self.tick.is_stopped()
        {
            self.fired = Some(ResetReason::WatchdogTimer);
            // It fires once: the reset that follows clears ENABLE too.
            self.control &= !ENABLE;
        }
    }

    /// The reset it asks for, once.
    pub fn take_reset(&mut self) -> Option<ResetReason> {
        self.fired.take()
    }
}
