//! DMA (2.5): twelve channels with four alias register blocks, chaining, rings, pacing and two
//! interrupt lines.
//!
//! This file has the registers; what a transfer does to the bus is in `bus/dma_engine.rs`.

mod channel;

#[cfg(test)]
mod tests;

use super::{RegisterWrite, Written};
use crate::ticks::{Rate, Ticks};

pub(crate) use channel::{Channel, Transfer, TransferError};

/// Register offsets (2.5.7): 0x40 bytes a channel, then the common ones.
const CHANNEL_STRIDE: u32 = 0x40;
const END_OF_CHANNELS: u32 = 0x300;
const INTR: u32 = 0x400;
const INTE0: u32 = 0x404;
const INTF0: u32 = 0x408;
const INTS0: u32 = 0x40c;
const INTE1: u32 = 0x414;
const INTF1: u32 = 0x418;
const INTS1: u32 = 0x41c;
const TIMER0: u32 = 0x420;
const TIMER3: u32 = 0x42c;
const MULTI_CHAN_TRIGGER: u32 = 0x430;
const FIFO_LEVELS: u32 = 0x440;
const CHAN_ABORT: u32 = 0x444;
const N_CHANNELS: u32 = 0x448;

/// Number of channels.
pub(crate) const CHANNELS: usize = 12;
const ALL: u32 = 0xfff;

/// TREQ_SEL of the pacing timers.
const FIRST_TIMER_REQUEST: u32 = 0x3b;

/// The DMA block.
#[derive(Clone, Debug)]
pub(crate) struct Dma {
    pub channels: [Channel; CHANNELS],
    raw: u32,
    enable: [u32; 2],
    force: [u32; 2],
    timers: [PacingTimer; 4],
    clock: (u64, u64),
    /// Next channel in the round robin.
    turn: usize,
    /// TREQ_SEL of the busy channels, bit n for request n.
    awaited: u64,
}

/// TIMER0 to 3: X/Y of clk_sys transfers a second.
#[derive(Clone, Copy, Debug)]
struct PacingTimer {
    setting: u32,
    rate: Rate,
    since: Ticks,
    requests_seen: u64,
}

impl Default for Dma {
    fn default() -> Self {
        let timer = PacingTimer { setting: 0, rate: Rate::STOPPED, since: Ticks::ZERO, requests_seen: 0 };
        Dma {
            channels: std::array::from_fn(Channel::new),
            raw: 0,
            enable: [0; 2],
            force: [0; 2],
            timers: [timer; 4],
            clock: (0, 1),
            turn: 0,
            awaited: 0,
        }
    }
}

impl PacingTimer {
    fn restart(&mut self, clock: (u64, u64), now: Ticks) {
        let (x, y) = (u64::from(self.setting >> 16), u64::from(self.setting & 0xffff));
        self.rate = Rate::hertz(clock.0 * x, clock.1 * y);
        self.since = now;
        self.requests_seen = 0;
    }

    /// Requests since the timer was set.
    fn requests(&self, now: Ticks) -> u64 {
        self.rate.counts_in(now.saturating_sub(self.since))
    }
}

impl Dma {
    pub fn reset(&mut self) {
        *self = Dma { clock: self.clock, ..Dma::default() };
    }

    /// clk_sys is now `clock` hertz.
    pub fn set_clock(&mut self, clock: (u64, u64), now: Ticks) {
        self.clock = clock;
        for timer in &mut self.timers {
            timer.restart(clock, now);
        }
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        if offset < END_OF_CHANNELS {
            return Some(self.channels[(offset / CHANNEL_STRIDE) as usize].read(offset % CHANNEL_STRIDE));
        }
        Some(match offset {
            INTR => self.raw,
            INTE0 => self.enable[0],
            INTF0 => self.force[0],
            INTS0 => self.status(0),
            INTE1 => self.enable[1],
            INTF1 => self.force[1],
            INTS1 => self.status(1),
            TIMER0..=TIMER3 => self.timers[((offset - TIMER0) / 4) as usize].setting,
            MULTI_CHAN_TRIGGER | FIFO_LEVELS | CHAN_ABORT => 0,
            N_CHANNELS => CHANNELS as u32,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        let written = self.write_register(offset, write, now);
        self.note_awaited(now);
        written
    }

    /// Aborts one channel: a write to CHAN_ABORT from outside.
    pub fn abort(&mut self, number: usize, now: Ticks) {
        self.channels[number].abort();
        self.note_awaited(now);
    }

    /// The set of busy channels may have changed.
    fn note_awaited(&mut self, now: Ticks) {
        let busy = self.channels.iter().filter(|channel| channel.is_busy());
        let awaited = busy.fold(0, |set, channel| set | 1 << channel.request());
        for (number, timer) in self.timers.iter_mut().enumerate() {
            // What a timer requested before somebody waited for it is lost.
            if (awaited & !self.awaited) >> (FIRST_TIMER_REQUEST as usize + number) & 1 != 0 {
                timer.requests_seen = timer.requests(now);
            }
        }
        self.awaited = awaited;
    }

    fn write_register(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        if offset < END_OF_CHANNELS {
            let number = (offset / CHANNEL_STRIDE) as usize;
            let channel = &mut self.channels[number];
            let written = channel.write(offset % CHANNEL_STRIDE, write);
            if channel.take_interrupt() {
                self.raw |= 1 << number;
            }
            return written;
        }
        match offset {
            INTR | INTS0 | INTS1 => self.raw &= !write.ones(),
            INTE0 => self.enable[0] = write.onto(self.enable[0]) & ALL,
            INTF0 => self.force[0] = write.onto(self.force[0]) & ALL,
            INTE1 => self.enable[1] = write.onto(self.enable[1]) & ALL,
            INTF1 => self.force[1] = write.onto(self.force[1]) & ALL,
            TIMER0..=TIMER3 => {
                let timer = &mut self.timers[((offset - TIMER0) / 4) as usize];
                timer.setting = write.onto(timer.setting);
                timer.restart(self.clock, now);
            }
            MULTI_CHAN_TRIGGER => {
                for number in (0..CHANNELS).filter(|n| write.ones() >> n & 1 != 0) {
                    self.trigger(number);
                }
            }
            CHAN_ABORT => {
                for (number, channel) in self.channels.iter_mut().enumerate() {
                    if write.ones() >> number & 1 != 0 {
                        channel.abort();
                    }
                }
            }
            FIFO_LEVELS | N_CHANNELS => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    fn trigger(&mut self, number: usize) {
        self.channels[number].trigger();
        if self.channels[number].take_interrupt() {
            self.raw |= 1 << number;
        }
    }

    fn status(&self, line: usize) -> u32 {
        self.raw & self.enable[line] | self.force[line]
    }

    /// The interrupt line DMA_IRQ_0 or DMA_IRQ_1.
    pub fn interrupt(&self, line: usize) -> bool {
        self.status(line) != 0
    }

    pub fn any_busy(&self) -> bool {
        self.awaited != 0
    }

    /// The channel whose turn it is among those that are busy and requested: high priority first,
    /// then round robin (2.5.1).
    pub fn choose(&self, requested: impl Fn(&Channel) -> bool) -> Option<usize> {
        let ready = |number: &usize| {
            let channel = &self.channels[*number];
            channel.is_busy() && (channel.has_credit() || requested(channel))
        };
        let order = || (0..CHANNELS).map(|i| (self.turn + i) % CHANNELS);
        order().filter(|n| self.channels[*n].is_high_priority()).find(ready).or_else(|| order().find(ready))
    }

    /// A transfer of a channel is done: counts it, and at the end raises the interrupt and triggers
    /// the next channel.
    pub fn complete(&mut self, number: usize, result: Result<(), TransferError>, now: Ticks) {
        self.turn = (number + 1) % CHANNELS;
        let finished = match result {
            Ok(()) => self.channels[number].complete(),
            Err(error) => {
                self.channels[number].fail(error);
                None
            }
        };
        if self.channels[number].take_interrupt() {
            self.raw |= 1 << number;
        }
        if let Some(next) = finished.filter(|next| *next != number && *next < CHANNELS) {
            self.trigger(next);
        }
        self.note_awaited(now);
    }

    /// A pulse request (PWM wrap, pacing timer): one credit for every channel that waits for it.
    pub fn pulse(&mut self, request: u32) {
        for channel in &mut self.channels {
            channel.add_credit(request);
        }
    }

    /// PWM slices, as bits, whose wrap some busy channel waits for.
    pub fn paced_by_pwm(&self) -> u32 {
        const FIRST_PWM_REQUEST: u32 = 24;
        (self.awaited >> FIRST_PWM_REQUEST) as u32 & 0xff
    }

    fn timer_in_use(&self, number: usize) -> bool {
        self.awaited >> (FIRST_TIMER_REQUEST as usize + number) & 1 != 0
    }

    /// When a pacing timer in use next requests.
    pub fn next_event(&self) -> Ticks {
        if self.awaited >> FIRST_TIMER_REQUEST & 0xf == 0 {
            return Ticks::NEVER;
        }
        let due = |(number, timer): (usize, &PacingTimer)| {
            let used = self.timer_in_use(number);
            if used { timer.since + timer.rate.ticks_for(timer.requests_seen + 1) } else { Ticks::NEVER }
        };
        self.timers.iter().enumerate().map(due).min().unwrap_or(Ticks::NEVER)
    }

    pub fn advance(&mut self, now: Ticks) {
        for number in 0..self.timers.len() {
            let timer = &mut self.timers[number];
            let requests = timer.requests(now);
            let new = requests - timer.requests_seen;
            timer.requests_seen = requests;
            for _ in 0..new.min(channel::MAX_CREDIT) {
                self.pulse(FIRST_TIMER_REQUEST + number as u32);
            }
        }
    }
}
