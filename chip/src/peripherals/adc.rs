//! ADC (4.9): single and free-running conversions, round robin, FIFO, pacing by the clock divider.

#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use super::{RegisterWrite, Written};
use crate::ticks::{Rate, Ticks};

/// Register offsets (4.9.6).
const CS: u32 = 0x00;
const RESULT: u32 = 0x04;
const FCS: u32 = 0x08;
pub(crate) const FIFO: u32 = 0x0c;
const DIV: u32 = 0x10;
const INTR: u32 = 0x14;
const INTE: u32 = 0x18;
const INTF: u32 = 0x1c;
const INTS: u32 = 0x20;

/// CS.
const EN: u32 = 1 << 0;
/// The temperature sensor has power.
const TS_EN: u32 = 1 << 1;
const START_ONCE: u32 = 1 << 2;
const START_MANY: u32 = 1 << 3;
const READY: u32 = 1 << 8;
const ERR: u32 = 1 << 9;
const ERR_STICKY: u32 = 1 << 10;
const AINSEL: u32 = 7 << 12;
const CS_STORED: u32 = EN | TS_EN | START_MANY | AINSEL | 0x1f << 16;

/// FCS.
const FIFO_EN: u32 = 1 << 0;
const SHIFT: u32 = 1 << 1;
const ERR_IN_FIFO: u32 = 1 << 2;
const DREQ_EN: u32 = 1 << 3;
const UNDER: u32 = 1 << 10;
const OVER: u32 = 1 << 11;
const FCS_STORED: u32 = 0x0f00_000f;

/// FIFO: the conversion failed, if ERR_IN_FIFO asks for it.
const ENTRY_ERR: u16 = 1 << 15;

/// Entries of the FIFO.
const FIFO_DEPTH: usize = 4;
/// clk_adc cycles of one conversion.
const CONVERSION_CYCLES: u64 = 96;
/// Inputs: GPIO26 to 29 and the temperature sensor.
pub(crate) const CHANNELS: usize = 5;
/// The temperature sensor's.
const TEMPERATURE: usize = 4;
/// Temperature sensor at 27 degrees Celsius: 0.706 V of 3.3 V (4.9.5).
const ROOM_TEMPERATURE: u16 = 876;

/// How often an input has been converted, and when last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conversions {
    /// Conversions finished.
    pub count: u64,
    /// Start of the last one, which is when the input was sampled; zero if there was none.
    pub last_sampled: Ticks,
}

/// A conversion going on.
#[derive(Clone, Copy, Debug)]
struct Conversion {
    channel: usize,
    value: u16,
    sampled: Ticks,
    done: Ticks,
}

/// The ADC.
#[derive(Clone, Debug)]
pub(crate) struct Adc {
    control: u32,
    result: u32,
    fifo_control: u32,
    fifo: VecDeque<u16>,
    divider: u32,
    interrupt_enable: u32,
    interrupt_force: u32,
    clock: Rate,
    converting: Option<Conversion>,
    /// Free running: when the pacing timer started, and the clk_adc cycles, in 256ths, to its next
    /// start.
    paced_from: Ticks,
    next_start: u64,
    inputs: [u16; CHANNELS],
    failing: bool,
    conversions: [Conversions; CHANNELS],
}

impl Default for Adc {
    fn default() -> Self {
        Adc {
            control: 0,
            result: 0,
            fifo_control: 0,
            fifo: VecDeque::with_capacity(FIFO_DEPTH),
            divider: 0,
            interrupt_enable: 0,
            interrupt_force: 0,
            clock: Rate::STOPPED,
            converting: None,
            paced_from: Ticks::ZERO,
            next_start: 0,
            inputs: [0, 0, 0, 0, ROOM_TEMPERATURE],
            failing: false,
            conversions: [Conversions::default(); CHANNELS],
        }
    }
}

impl Adc {
    /// Registers and FIFO as after reset; the voltages outside stay, and so does what is broken.
    pub fn reset(&mut self) {
        *self = Adc {
            clock: self.clock,
            inputs: self.inputs,
            failing: self.failing,
            conversions: self.conversions,
            ..Adc::default()
        };
    }

    /// clk_adc is now `numerator / denominator` hertz.
    pub fn set_clock(&mut self, (numerator, denominator): (u64, u64), now: Ticks) {
        let clock = Rate::hertz(numerator, denominator);
        if clock != self.clock {
            self.clock = clock;
            self.paced_from = now;
            self.next_start = 0;
        }
    }

    /// Voltage at an input, in 12-bit counts.
    pub fn set_input(&mut self, channel: usize, counts: u16) {
        self.inputs[channel] = counts & 0xfff;
    }

    /// Whether conversions fail from now on.
    pub fn set_failing(&mut self, failing: bool) {
        self.failing = failing;
    }

    pub fn conversions(&self, channel: usize) -> Conversions {
        self.conversions[channel]
    }

    fn threshold(&self) -> usize {
        (self.fifo_control >> 24 & 15) as usize
    }

    fn channel(&self) -> usize {
        ((self.control & AINSEL) >> 12) as usize
    }

    /// The FIFO holds at least THRESH entries: always, if THRESH is 0. embassy-rp's single
    /// conversions rely on that; they would wait for ever otherwise, because they do not use the
    /// FIFO at all.
    fn raw_interrupt(&self) -> u32 {
        u32::from(self.fifo.len() >= self.threshold())
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            CS => {
                let ready = self.control & EN != 0 && self.converting.is_none();
                self.control | if ready { READY } else { 0 }
            }
            RESULT => self.result,
            FCS => {
                let level = self.fifo.len() as u32;
                let empty = u32::from(level == 0) << 8;
                let full = u32::from(self.fifo.len() == FIFO_DEPTH) << 9;
                self.fifo_control | level << 16 | empty | full
            }
            FIFO => match self.fifo.pop_front() {
                Some(entry) => u32::from(entry),
                None => {
                    self.fifo_control |= UNDER;
                    0
                }
            },
            DIV => self.divider,
            INTR => self.raw_interrupt(),
            INTE => self.interrupt_enable,
            INTF => self.interrupt_force,
            INTS => self.raw_interrupt() & self.interrupt_enable | self.interrupt_force,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        match offset {
            CS => return self.write_control(write, now),
            FCS => {
                // UNDER and OVER are cleared by writing ones.
                let sticky = self.fifo_control & (UNDER | OVER) & !write.ones();
                self.fifo_control = write.onto(self.fifo_control) & FCS_STORED | sticky;
            }
            DIV => {
                self.divider = write.onto(self.divider) & 0xff_ffff;
                self.paced_from = now;
                self.next_start = 0;
            }
            INTE => self.interrupt_enable = write.onto(self.interrupt_enable) & 1,
            INTF => self.interrupt_force = write.onto(self.interrupt_force) & 1,
            RESULT | FIFO | INTR | INTS => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    fn write_control(&mut self, write: RegisterWrite, now: Ticks) -> Written {
        let was_running = self.control & START_MANY != 0;
        let value = write.onto(self.control);
        let sticky = self.control & ERR_STICKY & !write.ones();
        self.control = value & CS_STORED | self.control & ERR | sticky;
        if value & EN == 0 {
            self.converting = None;
            return Written::Done;
        }
        if value & START_MANY != 0 && !was_running {
            self.paced_from = now;
            self.next_start = 0;
            self.start_paced(now);
        } else if value & START_ONCE != 0 && self.converting.is_none() {
            self.start(now);
        }
        if self.channel() < CHANNELS { Written::Done } else { Written::ValueNotModelled }
    }

    /// Samples the selected input and starts converting it. `done` is never while clk_adc stands
    /// still.
    fn convert(&mut self, sampled: Ticks, done: Ticks) {
        let channel = self.channel();
        let without_power = channel == TEMPERATURE && self.control & TS_EN == 0;
        let value = self.inputs.get(channel).copied().filter(|_| !without_power).unwrap_or(0);
        if done != Ticks::NEVER {
            self.converting = Some(Conversion { channel, value, sampled, done });
        }
    }

    fn start(&mut self, now: Ticks) {
        self.convert(now, now + self.clock.ticks_for(CONVERSION_CYCLES));
    }

    /// Time of a number of 256ths of clk_adc cycles after the pacing timer's start.
    fn paced_time(&self, cycles_256: u64) -> Ticks {
        self.paced_from + self.clock.ticks_for(cycles_256.div_ceil(256))
    }

    /// Starts the conversion due at `next_start` if it is due, and sets the time of the one after
    /// (register DIV): every 1 + INT + FRAC/256 cycles, or back to back if that is shorter than a
    /// conversion.
    fn start_paced(&mut self, now: Ticks) {
        let start = self.paced_time(self.next_start);
        if start > now || self.converting.is_some() {
            return;
        }
        self.convert(start, self.paced_time(self.next_start + 256 * CONVERSION_CYCLES));
        let period = u64::from(self.divider) + 256;
        self.next_start +=
            if self.divider == 0 { 256 * CONVERSION_CYCLES } else { period.max(256 * CONVERSION_CYCLES) };
    }

    fn free_running(&self) -> bool {
        self.control & (EN | START_MANY) == EN | START_MANY && !self.clock.is_stopped()
    }

    pub fn next_event(&self) -> Ticks {
        match self.converting {
            Some(conversion) => conversion.done,
            None if self.free_running() => self.paced_time(self.next_start),
            None => Ticks::NEVER,
        }
    }

    /// Finishes and starts what is due up to `now`.
    pub fn advance(&mut self, now: Ticks) {
        loop {
            match self.converting {
                Some(conversion) if conversion.done <= now => self.finish(conversion),
                None if self.free_running() && self.paced_time(self.next_start) <= now => {
                    self.start_paced(now)
                }
                _ => break,
            }
        }
    }

    fn finish(&mut self, conversion: Conversion) {
        self.converting = None;
        self.result = u32::from(conversion.value);
        let statistics = &mut self.conversions[conversion.channel.min(CHANNELS - 1)];
        statistics.count += 1;
        statistics.last_sampled = conversion.sampled;
        self.control = self.control & !ERR | if self.failing { ERR | ERR_STICKY } else { 0 };
        if self.fifo_control & FIFO_EN != 0 {
            if self.fifo.len() == FIFO_DEPTH {
                self.fifo_control |= OVER;
            } else {
                let shift = if self.fifo_control & SHIFT != 0 { 4 } else { 0 };
                let marked = self.failing && self.fifo_control & ERR_IN_FIFO != 0;
                self.fifo.push_back(conversion.value >> shift | if marked { ENTRY_ERR } else { 0 });
            }
        }
        self.select_next_channel();
    }

    /// Round robin: AINSEL goes to the next channel in RROBIN.
    fn select_next_channel(&mut self) {
        let round_robin = self.control >> 16 & 0x1f;
        let current = self.channel();
        let next = (1..=CHANNELS).map(|step| (current + step) % CHANNELS).find(|c| round_robin >> c & 1 != 0);
        if let Some(next) = next {
            self.control = self.control & !AINSEL | (next as u32) << 12;
        }
    }

    /// The interrupt line.
    pub fn interrupt(&self) -> bool {
        self.raw_interrupt() & self.interrupt_enable | self.interrupt_force != 0
    }

    /// DMA request: the FIFO holds at least THRESH entries, and at least one.
    pub fn request(&self) -> bool {
        self.fifo_control & DREQ_EN != 0 && self.fifo.len() >= self.threshold().max(1)
    }
}
