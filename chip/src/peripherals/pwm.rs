//! PWM (4.5): eight slices with real counters, computed from the time they started.

mod slice;

#[cfg(test)]
mod tests;

use super::{RegisterWrite, Written};
use crate::ticks::Ticks;

pub(crate) use slice::Slice;

/// Register offsets (4.5.3): five registers a slice, then the common ones.
const SLICE_STRIDE: u32 = 0x14;
const CSR: u32 = 0x00;
const DIV: u32 = 0x04;
const CTR: u32 = 0x08;
const CC: u32 = 0x0c;
const TOP: u32 = 0x10;
const EN: u32 = 0xa0;
const INTR: u32 = 0xa4;
const INTE: u32 = 0xa8;
const INTF: u32 = 0xac;
const INTS: u32 = 0xb0;

/// Number of slices.
pub(crate) const SLICES: usize = 8;

/// The PWM block.
#[derive(Clone, Debug)]
pub(crate) struct Pwm {
    slices: [Slice; SLICES],
    raw: u32,
    enable: u32,
    force: u32,
    /// clk_sys as numerator and denominator, hertz.
    clock: (u64, u64),
    /// Slices of which every compare match and wrap is an event, because somebody looks at their
    /// pins.
    watched: u32,
    /// Slices whose wraps pace a DMA channel.
    pacing: u32,
    /// Wraps since the last [`Pwm::take_wraps`], by slice.
    wraps: u32,
    /// [`Pwm::next_event`], recomputed when something changes.
    next_event: Ticks,
}

impl Default for Pwm {
    fn default() -> Self {
        Pwm {
            slices: Default::default(),
            raw: 0,
            enable: 0,
            force: 0,
            clock: (0, 1),
            watched: 0,
            pacing: 0,
            wraps: 0,
            next_event: Ticks::NEVER,
        }
    }
}

impl Pwm {
    pub fn reset(&mut self) {
        *self = Pwm { clock: self.clock, watched: self.watched, pacing: self.pacing, ..Pwm::default() };
    }

    /// clk_sys is now `clock` hertz.
    pub fn set_clock(&mut self, clock: (u64, u64), now: Ticks) {
        self.clock = clock;
        for slice in &mut self.slices {
            slice.set_clock(clock, now);
        }
        self.reschedule();
    }

    /// The slice behind a pin, and whether the pin is its channel B (4.5.2).
    pub fn slice_of(&self, pin: usize) -> (&Slice, bool) {
        (&self.slices[slice_number(pin)], pin % 2 == 1)
    }

    /// Looks at the slices behind `pins` edge by edge.
    pub fn watch_pins(&mut self, pins: u32, now: Ticks) {
        self.catch_up(now);
        self.watched =
            (0..30).filter(|pin| pins >> pin & 1 != 0).fold(0, |set, pin| set | 1 << slice_number(pin));
        self.reschedule();
    }

    /// Slices whose wraps DMA waits for.
    pub fn set_pacing(&mut self, slices: u32, now: Ticks) {
        if slices != self.pacing {
            self.catch_up(now);
            // Wraps before somebody waited for them are no requests.
            self.wraps &= self.pacing;
            self.pacing = slices;
            self.reschedule();
        }
    }

    pub fn read(&mut self, offset: u32, now: Ticks) -> Option<u32> {
        self.catch_up(now);
        if offset < EN {
            let slice = &self.slices[(offset / SLICE_STRIDE) as usize];
            return Some(match offset % SLICE_STRIDE {
                CSR => slice.control(),
                DIV => slice.divider(),
                CTR => slice.counter(now),
                CC => slice.written_compare(),
                _ => slice.written_top(),
            });
        }
        Some(match offset {
            EN => (0..SLICES).map(|i| u32::from(self.slices[i].is_enabled()) << i).sum(),
            INTR => self.raw,
            INTE => self.enable,
            INTF => self.force,
            INTS => self.status(),
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        self.catch_up(now);
        let written = self.write_register(offset, write, now);
        self.reschedule();
        written
    }

    fn write_register(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        if offset < EN {
            let clock = self.clock;
            let slice = &mut self.slices[(offset / SLICE_STRIDE) as usize];
            return match offset % SLICE_STRIDE {
                CSR => slice.write_control(write.onto(slice.control()), write.ones(), clock, now),
                DIV => slice.write_divider(write.onto(slice.divider()), clock, now),
                CTR => slice.write_counter(write.onto(slice.counter(now)), now),
                CC => slice.write_compare(write.onto(slice.written_compare()), now),
                TOP => slice.write_top(write.onto(slice.written_top()), now),
                _ => Written::NotModelled,
            };
        }
        match offset {
            EN => {
                let old = (0..SLICES).fold(0, |set, i| set | u32::from(self.slices[i].is_enabled()) << i);
                let new = write.onto(old);
                for (i, slice) in self.slices.iter_mut().enumerate() {
                    slice.set_enabled(new >> i & 1 != 0, self.clock, now);
                }
            }
            INTR => self.raw &= !write.ones(),
            INTE => self.enable = write.onto(self.enable) & 0xff,
            INTF => self.force = write.onto(self.force) & 0xff,
            INTS => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    fn status(&self) -> u32 {
        self.raw & self.enable | self.force
    }

    /// The interrupt line PWM_IRQ_WRAP.
    pub fn interrupt(&self) -> bool {
        self.status() != 0
    }

    /// When somebody next has to look: at wraps that interrupt, pace DMA or take over new values,
    /// and at every edge of a watched slice.
    pub fn next_event(&self) -> Ticks {
        self.next_event
    }

    fn reschedule(&mut self) {
        let needs_wrap = self.enable | self.pacing;
        let mut next = Ticks::NEVER;
        for (i, slice) in self.slices.iter().enumerate() {
            if self.watched >> i & 1 != 0 {
                next = next.min(slice.next_edge());
            } else if needs_wrap >> i & 1 != 0 || slice.has_waiting_values() {
                next = next.min(slice.next_wrap());
            }
        }
        self.next_event = next;
    }

    pub fn advance(&mut self, now: Ticks) {
        if now >= self.next_event {
            self.catch_up(now);
            self.reschedule();
        }
    }

    /// Accounts for all wraps up to `now`, also those nobody waited for: INTR latches them.
    fn catch_up(&mut self, now: Ticks) {
        for (i, slice) in self.slices.iter_mut().enumerate() {
            if slice.advance(now) {
                self.raw |= 1 << i;
                self.wraps |= 1 << i;
            }
        }
    }

    /// Slices that wrapped since the last call.
    pub fn take_wraps(&mut self) -> u32 {
        std::mem::take(&mut self.wraps)
    }
}

/// Pins 0 to 15 are channels A and B of slices 0 to 7, and so on from pin 16.
fn slice_number(pin: usize) -> usize {
    pin / 2 % SLICES
}
