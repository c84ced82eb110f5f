//! One PWM slice (4.5.2): a counter, its wrap value and two compare values, the latter three
//! double-buffered.

use crate::peripherals::Written;
use crate::ticks::{Rate, Ticks};

/// CSR.
const EN: u32 = 1 << 0;
const PH_CORRECT: u32 = 1 << 1;
const A_INV: u32 = 1 << 2;
const B_INV: u32 = 1 << 3;
const DIVMODE: u32 = 3 << 4;
const PH_RET: u32 = 1 << 6;
const PH_ADV: u32 = 1 << 7;

/// One slice. The phase counts from 0 to [`Slice::period`] - 1; the counter follows from it.
#[derive(Clone, Debug)]
pub(crate) struct Slice {
    control: u32,
    /// 8.4 fixed point.
    divider: u32,
    top: u32,
    compare: [u32; 2],
    /// TOP and CC as last written; they take effect at the next wrap while the slice runs.
    waiting_top: u32,
    waiting_compare: [u32; 2],
    /// Phase at `since`.
    phase: u64,
    since: Ticks,
    rate: Rate,
    /// Wraps since `since` that are accounted for.
    wraps_seen: u64,
    /// The edge that was last announced and passed.
    looked_at: Ticks,
}

impl Default for Slice {
    fn default() -> Self {
        Slice {
            control: 0,
            divider: 1 << 4,
            top: 0xffff,
            compare: [0; 2],
            waiting_top: 0xffff,
            waiting_compare: [0; 2],
            phase: 0,
            since: Ticks::ZERO,
            rate: Rate::STOPPED,
            wraps_seen: 0,
            looked_at: Ticks::ZERO,
        }
    }
}

impl Slice {
    pub fn control(&self) -> u32 {
        self.control
    }

    pub fn divider(&self) -> u32 {
        self.divider
    }

    pub fn is_enabled(&self) -> bool {
        self.control & EN != 0
    }

    pub fn written_top(&self) -> u32 {
        self.waiting_top
    }

    pub fn written_compare(&self) -> u32 {
        self.waiting_compare[0] | self.waiting_compare[1] << 16
    }

    fn phase_correct(&self) -> bool {
        self.control & PH_CORRECT != 0
    }

    /// Counts of one period: up from 0 to TOP, and in phase-correct mode down again (4.5.2.1).
    fn period(&self) -> u64 {
        let ramp = u64::from(self.top) + 1;
        if self.phase_correct() { 2 * ramp } else { ramp }
    }

    /// Counts since the phase was zero at or before `since`.
    fn counts(&self, now: Ticks) -> u64 {
        self.phase + self.rate.counts_in(now.saturating_sub(self.since))
    }

    /// The counter, 0 to TOP.
    pub fn counter(&self, now: Ticks) -> u32 {
        let phase = self.counts(now) % self.period();
        let top = u64::from(self.top);
        (if phase <= top { phase } else { 2 * top + 1 - phase }) as u32
    }

    /// Level of channel A or B: high while the counter is below its compare value.
    pub fn output(&self, channel_b: bool, now: Ticks) -> bool {
        (self.counter(now) < self.compare[usize::from(channel_b)]) != self.inverted(channel_b)
    }

    fn inverted(&self, channel_b: bool) -> bool {
        self.control & (if channel_b { B_INV } else { A_INV }) != 0
    }

    /// Part of the period in which a channel is high, 0 to 1. A slice that stands still is high or
    /// low altogether.
    pub fn duty(&self, channel_b: bool, now: Ticks) -> f64 {
        if self.rate.is_stopped() {
            return f64::from(u8::from(self.output(channel_b, now)));
        }
        let counts = f64::from(self.top) + 1.0;
        let high = (f64::from(self.compare[usize::from(channel_b)]) / counts).min(1.0);
        if self.inverted(channel_b) { 1.0 - high } else { high }
    }

    /// Duration of a period; never for a slice that stands still.
    pub fn period_ticks(&self) -> Ticks {
        self.rate.ticks_for(self.period())
    }

    /// Makes `now` the origin, with the rate the settings ask for.
    fn restart(&mut self, clock: (u64, u64), now: Ticks) {
        self.phase = self.counts(now) % self.period();
        self.since = now;
        self.wraps_seen = 0;
        self.looked_at = now;
        // The integer part 0 means 256.
        let divider = if self.divider < 16 { self.divider + 4096 } else { self.divider };
        self.rate = if self.is_enabled() && self.control & DIVMODE == 0 {
            Rate::hertz(clock.0 * 16, clock.1 * u64::from(divider))
        } else {
            Rate::STOPPED
        };
    }

    pub fn set_clock(&mut self, clock: (u64, u64), now: Ticks) {
        self.restart(clock, now);
    }

    pub fn set_enabled(&mut self, enabled: bool, clock: (u64, u64), now: Ticks) {
        self.control = if enabled { self.control | EN } else { self.control & !EN };
        self.restart(clock, now);
    }

    /// `ones`: PH_RET and PH_ADV act when written and read as zero: they retard or advance the
    /// counter by one.
    pub fn write_control(&mut self, value: u32, ones: u32, clock: (u64, u64), now: Ticks) -> Written {
        self.phase = self.counts(now) % self.period();
        self.since = now;
        self.control = value & (EN | PH_CORRECT | A_INV | B_INV | DIVMODE);
        self.restart(clock, now);
        // The other modes count edges or levels of the B pin.
        if value & DIVMODE != 0 || ones & (PH_RET | PH_ADV) != 0 {
            return Written::ValueNotModelled;
        }
        Written::Done
    }

    pub fn write_divider(&mut self, value: u32, clock: (u64, u64), now: Ticks) -> Written {
        self.restart(clock, now);
        self.divider = value & 0xfff;
        self.restart(clock, now);
        Written::Done
    }

    pub fn write_counter(&mut self, value: u32, now: Ticks) -> Written {
        self.phase = u64::from(value & 0xffff) % self.period();
        self.since = now;
        self.wraps_seen = 0;
        Written::Done
    }

    pub fn write_compare(&mut self, value: u32, now: Ticks) -> Written {
        self.waiting_compare = [value & 0xffff, value >> 16];
        self.take_over_if_stopped(now);
        Written::Done
    }

    pub fn write_top(&mut self, value: u32, now: Ticks) -> Written {
        self.waiting_top = value & 0xffff;
        self.take_over_if_stopped(now);
        Written::Done
    }

    /// A slice that stands still would never wrap: it takes new values at once.
    fn take_over_if_stopped(&mut self, now: Ticks) {
        if self.rate.is_stopped() {
            self.phase = u64::from(self.counter(now));
            self.take_over();
            self.phase %= self.period();
            self.since = now;
        }
    }

    fn take_over(&mut self) {
        self.top = self.waiting_top;
        self.compare = self.waiting_compare;
    }

    /// TOP or CC has been written and waits for the wrap.
    pub fn has_waiting_values(&self) -> bool {
        !self.rate.is_stopped() && (self.top != self.waiting_top || self.compare != self.waiting_compare)
    }

    fn time_of(&self, counts: u64) -> Ticks {
        self.since + self.rate.ticks_for(counts - self.phase)
    }

    /// When the counter next wraps.
    pub fn next_wrap(&self) -> Ticks {
        if self.rate.is_stopped() {
            Ticks::NEVER
        } else {
            self.time_of((self.wraps_seen + 1) * self.period())
        }
    }

    /// When an output next may change: at a compare match or the wrap, whichever is first after
    /// what was last looked at.
    pub fn next_edge(&self) -> Ticks {
        if self.rate.is_stopped() {
            return Ticks::NEVER;
        }
        let period_start = self.wraps_seen * self.period();
        let top = u64::from(self.top);
        let mut next = self.next_wrap();
        for compare in self.compare.map(u64::from).into_iter().filter(|c| (1..=top).contains(c)) {
            let falling = period_start + compare;
            let rising = period_start + 2 * (top + 1) - compare;
            for match_at in [Some(falling), self.phase_correct().then_some(rising)].into_iter().flatten() {
                if match_at > self.phase {
                    let at = self.time_of(match_at);
                    if at > self.looked_at {
                        next = next.min(at);
                    }
                }
            }
        }
        next
    }

    /// Accounts for everything up to `now`. True if the counter wrapped.
    pub fn advance(&mut self, now: Ticks) -> bool {
        self.looked_at = now;
        let mut wrapped = false;
        while self.next_wrap() <= now {
            wrapped = true;
            if self.has_waiting_values() {
                // From the wrap on the new period counts; the wrap is the new origin.
                let wrap = self.next_wrap();
                self.take_over();
                self.phase = 0;
                self.since = wrap;
                self.wraps_seen = 0;
            } else {
                self.wraps_seen = self.counts(now) / self.period();
            }
        }
        wrapped
    }
}
