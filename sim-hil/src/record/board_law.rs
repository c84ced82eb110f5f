//! A board as far as a recording needs it.

use crate::plant::CHANNELS_PER_BOARD;

/// Samples in and drives out once a loop, commands in and pressures out once an exchange. Times are
/// nanoseconds since the start and do not run backwards.
pub trait BoardLaw {
    /// One loop: takes the four samples (12-bit counts) and computes the four drives, -1 (vent) to
    /// 1 (fill).
    fn step(&mut self, now_ns: u64, samples12: [u16; CHANNELS_PER_BOARD]) -> [f64; CHANNELS_PER_BOARD];

    /// One exchange: takes new set points and answers the pressures of the last loop, both 10-bit
    /// counts. There is a loop before the first exchange.
    fn exchange(&mut self, now_ns: u64, commands10: [u16; CHANNELS_PER_BOARD]) -> [u16; CHANNELS_PER_BOARD];
}
